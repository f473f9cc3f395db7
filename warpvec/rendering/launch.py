"""Launch kernels, on the CPU shared among threads, and keep buffers that grow on demand.

Warp runs a CPU launch on the calling thread and releases the GIL. A launch is therefore cut into chunks of work items,
which several Python threads take in turn; on a busy machine fewer threads do (``thread_choice.py``). The work items of
a kernel that threads share write disjoint entries, so the result does not depend on which thread ran which item.

Importing this module has a side effect: in every process that is then forked from this one, torch runs on one thread.
"""

from __future__ import annotations

import ctypes
import logging
import os
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial, wraps
from typing import Any, ParamSpec, TypeVar

import torch
import warp as wp

from warpvec.errors import InputError
from warpvec.kernels.constants import TILE
from warpvec.kernels.making import made_once, making
from warpvec.rendering.capacity import Capacity
from warpvec.rendering.devices import gpu_count, why_no_gpu
from warpvec.rendering.kernel_cache import init_warp
from warpvec.rendering.thread_choice import Launch, ThreadChoice
from warpvec.rendering.thread_pool import ThreadPool, core_count, usable_threads

# A smaller chunk is done before a second thread can start on its own.
_CHUNK_ITEMS_MIN = 64
# Kernels index with 32-bit integers.
_ENTRIES_MAX = 2**31
# Numbers of items of which a command keeps the bounds.
_BOUNDS_MAX = 256
# Enough chunks per thread that one slow chunk leaves little idle time at the end, and few enough to launch cheaply.
_CHUNKS_PER_THREAD = 4

_Arguments = ParamSpec("_Arguments")
_Made = TypeVar("_Made")

# OpenMP's threads do not exist in a forked process, where torch would wait for them for ever.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=partial(torch.set_num_threads, 1))


@made_once  # type: ignore[untyped-decorator]
def start_warp() -> int:
    """Initialise Warp, once; return the id of the process that did.

    Nothing is printed, but for a line about a folder for compiled kernels that cannot be written.
    """
    wp.config.log_level = wp.LOG_ERROR
    with _silent_native_stderr():
        message = init_warp()
    if message is not None:
        logging.getLogger("warpvec").warning("%s", message)
    return os.getpid()


@contextmanager
def _silent_native_stderr() -> Iterator[None]:
    # Without a GPU driver Warp's native code prints a warning that no setting of Warp silences.
    try:
        kept = os.dup(2)
    except OSError:  # stderr is closed: there is nothing to silence
        yield
        return
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(sink)


def resolve_device(name: str) -> str:
    """Return the Warp device, "cpu" or "cuda:K", for "auto" (the first GPU, else the CPU), "cpu", "cuda" or "cuda:K".

    Raises:
        InputError: there is no such device, or it is a GPU and this process was forked after Warp started.
    """
    process = start_warp()
    usable = gpu_count()
    devices = ["cpu", *(f"cuda:{k}" for k in range(usable))]
    wanted = {"auto": devices[min(usable, 1)], "cuda": "cuda:0"}.get(name, name)
    if wanted not in devices:
        rule = f"must be auto or one of {', '.join(devices)} on this machine"
        wants_gpu = not usable and name.startswith("cuda")
        remedy = f"give one of these: {why_no_gpu()}" if wants_gpu else "give one of these"
        raise InputError("device", rule, repr(name), remedy)
    if wanted != "cpu" and process != os.getpid():
        rule = (
            "must be cpu in a process that was forked after warpvec had started, because CUDA does not survive a fork"
        )
        raise InputError("device", rule, repr(name), 'give cpu, or start processes with the method "spawn"')
    return wanted


