"""Why a fit uses no GPU: what torch, Warp and the system see."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
import warp as wp

from warpvec.errors import InputError
from warpvec.rendering import devices
from warpvec.rendering.launch import resolve_device

NO_CUDA, NO_DRIVER = "torch was built without CUDA", "it has no driver that works"


def pretend(monkeypatch: pytest.MonkeyPatch, in_torch: int, in_warp: int, in_machine: int, cuda: str | None) -> None:
    """Pretend that so many GPUs are seen, and that torch was built for the version ``cuda``."""
    monkeypatch.setattr(torch.cuda, "is_available", lambda: in_torch > 0)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: in_torch)
    monkeypatch.setattr(torch.version, "cuda", cuda)
    monkeypatch.setattr(wp, "get_cuda_device_count", lambda: in_warp)
    monkeypatch.setattr(devices, "has_nvidia_gpu", lambda: in_machine > 0)


@pytest.mark.parametrize(
    ("in_torch", "in_warp", "in_machine", "cuda", "reason"),
    [
        (1, 1, 1, "12.8", None),
        (2, 1, 2, "12.8", None),
        (0, 0, 0, None, "there is no NVIDIA GPU"),
        (0, 0, 0, "12.8", "there is no NVIDIA GPU"),
        (0, 0, 1, None, f"there is an NVIDIA GPU, but {NO_CUDA}"),
        (0, 0, 1, "12.8", f"there is an NVIDIA GPU, but {NO_DRIVER}"),
        (0, 1, 1, None, f"Warp sees a GPU, but {NO_CUDA}"),
        (0, 1, 1, "12.8", "Warp sees a GPU, but torch sees none"),
        (1, 0, 1, "12.8", "torch sees a GPU, but Warp sees none; its driver may be too old"),
    ],
)
def test_the_reason_names_what_is_missing(
    in_torch: int, in_warp: int, in_machine: int, cuda: str | None, reason: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    pretend(monkeypatch, in_torch, in_warp, in_machine, cuda)
    assert devices.why_no_gpu() == reason
    assert resolve_device("auto") == ("cpu" if reason else "cuda:0")
    if reason:
        with pytest.raises(InputError, match=f"got 'cuda'; give one of these: {reason}$"):
            resolve_device("cuda")


@pytest.mark.parametrize(
    ("vendor", "kind", "is_gpu"),
    [("0x10de", "0x030000", True), ("0x10de", "0x030200", True), ("0x10de", "0x020700", False),
     ("0x8086", "0x030000", False)],
    ids=["a graphics card", "a data centre's", "a network card", "another vendor's"],
)  # fmt: skip
def test_a_gpu_without_a_driver_is_seen(
    vendor: str, kind: str, is_gpu: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for slot, values in {"0": ("0x1af4\n", "0x010000\n"), "1": (f"{vendor}\n", f"{kind}\n")}.items():
        (tmp_path / slot).mkdir()
        for name, value in zip(("vendor", "class"), values, strict=True):
            (tmp_path / slot / name).write_text(value)
    monkeypatch.setattr(devices, "_DRIVEN", tmp_path / "none")
    monkeypatch.setattr(devices, "_HARDWARE", tmp_path)
    assert devices.has_nvidia_gpu() == is_gpu
