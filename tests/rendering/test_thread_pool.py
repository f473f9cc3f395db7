"""The thread pool: every action is done once, by the time that the call returns; it survives a fork."""

import gc
import os
import random
import signal
import sys
import threading
import time
from contextlib import suppress
from functools import partial

import pytest
from children import limit, start, wait_for

from warpvec.rendering.launch import start_warp
from warpvec.rendering.thread_pool import ThreadPool


@pytest.fixture(params=[True, False], ids=["active", "asleep"])
def make_pool(request):
    start_warp()
    return lambda count: ThreadPool(count, wait_actively=request.param)


def pool_threads():
    return {thread for thread in threading.enumerate() if thread.name == "warpvec"}


@pytest.mark.parametrize("count", [1, 2, 5])
def test_every_action_is_done_once_and_each_on_a_thread_of_its_own(make_pool, count):
    pool, seen = make_pool(count), []

    def act(call, k):
        seen.append((call, k, threading.get_ident()))

    for call in range(300):
        actions = [partial(act, call, k) for k in range(1 + call % (count + 1))]
        pool.call(actions)
        done = sorted((k, thread) for number, k, thread in seen if number == call)
        assert [k for k, _ in done] == list(range(len(actions)))
        assert len({thread for _, thread in done}) == len(actions)
        assert done[0][1] == threading.get_ident()


def test_shares_of_any_length_and_pauses_of_any_length_between_them(make_pool):
    # A thread waits actively for 2 ms and then sleeps; a caller waits actively for 0.3 ms.
    pool, chance, done = make_pool(2), random.Random(0), [0, 0, 0]

    def act(k, seconds):
        time.sleep(seconds)
        done[k] += 1

    for _ in range(120):
        seconds = [chance.choice((0.0, 0.0001, 0.001, 0.004)) for _ in range(3)]
        pool.call([lambda k=k, s=s: act(k, s) for k, s in enumerate(seconds)])
        time.sleep(chance.choice((0.0, 0.0, 0.001, 0.003)))
    assert done == [120, 120, 120]


@pytest.mark.parametrize("failing", [0, 1, 2])
def test_an_error_is_raised_once_all_are_done(make_pool, failing):
    pool, done = make_pool(2), []

    def act(k):
        if k == failing:
            raise ZeroDivisionError(str(k))
        time.sleep(0.005)
        done.append(k)

    with pytest.raises(ZeroDivisionError, match=str(failing)):
        pool.call([lambda k=k: act(k) for k in range(3)])
    assert sorted(done) == sorted({0, 1, 2} - {failing})
    pool.call([lambda: done.append(7)] * 3)
    assert done.count(7) == 3


def test_threads_end_with_their_pool_and_keep_no_reference_to_its_work(make_pool):
    before = pool_threads()
    pool = make_pool(3)
    threads = pool_threads() - before
    assert len(threads) == 3
    payload = threading.Event()
    pool.call([payload.is_set] * 4)
    held = [holder for holder in gc.get_referrers(payload) if getattr(holder, "__name__", "") == "is_set"]
    assert not held
    del pool
    gc.collect()
    wait_for(lambda: not pool_threads() & threads)


FORK = """
import multiprocessing
import torch
import warpvec
from scenes import random_scene
from warpvec.geometry.scene import Scene

def draw(_=None):
    # Large enough for torch and for the renderer to use two threads each.
    tensors = random_scene(1, 80, 300, 400)
    scene = Scene.uniform(*(tensor.float() for tensor in tensors[:4]), torch.zeros(80, dtype=torch.int64))
    photo = warpvec.render(scene, 300, 400, threads=2).numpy()
    return photo, warpvec.vectorize(photo, mode="photo", curves=16, iterations=4, threads=2).svg()

torch.set_num_threads(2)
photo, svg = draw()
with multiprocessing.get_context("fork").Pool(2) as pool:
    for other_photo, other_svg in pool.map(draw, range(2)):
        assert (other_photo == photo).all() and other_svg == svg
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")
def test_a_forked_process_draws_and_fits():
    paths = os.pathsep.join(sys.path)
    environment = {**os.environ, "PYTHONPATH": paths, "CUDA_VISIBLE_DEVICES": ""}
    # Its own session: if it hangs, its children are killed with it.
    process = start([sys.executable, "-c", FORK], env=environment, start_new_session=True)
    try:
        assert process.wait(timeout=limit(120)) == 0
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
