"""The order of torch's and Warp's work on a GPU, and how far the host runs ahead of it.

A GPU works through a stream in order, but not through two streams, unless one is told to wait for the other. Torch and
Warp each have a current stream.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import torch
import warp as wp

from warpvec.rendering.launch import start_warp

STEPS_AHEAD = 2
"""Number of steps that a `StepQueue` lets wait on a GPU. While it does one, the next is ready."""


@contextmanager
def on_warps_stream(device: str) -> Iterator[None]:
    """Let torch work on Warp's stream of ``device``; do nothing on the CPU.

    Warp's stream waits for the caller's at the start, and the caller's for Warp's at the end. Torch joins Warp, not the
    other way round, because a CUDA graph cannot be recorded on torch's default stream. Memory that torch frees is then
    reused only after the kernels that Warp has queued before.
    """
    start_warp()
    if not wp.get_device(device).is_cuda:
        yield
        return
    stream = wp.stream_to_torch(device)
    caller = torch.cuda.current_stream(stream.device)
    stream.wait_stream(caller)
    try:
        with torch.cuda.stream(stream):
            yield
    finally:
        caller.wait_stream(stream)


class StepQueue:
    """The steps that wait on a GPU. The host's clock tells their pace only if there are few.

    Args:
        device: the device that the steps run on; on the CPU no step waits.
    """

    def __init__(self, device: str) -> None:
        self._is_used = device != "cpu"
        self._ends: deque[Any] = deque()

    def add(self) -> None:
        """Note that a step has been launched, and wait until at most ``STEPS_AHEAD`` are not done."""
        if self._is_used:
            end: Any = torch.cuda.Event()  # type: ignore[no-untyped-call]
            end.record()
            self._ends.append(end)
            self.wait(STEPS_AHEAD)

    def wait(self, left: int = 0) -> None:
        """Wait until at most ``left`` steps are not done."""
        while len(self._ends) > left:
            self._ends.popleft().synchronize()
