"""Launches shared among threads run each item once and raise errors; buffers grow as needed."""

import gc
import re
import threading
import weakref

import numpy as np
import pytest
import torch
import warp as wp
from svg_files import make_scene

from warpvec.config.fit_config import FitConfig
from warpvec.config.limits import MAX_THREADS
from warpvec.errors import InputError
from warpvec.rendering import launch as launching
from warpvec.rendering import thread_pool
from warpvec.rendering.launch import (
    Buffers,
    Launcher,
    as_warp,
    check_total,
    exclusive_scan,
    read_total,
    resolve_device,
    start_warp,
    whole_arrays,
)
from warpvec.rendering.operator import render

COUNTS = [0, 1, 2, 63, 64, 65, 127, 129, 5000]

_MODULE = wp.get_module("test_launch")


@wp.kernel(module=_MODULE)
def count_visits(first: int, weight: int, out: wp.array(dtype=int)):
    item = first + wp.tid()
    out[item] = out[item] + weight


@pytest.fixture(autouse=True)
def warp() -> None:
    start_warp()


@pytest.mark.parametrize("item_count", COUNTS)
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_each_item_is_visited_once(item_count: int, threads: int) -> None:
    launch = Launcher("cpu", threads)
    out = wp.zeros(item_count + 100, dtype=int, device="cpu")
    launch(count_visits, item_count, [1, out])
    launch.shared(count_visits, item_count, [10, out])
    np.testing.assert_array_equal(out.numpy()[:item_count], 11)
    assert not out.numpy()[item_count:].any()


@pytest.mark.parametrize("chunk", [1, 7, 64, 200])
@pytest.mark.parametrize("threads", [1, 3])
def test_any_chunk_will_do(chunk: int, threads: int) -> None:
    out = wp.zeros(200, dtype=int, device="cpu")
    Launcher("cpu", threads).shared(count_visits, 199, [1, out], chunk)
    assert out.numpy().tolist() == [1] * 199 + [0]


@pytest.mark.parametrize("threads", [1, 3])
def test_arguments_of_one_call_are_not_those_of_the_last(threads: int) -> None:
    launch = Launcher("cpu", threads)
    arrays = [wp.zeros(300, dtype=int, device="cpu") for _ in range(3)]
    for weight, array in enumerate(arrays, 1):
        launch.shared(count_visits, 300, [1000 * weight, array])
    launch.shared(count_visits, 100, [7, arrays[0]])
    assert arrays[0].numpy().tolist() == [1007] * 100 + [1000] * 200
    assert set(arrays[1].numpy().tolist()) == {2000} and set(arrays[2].numpy().tolist()) == {3000}


def test_arrays_of_equal_shapes_have_their_own_memory() -> None:
    first, second = torch.zeros(3), torch.ones(3)
    found = [as_warp(each, wp.float32) for each in (first, second)]
    assert [each.data for each in found] == [first.data_ptr(), second.data_ptr()]
    assert as_warp(torch.full((3,), 2.0), wp.float32)._ref.tolist() == [2.0, 2.0, 2.0]  # kept, as nobody else does


