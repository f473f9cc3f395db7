"""Frames of a running fit: its present drawing as SVG text, a few times a second.

The work on a drawing of flat art fits other scenes too, such as what casts a shadow, and candidates of which one is
taken. Of these a frame shows the best so far, and does not count its paths: their number would jump.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.app.sketch import sketch
from warpvec.config.fit_config import FitConfig
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr
from warpvec.rendering.draw import draw_8_bits
from warpvec.svg.measure import draw_like
from warpvec.svg.write import write_svg
from warpvec.watch.progress import Pace, Progress

FRAME_SECONDS = 0.4
"""Time between two frames. To write one takes 7 ms for 512 paths, and 50 ms for 4,096."""

PRECISION = 2
"""Decimals of a frame's coordinates, those of files."""


class Best(NamedTuple):
    """The best drawing of a picture so far.

    Attributes:
        picture: the copy [h, w, 3 or 4] that scenes are compared with.
        text: SVG text of the drawing.
        psnr: its closeness in dB.
        threads: CPU threads; None for all cores.
    """

    picture: NDArray[np.float32]
    text: str
    psnr: float
    threads: int | None

    @staticmethod
    def rough(pixels: NDArray[np.float32], copy: NDArray[np.float32], threads: int | None) -> Best:
        """Return the rough drawing of a picture ``pixels`` [h, w, 3 or 4] with this ``copy``."""
        text = sketch(pixels)
        return Best(copy, text, psnr(draw_like(text, copy), copy), threads)

    def facts(self) -> dict[str, Any]:
        """Return the facts of a frame, without those of a fit."""
        return {"svg": self.text, "psnr": _finite(self.psnr), "bytes": len(self.text.encode()), "paths": None}

    def measured(self, scene: Scene) -> float:
        """Return the closeness of ``scene``, in pixels of the copy, in dB."""
        height, width = self.picture.shape[:2]
        drawn = draw_8_bits(scene, height, width, self.threads)
        return psnr(drawn, self.picture) if drawn.shape == self.picture.shape else -math.inf


class FrameWriter:
    """Called after every iteration of a fit of a picture with ``width`` x ``height`` pixels, it sends frames.

    Args:
        width, height: size of the picture, in which the frames are drawn.
        send: takes the facts of a frame: "svg", "iteration", "iterations", "psnr", "bytes", "paths", "seconds", "left".
        best: the best drawing so far of flat art, of which frames show nothing worse; None for the fit of a photo.
    """

    def __init__(
        self, width: int, height: int, send: Callable[[dict[str, Any]], None], best: Best | None = None
    ) -> None:
        self._width, self._height, self._send, self._best = width, height, send, best
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
        return {
            **self._drawing(progress),
            "iteration": progress.iteration,
            "iterations": progress.iteration_count,
            "seconds": progress.seconds,
            "left": self._pace.seconds_left(progress),
        }

    def _drawing(self, progress: Progress) -> dict[str, Any]:
        scene = progress.scene().cpu()
        if self._best is not None:
            measured = self._best.measured(scene)
            if measured > self._best.psnr:
                self._best = self._best._replace(text=self._text(scene), psnr=measured)
            return self._best.facts()
        text = self._text(scene)
        return {"svg": text, "psnr": _finite(progress.psnr), "bytes": len(text.encode()), "paths": len(scene)}

    def _text(self, scene: Scene) -> str:
        cubics = to_cubics(scene.scaled(self._scale))[0]
        return write_svg(cubics, self._width, self._height, precision=PRECISION)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