def once_per_thread(make: Callable[_Arguments, _Made]) -> Callable[_Arguments, _Made]:
    """Keep what ``make`` returns for each set of arguments, for each thread: two threads must not share a launcher.

    Their launches would set each other's arguments.
    """
    local = threading.local()

    @wraps(make)
    def made(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Made:
        if not hasattr(local, "kept"):
            local.kept = cache(make)
        found: _Made = local.kept(*args, **kwargs)
        return found

    return made


class Launcher:
    """Launches kernels on one device, on ``threads`` CPU threads (all cores if None; see `usable_threads`).

    Attributes:
        capacity: how much a step may make.
    """

    def __init__(self, device: str, threads: int | None = None) -> None:
        self.device = wp.get_device(device)
        self.capacity = Capacity(self.device)
        self.threads = 1 if self.device.is_cuda else usable_threads(threads)
        self._pool = ThreadPool(self.threads - 1, self.threads <= core_count()) if self.threads > 1 else None
        self._choice = ThreadChoice(self.threads)
        self._commands: dict[Any, list[_Command]] = {}
        self._all_buffers: list[Buffers] = []

    def make_buffers(self) -> Buffers:
        """Make buffers on the device; their growth counts in ``growth``."""
        self._all_buffers.append(Buffers(self.device))
        return self._all_buffers[-1]

    @property
    def growth(self) -> int:
        """Number of times a buffer has been allocated; while it stays the same, so do all pointers."""
        return sum(buffers.growth for buffers in self._all_buffers)

    def chunk_items(self, item_count: int) -> int:
        """Return the number of work items per chunk of a shared launch."""
        return max(_CHUNK_ITEMS_MIN, -(-item_count // (self.threads * _CHUNKS_PER_THREAD)))

    def __call__(self, kernel: Any, item_count: int, arguments: list[Any]) -> None:
        """Run a light ``kernel`` on this thread, with the number of items as first argument, then ``arguments``."""
        if item_count > 0:
            self._run(kernel, item_count, arguments, item_count)

    def shared(
        self, kernel: Any, item_count: int, arguments: list[Any], chunk: int | None = None, first: int = 0
    ) -> None:
        """Run a heavy ``kernel`` on ``item_count`` items from ``first`` on, shared among the threads.

        Each thread takes ``chunk`` items at a time.
        """
        if item_count > 0:
            self._run(kernel, item_count, arguments, chunk or self.chunk_items(item_count), first)

    def _run(self, kernel: Any, item_count: int, arguments: list[Any], chunk: int, first: int = 0) -> None:
        check_entries("a launch", first + item_count)
        chunk_count = -(-item_count // chunk)
        is_shared = min(self.threads, chunk_count) > 1
        thread_count = min(self._choice.count, chunk_count) if is_shared else 1
        is_recorded = bool(_are_whole)
        commands = self._commands.setdefault((kernel, is_recorded), [])
        commands += [_Command(kernel, arguments, self.device, is_recorded) for _ in range(thread_count - len(commands))]
        for command in commands:
            command.update(arguments)
        if is_shared:
            self._share(kernel, commands[:thread_count], item_count, chunk, first)
        else:
            commands[0].run(first, item_count)

    def _share(self, kernel: Any, commands: list[_Command], item_count: int, chunk: int, first: int) -> None:
        assert self._pool is not None
        chunk = chunk if len(commands) > 1 else item_count
        spent, had = [0.0] * len(commands), [0.0] * len(commands)  # seconds of each thread, and those with a core
        starts = iter(range(0, item_count, chunk))

        def work(number: int) -> None:
            wall, cpu = time.perf_counter(), time.thread_time()
            # Taking from an iterator is one step of the interpreter, so no two threads take the same chunk.
            for start in starts:
                commands[number].run(first + start, min(chunk, item_count - start))
            spent[number], had[number] = time.perf_counter() - wall, time.thread_time() - cpu

        began = time.perf_counter()
        if len(commands) == 1:
            work(0)
        else:
            self._pool.call([partial(work, number) for number in range(len(commands))])
        self._choice.record(Launch(kernel, item_count, time.perf_counter() - began, sum(spent), sum(had)))


class _Command:
    """A recorded launch. Setting the arguments that changed costs a tenth of packing all of them again.

    On the CPU the compiled function is called with one structure of arguments that stays: Warp makes a new one for each
    launch, which takes longer than many kernels run. A launch that a graph records is Warp's.
    """

    def __init__(self, kernel: Any, arguments: list[Any], device: Any, is_recorded: bool) -> None:
        inputs = [0, *arguments]
        # One block per tile where a work item is a pixel: sums over a tile need whole warps.
        with making:  # the first launch of a kernel loads its module
            self._launch = wp.launch(
                kernel, dim=1, inputs=inputs, device=device, block_dim=TILE * TILE, record_tape=False, record_cmd=True
            )
        self._arguments = list(arguments)
        self._range = (0, 1)
        # Several items a block, which only tests of Warp's blocks on the CPU have, are left to Warp.
        is_direct = device.is_cpu and self._launch.block_dim == 1 and not is_recorded
        self._packed = _packed(self._launch.params[1:]) if is_direct else None
        self._names = () if self._packed is None else tuple(name for name, _ in self._packed._fields_)
        self._bounds: dict[int, Any] = {}

    def update(self, arguments: list[Any]) -> None:
        for index, (before, now) in enumerate(zip(self._arguments, arguments, strict=True)):
            if before is not now:
                self._set(index + 1, now)
                self._arguments[index] = now

    def _set(self, index: int, value: Any) -> None:
        packed = self._packed
        is_descriptor = isinstance(value, ctypes.Structure)  # of an array, which needs no packing
        if packed is None:
            if is_descriptor:
                self._launch.set_param_at_index_from_ctype(index, value)
            else:
                self._launch.set_param_at_index(index, value)
        elif is_descriptor or type(value) is int:
            setattr(packed, self._names[index], value)
        else:
            self._launch.set_param_at_index(index, value)
            setattr(packed, self._names[index], self._launch.params[index + 1])

    def run(self, first: int, item_count: int) -> None:
        first_before, count_before = self._range
        if first != first_before:
            self._set(0, first)
        self._range = (first, item_count)
        if self._packed is not None:
            self._launch.hooks.forward(ctypes.byref(self._bounds_of(item_count)), ctypes.byref(self._packed))
            return
        if item_count != count_before:
            self._launch.set_dim(item_count)
        self._launch.launch()

    def _bounds_of(self, item_count: int) -> Any:
        """Return Warp's bounds of so many items, which are kept: drawings of a fit launch the same counts."""
        found = self._bounds.get(item_count)
        if found is None:
            if len(self._bounds) >= _BOUNDS_MAX:
                self._bounds.clear()
            self._launch.set_dim(item_count)
            found = self._bounds[item_count] = self._launch.bounds
        return found


def _packed(values: list[Any]) -> Any:
    """Return a structure of the packed arguments of a kernel, in their order."""
    kind = _structure_of(tuple(type(value) for value in values))
    return kind(*values)


@cache
def _structure_of(types: tuple[Any, ...]) -> Any:
    return type("Packed", (ctypes.Structure,), {"_fields_": [(f"at{k}", each) for k, each in enumerate(types)]})


class Buffers:
    """Named Warp arrays that keep their memory between steps and grow when a scene outgrows them.

    Attributes:
        growth: number of arrays made so far.
    """

    # Allocates more than is needed, so that a slowly growing scene does not reallocate at every step.
    _HEADROOM = 1.25

    def __init__(self, device: Any) -> None:
        self._device = device
        self._arrays: dict[str, wp.array] = {}
        self._fronts: dict[str, tuple[wp.array, wp.array]] = {}
        self._views: dict[str, tuple[weakref.ref[torch.Tensor], tuple[int, bool], Any]] = {}
        self.growth = 0

    def get(self, name: str, shape: int | tuple[int, ...], dtype: Any) -> wp.array:
        """Return an array at least as long as ``shape`` in its first axis and equal in the others, with stale values.

        Raises:
            InputError: kernels cannot index that many entries.
            RuntimeError: there is not enough memory.
        """
        shape = (shape,) if isinstance(shape, int) else shape
        array = self._arrays.get(name)
        check_entries(name, shape[0])
        if array is None or array.shape[0] < shape[0] or array.shape[1:] != shape[1:]:
            capacity = (min(int(shape[0] * self._HEADROOM) + 1, _ENTRIES_MAX - 1), *shape[1:])
            try:
                array = wp.zeros(capacity, dtype=dtype, device=self._device)
            except RuntimeError:  # torch may keep memory of a GPU that it does not use
                torch.cuda.empty_cache()
                array = wp.zeros(capacity, dtype=dtype, device=self._device)
            self._arrays[name] = array
            self.growth += 1
        return array

    def front(self, name: str, array: wp.array, count: int) -> wp.array:
        """Return the first ``count`` entries of ``array``: the same object as last time if both were the same."""
        kept, front = self._fronts.get(name, (None, None))
        if front is None or kept is not array or front.shape[0] != count:
            front = array[:count]
            self._fronts[name] = array, front
        return front

    def view(self, name: str, tensor: torch.Tensor, dtype: Any, *shape: int) -> Any:
        """Return ``tensor`` in ``shape`` as a Warp array: the same object as last time if the tensor was the same.

        So no array is made, and no argument set, for a tensor that stays. The memory is kept until the next call with
        this name, but no graph of autograd.
        """
        found, form = self._views.get(name), (tensor.data_ptr(), bool(_are_whole))
        # The copy of a tensor that is not contiguous must be made anew each time.
        if found is None or found[0]() is not tensor or found[1] != form or not tensor.is_contiguous():
            found = weakref.ref(tensor), form, as_warp(tensor.reshape(shape) if shape else tensor, dtype)
            self._views[name] = found
        return found[2]


def check_entries(name: str, count: int) -> None:
    """Refuse an array, or a launch, of ``count`` entries if kernels cannot index that many.

    Raises:
        InputError: they cannot.
    """
    if count >= _ENTRIES_MAX:
        size = f"{name} needs {count:,} of at most {_ENTRIES_MAX - 1:,} entries"
        remedy = "fit at a smaller size, with fewer curves or, for splat, fewer samples"
        raise InputError("scene", f"is too large for the renderer ({size})", None, remedy)


def check_total(name: str, counts: wp.array, item_count: int, largest: int, is_read: bool = True) -> None:
    """Refuse counts whose sum is no 32-bit integer, because a scan of them would wrap around.

    Most scenes cannot reach that sum, however their paths lie. Only for others the counts are added up.

    Args:
        name: what is counted, for the message.
        counts: [item_count] or more.
        item_count: number of counts.
        largest: the largest value that a count can have.
        is_read: whether the host may read the counts; if not, a sum that could be too large is refused.

    Raises:
        InputError: the sum is too large.
    """
    bound = item_count * largest
    if bound >= _ENTRIES_MAX and is_read:
        bound = int(wp.to_torch(counts)[:item_count].sum(dtype=torch.int64))
    check_entries(name, bound)


def exclusive_scan(buffers: Buffers, name: str, counts: wp.array, item_count: int) -> wp.array:
    """Return the exclusive sums of ``counts[:item_count]``; entry ``item_count`` is the total."""
    sums = buffers.get(name, item_count + 1, wp.int32)
    counted, summed = (buffers.front(*each, item_count + 1) for each in ((f"counted {name}", counts), (name, sums)))
    wp.utils.array_scan(counted, summed, inclusive=False)
    return sums


def read_total(sums: wp.array, item_count: int) -> int:
    """Read entry ``item_count`` of ``sums``; on CUDA the host waits for it."""
    if sums.device is not None and sums.device.is_cpu:
        return int(sums.numpy()[item_count])
    return int(sums[item_count : item_count + 1].numpy()[0])


def as_warp(tensor: torch.Tensor, dtype: Any, *, whole: bool = False) -> Any:
    """Return an argument of a kernel over the memory of a contiguous tensor, outside autograd.

    It is a Warp array on a GPU, while a graph is recorded, or if ``whole`` asks for one. Else it is the descriptor of
    an array, which takes a fifth of the time to make.
    """
    plain = tensor.detach().contiguous()
    if whole or _are_whole or plain.is_cuda:
        return wp.from_torch(plain, dtype=dtype)
    kind = dtype, plain.dtype, plain.shape
    template: Any = _templates.get(kind)
    if template is None:
        if len(_templates) >= _TEMPLATES_MAX:
            _templates.clear()
        template = _templates[kind] = wp.from_torch(plain, dtype=dtype, return_ctype=True)
        del template._ref  # it is of use without its memory
    found = type(template).from_buffer_copy(template)
    found.data = plain.data_ptr()
    found._ref = plain  # keeps the memory
    return found


_TEMPLATES_MAX = 4096
_templates: dict[tuple[Any, torch.dtype, torch.Size], Any] = {}
"""Descriptors of contiguous tensors by type and shape: checking these takes five times as long as a copy."""

_are_whole: list[bool] = []


def is_recording() -> bool:
    """Return whether a graph is recorded: `as_warp` makes whole arrays."""
    return bool(_are_whole)


@contextmanager
def whole_arrays() -> Iterator[None]:
    """Let `as_warp` make whole arrays while a graph is recorded."""
    _are_whole.append(True)
    try:
        yield
    finally:
        _are_whole.pop()
