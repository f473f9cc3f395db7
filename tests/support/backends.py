"""Where and how kernels run in a test: the device, and the width of the lanes on it."""

from __future__ import annotations

from typing import NamedTuple

import torch
import warp as wp


class Backend(NamedTuple):
    """A device and a lane width; None stands for the width that renderers choose on the device."""

    device: str = "cpu"
    lane_width: int | None = None


VECTOR = Backend("cpu", 16)
"""Lanes of 16 pixels: what a CPU runs."""

SCALAR = Backend("cpu", 1)
"""The code that a GPU runs, on the CPU. Its lanes run one after another, so none sees the others of its tile."""

CUDA = Backend("cuda", 1)

BACKENDS = {"vector": VECTOR, "scalar": SCALAR, "cuda": CUDA}


def why_no_cuda() -> str | None:
    """Return why this machine cannot run CUDA tests, or None if it can."""
    if not torch.cuda.is_available():
        return "torch sees no CUDA device"
    if wp.get_cuda_device_count() == 0:
        return "warp sees no CUDA device"
    return None