@pytest.mark.parametrize("threads", [1, 3])
def test_chunks_are_few_and_cover_all_items(threads: int) -> None:
    launch = Launcher("cpu", threads)
    for item_count in COUNTS[1:]:
        chunk = launch.chunk_items(item_count)
        assert chunk >= 64 or chunk >= item_count
        assert -(-item_count // chunk) <= 8 * threads


def test_an_error_on_a_thread_reaches_the_caller(monkeypatch: pytest.MonkeyPatch) -> None:
    launch = Launcher("cpu", 3)
    with pytest.raises(Exception, match="out"):
        launch.shared(count_visits, 1000, [1, "not an array"])


def test_threads_default_to_all_cores_and_are_one_on_a_gpu(device: str) -> None:
    assert Launcher(device).threads >= 1
    assert Launcher("cpu", 5).threads == 5
    assert device == "cpu" or Launcher(device, 5).threads == 1


def test_a_buffer_keeps_its_memory_until_it_is_outgrown() -> None:
    buffers = Buffers("cpu")
    first = buffers.get("a", 100, wp.float32)
    assert first.shape[0] >= 100
    assert buffers.get("a", 3, wp.float32) is first and buffers.get("a", 100, wp.float32) is first
    larger = buffers.get("a", 1000, wp.float32)
    assert larger is not first and larger.shape[0] >= 1000
    assert buffers.get("b", 10, wp.float32) is not larger
    assert buffers.growth == 3
    outgrown = weakref.ref(first)
    del first
    gc.collect()
    assert outgrown() is None


def test_a_buffer_has_its_other_axes_as_asked() -> None:
    buffers = Buffers("cpu")
    assert buffers.get("a", (10, 5), wp.float32).shape[1:] == (5,)
    assert buffers.get("a", (4, 6), wp.float32).shape[1:] == (6,)
    assert buffers.get("empty", 0, wp.int32).shape[0] >= 0


def test_a_view_shows_a_tensor_as_it_is_now(device: str) -> None:
    buffers = Launcher(resolve_device(device)).make_buffers()

    def seen(tensor: torch.Tensor) -> list[float]:
        with whole_arrays():
            return buffers.view("values", tensor, wp.float32).numpy().tolist()

    values = torch.arange(6.0, device=device)
    assert seen(values) == values.tolist()
    values += 1.0
    assert seen(values) == values.tolist()
    other = torch.arange(6.0, device=device) + 7.0
    assert seen(other) == other.tolist()
    apart = other[::2]  # its copy must be a new one each time
    assert seen(apart) == apart.tolist()
    other += 1.0
    assert seen(apart) == apart.tolist()


def test_a_view_of_the_same_tensor_is_the_same_object() -> None:
    buffers, values = Launcher("cpu").make_buffers(), torch.arange(6.0)
    first = buffers.view("values", values, wp.float32)
    assert buffers.view("values", values, wp.float32) is first
    with whole_arrays():  # which the recording of a graph needs
        assert isinstance(buffers.view("values", values, wp.float32), wp.array)


def test_a_view_keeps_no_graph_of_autograd() -> None:
    buffers = Launcher("cpu").make_buffers()
    seed = torch.ones(3, requires_grad=True)
    factor = torch.full((3,), 2.0)
    product, kept = seed * factor, weakref.ref(factor)
    buffers.view("values", product, wp.float32)
    del product, factor
    assert kept() is None


def test_the_front_of_an_array_is_that_of_its_present_length() -> None:
    buffers = Launcher("cpu").make_buffers()
    array = buffers.get("values", 8, wp.int32)
    front = buffers.front("values", array, 5)
    assert buffers.front("values", array, 5) is front and front.shape == (5,)
    assert buffers.front("values", array, 6).shape == (6,)
    larger = buffers.get("values", 80, wp.int32)
    assert buffers.front("values", larger, 6).ptr == larger.ptr


def test_a_buffer_that_kernels_cannot_index_is_refused() -> None:
    rule = "scene is too large for the renderer (pair_key needs 2,147,483,648 of at most 2,147,483,647 entries); fit at"
    with pytest.raises(InputError, match=re.escape(rule)):
        Buffers("cpu").get("pair_key", 2**31, wp.int64)


def test_a_launch_of_more_items_than_kernels_can_index_is_refused() -> None:
    with pytest.raises(InputError, match="scene is too large for the renderer"):
        Launcher("cpu", 1)(count_visits, 2**31, [1, wp.zeros(1, dtype=int, device="cpu")])


@pytest.mark.parametrize("is_read", [True, False])
def test_a_sum_is_refused_only_if_a_scan_would_wrap_around(is_read: bool, device: str) -> None:
    largest = 2**31 - 1
    counts = wp.array([largest - 5, 3, 3, 9], dtype=wp.int32, device=device)
    if is_read:
        check_total("counts", counts, 2, largest)
    check_total("counts", counts, 1, largest, is_read)
    with pytest.raises(InputError, match="counts needs" + " 2,147,483,648 of" * is_read):
        check_total("counts", counts, 3, largest, is_read)


@pytest.mark.parametrize("count", [0, 1, 2, 1000])
def test_exclusive_scan_ends_in_the_total(count: int, device: str) -> None:
    buffers = Buffers(device)
    values = np.random.default_rng(1).integers(0, 9, count + 5).astype(np.int32)
    sums = exclusive_scan(buffers, "sums", wp.array(values, dtype=wp.int32, device=device), count)
    assert read_total(sums, count) == values[:count].sum()
    np.testing.assert_array_equal(sums.numpy()[: count + 1], np.concatenate([[0], values[:count].cumsum()]))


def test_device_names() -> None:
    assert resolve_device("cpu") == "cpu"
    assert resolve_device("auto") in ("cpu", "cuda:0")


@pytest.mark.parametrize("name", ["gpu", "", "cuda:99", "cuda:-1", "CPU"])
def test_an_unknown_device_is_named_in_one_line(name: str) -> None:
    with pytest.raises(InputError) as caught:
        resolve_device(name)
    message = str(caught.value)
    assert "\n" not in message and message.startswith("device must be auto or one of cpu") and repr(name) in message


def test_a_gpu_is_refused_in_a_forked_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 1)
    monkeypatch.setattr(wp, "get_cuda_device_count", lambda: 1)
    monkeypatch.setattr(launching, "start_warp", lambda: 0)  # Warp was started by the process 0
    for name in ("auto", "cuda", "cuda:0"):
        with pytest.raises(
            InputError, match=f"device must be cpu in a process that was forked .*, got '{name}'; give cpu"
        ):
            resolve_device(name)
    assert resolve_device("cpu") == "cpu"


def test_more_threads_than_the_cores_have_use_for_are_not_started(monkeypatch) -> None:
    monkeypatch.setattr(thread_pool, "core_count", lambda: 2)
    before = threading.active_count()
    launch = Launcher("cpu", MAX_THREADS)
    assert threading.active_count() - before < 8
    out = wp.zeros(5000, dtype=int, device="cpu")
    launch.shared(count_visits, 5000, [1, out], 64)
    assert (out.numpy() == 1).all()
    scene = make_scene(4, size=(32, 32))
    assert torch.equal(render(scene, 32, 32, threads=MAX_THREADS), render(scene, 32, 32, threads=1))
    for refused in (lambda: render(scene, 32, 32, threads=10**30), lambda: FitConfig(threads=MAX_THREADS + 1)):
        with pytest.raises(InputError, match="threads must be a whole number from 1 to"):
            refused()
