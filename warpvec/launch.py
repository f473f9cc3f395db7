"""Launching kernels: on CUDA as they are, on the CPU shared among threads; and buffers that grow on demand.

Warp runs a CPU launch on the calling thread and releases the GIL, so a launch is cut into chunks of work items that
several Python threads take in turn. A kernel's work items write disjoint slots, so the result does not depend on how
they were shared out.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from itertools import count
from typing import Any

import torch
import warp as wp

from warpvec.errors import InputError

# Fewer items than this a chunk cost more in hand-over (about 20 us) than a second thread saves.
_CHUNK_ITEMS_MIN = 64
# Chunks per thread: enough that one slow chunk leaves little idle time at the end, few enough to launch cheaply.
_CHUNKS_PER_THREAD = 6


@cache
def start_warp() -> None:
    """Initialise Warp in silence; nothing but our own lines belongs on the user's terminal."""
    wp.config.log_level = wp.LOG_ERROR
    with _silent_native_stderr():
        wp.init()


@contextmanager
def _silent_native_stderr() -> Iterator[None]:
    # Without a GPU driver Warp's native code prints a warning that no setting of Warp's silences.
    kept, sink = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(sink)


def resolve_device(name: str) -> str:
    """A Warp device, "cpu" or "cuda:K", for "auto" (the first GPU, else the CPU), "cpu", "cuda" or "cuda:K".

    Raises:
        InputError: no such device.
    """
    start_warp()
    # Both sides of the bridge must see a GPU for it to be of use.
    gpu_count = wp.get_cuda_device_count() if torch.cuda.is_available() else 0
    devices = ["cpu", *(f"cuda:{k}" for k in range(gpu_count))]
    wanted = {"auto": devices[min(gpu_count, 1)], "cuda": "cuda:0"}.get(name, name)
    if wanted not in devices:
        raise InputError(f"device must be auto or one of {', '.join(devices)} on this machine, got {name!r}")
    return wanted


class Launcher:
    """Launches kernels on one device, on ``threads`` CPU threads (all cores if None)."""

    def __init__(self, device: str, threads: int | None = None) -> None:
        self.device = wp.get_device(device)
        self.threads = 1 if self.device.is_cuda else threads or os.cpu_count() or 1
        self._pool = ThreadPoolExecutor(self.threads - 1) if self.threads > 1 else None

    def chunk_items(self, item_count: int) -> int:
        """Work items per chunk of a shared launch."""
        return max(_CHUNK_ITEMS_MIN, -(-item_count // (self.threads * _CHUNKS_PER_THREAD)))

    def __call__(self, kernel: Any, item_count: int, arguments: list[Any], chunk: int | None = None) -> None:
        """Run ``kernel`` over ``item_count`` items; its first argument, the first item, is added here."""
        if item_count == 0:
            return
        chunk = chunk or self.chunk_items(item_count)
        if self._pool is None or item_count <= chunk:
            self._launch(kernel, 0, item_count, arguments)
            return
        self._share(
            lambda first: self._launch(kernel, first, min(chunk, item_count - first), arguments), item_count, chunk
        )

    def _launch(self, kernel: Any, first: int, item_count: int, arguments: list[Any]) -> None:
        wp.launch(kernel, dim=item_count, inputs=[first, *arguments], device=self.device, record_tape=False)

    def _share(self, run: Callable[[int], None], item_count: int, chunk: int) -> None:
        assert self._pool is not None
        turns = count()

        def work() -> None:
            while (first := next(turns) * chunk) < item_count:
                run(first)

        helpers = [self._pool.submit(work) for _ in range(self.threads - 1)]
        work()
        for helper in helpers:
            helper.result()


class Buffers:
    """Named Warp arrays that keep their memory between steps and grow when a scene outgrows them."""

    # Growth beyond what is needed, so that a slowly growing scene does not reallocate at every step.
    _HEADROOM = 1.25

    def __init__(self, device: Any) -> None:
        self._device = device
        self._arrays: dict[str, wp.array] = {}

    def get(self, name: str, shape: int | tuple[int, ...], dtype: Any) -> wp.array:
        """An array of at least ``shape`` along its first axis, equal to it along the others; contents are stale."""
        shape = (shape,) if isinstance(shape, int) else shape
        array = self._arrays.get(name)
        if array is None or array.shape[0] < shape[0] or array.shape[1:] != shape[1:]:
            capacity = (int(shape[0] * self._HEADROOM) + 1, *shape[1:])
            array = wp.zeros(capacity, dtype=dtype, device=self._device)
            self._arrays[name] = array
        return array

    @property
    def byte_count(self) -> int:
        """Memory held, in bytes."""
        return sum(array.capacity for array in self._arrays.values())


def exclusive_scan(buffers: Buffers, name: str, counts: wp.array, count_: int) -> tuple[wp.array, int]:
    """Exclusive sums of ``counts[: count_]`` and their total, which is entry ``count_`` of the result."""
    sums = buffers.get(name, count_ + 1, wp.int32)
    wp.utils.array_scan(counts[: count_ + 1], sums[: count_ + 1], inclusive=False)
    return sums, int(sums[count_ : count_ + 1].numpy()[0])


def as_warp(tensor: torch.Tensor, dtype: Any) -> Any:
    """A Warp array of ``dtype`` over the memory of a contiguous tensor, outside autograd."""
    return wp.from_torch(tensor.detach().contiguous(), dtype=dtype)
