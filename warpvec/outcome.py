"""What a fit tells while it runs, and what it gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from torch import Tensor

from warpvec.loss import psnr_from_mse
from warpvec.scene import Scene


@dataclass(frozen=True)
class Progress:
    """Where a fit stands after an iteration."""

    iteration: int
    iteration_count: int
    curve_count: int
    seconds: float
    loss: Tensor = field(repr=False)
    scene: Callable[[], Scene] = field(repr=False)
    """The scene as it stands, in pixels of the fitted image."""

    @property
    def psnr(self) -> float:
        """Internal PSNR of the iteration's image, in dB; reads one number back from the device."""
        return psnr_from_mse(float(self.loss))


@dataclass(frozen=True)
class FitResult:
    """What a fit gives: the scene in pixels of the fitted image, on the CPU, and how it got there."""

    scene: Scene
    history: list[dict[str, float]]
    iterations: int
    seconds: float
    interrupted: bool
    device: str


def history_entry(progress: Progress) -> dict[str, Any]:
    """What is kept of an iteration; reads one number back from the device."""
    return {
        "iteration": progress.iteration,
        "curves": progress.curve_count,
        "psnr": progress.psnr,
        "seconds": progress.seconds,
    }
