"""Which GPUs a fit can use, and why it uses none. Warp must have been started."""

from __future__ import annotations

import shutil
from pathlib import Path

import torch
import warp as wp

# Where Linux lists GPUs that have a driver, and all hardware.
_DRIVEN = Path("/proc/driver/nvidia/gpus")
_HARDWARE = Path("/sys/bus/pci/devices")
_NVIDIA, _DISPLAY = "0x10de", "0x03"

NO_HARDWARE = "there is no NVIDIA GPU"
"""The reason of `why_no_gpu` that calls for no action."""


def gpu_count() -> int:
    """Return the number of GPUs that both torch and Warp see."""
    return min(_torch_count(), int(wp.get_cuda_device_count()))


def why_no_gpu() -> str | None:
    """Return why fits run on the CPU where the device is "auto"; None if they run on a GPU."""
    torch_count, warp_count = _torch_count(), wp.get_cuda_device_count()
    if torch_count and warp_count:
        return None
    if torch_count:
        return "torch sees a GPU, but Warp sees none; its driver may be too old"
    if not warp_count and not has_nvidia_gpu():
        return NO_HARDWARE
    found = "Warp sees a GPU" if warp_count else "there is an NVIDIA GPU"
    lacks = "torch sees none" if warp_count else "it has no driver that works"
    return f"{found}, but {'torch was built without CUDA' if torch.version.cuda is None else lacks}"


def has_nvidia_gpu() -> bool:
    """Return whether the machine has an NVIDIA GPU, with or without a driver, as far as the system tells."""
    try:
        if _DRIVEN.is_dir():
            return any(_DRIVEN.iterdir())
        if _HARDWARE.is_dir():
            return any(map(_is_nvidia_gpu, _HARDWARE.iterdir()))
    except OSError:  # a container may hide them
        return False
    return shutil.which("nvidia-smi") is not None


def _is_nvidia_gpu(device: Path) -> bool:
    vendor, kind = ((device / name).read_text() for name in ("vendor", "class"))
    return vendor.strip() == _NVIDIA and kind.startswith(_DISPLAY)


def _torch_count() -> int:
    return torch.cuda.device_count() if torch.cuda.is_available() else 0
