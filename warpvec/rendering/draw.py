"""Images of scenes outside the fit: as the file's scene is drawn, and as the fit saw it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.scene import Scene
from warpvec.image.alpha import straight
from warpvec.rendering.operator import draw

BAND_PIXELS = 4_000_000
"""Pixels drawn at a time outside the fit: the renderer's working memory, some 100 bytes a pixel, stays under a GB."""


def draw_exactly(scene: Scene, height: int, width: int, threads: int | None) -> NDArray[np.float32]:
    """The exact image [h, w, 3 or 4], drawn in bands of rows so that memory does not grow with the photo."""
    row_count = max(1, BAND_PIXELS // width)
    image = np.empty((height, width, 4 if scene.transparent else 3), np.float32)
    for top in range(0, height, row_count):
        bottom = min(top + row_count, height)
        band = replace(scene, points=scene.points - scene.points.new_tensor([0.0, top]))
        image[top:bottom] = draw_pixels(band, bottom - top, width, threads=threads)
    return image


def draw_pixels(scene: Scene, height: int, width: int, **settings: Any) -> NDArray[np.float32]:
    """Draw ``scene`` as an array [h, w, 3], or [h, w, 4] with straight alpha where it is transparent.

    ``settings`` are those of `warpvec.rendering.operator.draw`: the renderer, its settings, and the threads.
    """
    image = draw(scene, height, width, alpha=scene.transparent, **settings)
    pixels: NDArray[np.float32] = (straight(image) if scene.transparent else image).cpu().numpy()
    return pixels
