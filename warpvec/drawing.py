"""Images of scenes outside the fit: as the file's scene is drawn, and as the fit saw it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.autograd import draw
from warpvec.config import FitConfig
from warpvec.config_rules import RENDERER_SETTINGS
from warpvec.scene import Scene
from warpvec.transparency import straight

BAND_PIXELS = 4_000_000
"""Pixels drawn at a time outside the fit: the renderer's working memory, some 100 bytes a pixel, stays under a GB."""


def draw_as_fitted(scene: Scene, height: int, width: int, config: FitConfig) -> NDArray[np.float32]:
    """The image [h, w, 3] of ``scene``, or [h, w, 4], straight, by the renderer of ``config`` with its settings."""
    settings = {name: getattr(config, name) for name in RENDERER_SETTINGS[config.renderer]}
    return _draw(scene, height, width, renderer=config.renderer, threads=config.threads, **settings)


def eight_bits(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """``image`` clamped and rounded, in place, to what an 8-bit file can say."""
    np.clip(image, 0.0, 1.0, out=image)
    np.rint(np.multiply(image, 255.0, out=image), out=image)
    return np.divide(image, 255.0, out=image)


def draw_exactly(scene: Scene, height: int, width: int, threads: int | None) -> NDArray[np.float32]:
    """The exact image [h, w, 3 or 4], drawn in bands of rows so that memory does not grow with the photo."""
    row_count = max(1, BAND_PIXELS // width)
    image = np.empty((height, width, 4 if scene.transparent else 3), np.float32)
    for top in range(0, height, row_count):
        bottom = min(top + row_count, height)
        band = replace(scene, points=scene.points - scene.points.new_tensor([0.0, top]))
        image[top:bottom] = _draw(band, bottom - top, width, threads=threads)
    return image


def _draw(scene: Scene, height: int, width: int, **settings: Any) -> NDArray[np.float32]:
    image = draw(scene, height, width, alpha=scene.transparent, **settings)
    pixels: NDArray[np.float32] = (straight(image) if scene.transparent else image).cpu().numpy()
    return pixels
