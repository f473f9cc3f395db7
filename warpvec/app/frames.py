"""Frames of a running fit: its present drawing as SVG text, a few times a second."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from warpvec.config.fit_config import FitConfig
from warpvec.geometry.cubics import to_cubics
from warpvec.svg.write import write_svg
from warpvec.watch.progress import Pace, Progress

FRAME_SECONDS = 0.4
"""Time between two frames. To write one takes 7 ms for 512 paths, and 50 ms for 4,096."""

PRECISION = 2
"""Decimals of a frame's coordinates, those of files."""


class FrameWriter:
    """Called after every iteration of a fit of a picture with ``width`` x ``height`` pixels, it sends frames.

    Args:
        width, height: size of the picture, in which the frames are drawn.
        send: takes the facts of a frame: "svg", "iteration", "iterations", "psnr", "bytes", "paths", "seconds", "left".
    """

    def __init__(self, width: int, height: int, send: Callable[[dict[str, Any]], None]) -> None:
        self._width, self._height, self._send = width, height, send
        self._scale = max(1.0, max(width, height) / FitConfig.fit_size)
        self._due = -math.inf
        self._pace = Pace()

    def __call__(self, progress: Progress) -> None:
        """Send a frame if it is time."""
        self._pace.see(progress)
        if time.monotonic() < self._due:
            return
        self._send(self._frame(progress))
        self._due = time.monotonic() + FRAME_SECONDS

    def _frame(self, progress: Progress) -> dict[str, Any]:
        scene = to_cubics(progress.scene().cpu().scaled(self._scale))[0]
        text = write_svg(scene, self._width, self._height, precision=PRECISION)
        psnr = progress.psnr
        return {
            "svg": text,
            "iteration": progress.iteration,
            "iterations": progress.iteration_count,
            "psnr": psnr if math.isfinite(psnr) else None,
            "bytes": len(text.encode()),
            "paths": len(scene),
            "seconds": progress.seconds,
            "left": self._pace.seconds_left(progress),
        }
