"""Threads that wait actively: every action is done once, by the time that the call returns, however they wait."""

import gc
import random
import threading
import time
from functools import partial

import pytest

from warpvec.rendering.launch import start_warp
from warpvec.rendering.thread_pool import ThreadPool


@pytest.fixture(params=[True, False], ids=["active", "asleep"])
def make_pool(request):
    start_warp()
    return lambda count: ThreadPool(count, wait_actively=request.param)


def names():
    return [thread for thread in threading.enumerate() if thread.name == "warpvec"]


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
    # A helper looks for work for 2 ms and then sleeps; a caller looks for the end for 0.3 ms.
    pool, chance, done = make_pool(2), random.Random(0), [0, 0, 0]

    def act(k, seconds):
        time.sleep(seconds)
        done[k] += 1

    for _ in range(120):
        seconds = [chance.choice((0.0, 0.0001, 0.001, 0.004)) for _ in range(3)]
        pool.call([lambda k=k, s=s: act(k, s) for k, s in enumerate(seconds)])
        time.sleep(chance.choice((0.0, 0.0, 0.001, 0.003)))
    assert done == [120, 120, 120]


@pytest.mark.parametrize("who", [0, 1, 2])
def test_an_error_is_raised_once_all_are_done(make_pool, who):
    pool, done = make_pool(2), []

    def act(k):
        if k == who:
            raise ZeroDivisionError(str(k))
        time.sleep(0.005)
        done.append(k)

    with pytest.raises(ZeroDivisionError, match=str(who)):
        pool.call([lambda k=k: act(k) for k in range(3)])
    assert sorted(done) == sorted({0, 1, 2} - {who})
    pool.call([lambda: done.append(7)] * 3)
    assert done.count(7) == 3


def test_threads_end_with_their_crew_and_hold_nothing_of_its_work(make_pool):
    before = len(names())
    pool = make_pool(3)
    assert len(names()) == before + 3
    payload = threading.Event()
    pool.call([payload.is_set] * 4)
    held = [holder for holder in gc.get_referrers(payload) if getattr(holder, "__name__", "") == "is_set"]
    assert not held
    del pool
    gc.collect()
    deadline = time.monotonic() + 5.0
    while len(names()) > before and time.monotonic() < deadline:
        time.sleep(0.01)
    assert len(names()) == before
