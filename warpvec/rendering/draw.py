"""Draw images of scenes outside the fit, as NumPy arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.scene import Scene
from warpvec.image.alpha import straight
from warpvec.rendering.operator import draw

BAND_PIXELS = 4_000_000
"""Number of pixels drawn at a time. The renderer's working memory, about 100 bytes per pixel, stays below 1 GB."""


def draw_exactly(scene: Scene, height: int, width: int, threads: int | None) -> NDArray[np.float32]:
    """Draw the exact image [h, w, 3 or 4] in bands of rows, so that memory does not grow with the photo."""
    row_count = max(1, BAND_PIXELS // width)
    image = np.empty((height, width, 4 if scene.transparent else 3), np.float32)
    for top in range(0, height, row_count):
        bottom = min(top + row_count, height)
        band = scene.moved(0.0, -top)
        image[top:bottom] = draw_pixels(band, bottom - top, width, threads=threads)
    return image


def draw_pixels(scene: Scene, height: int, width: int, **settings: Any) -> NDArray[np.float32]:
    """Draw ``scene`` as an array [h, w, 3], or [h, w, 4] with straight alpha if it is transparent.

    ``settings`` go to `warpvec.rendering.operator.draw`: the renderer, its settings, and the threads.
    """
    image = draw(scene, height, width, alpha=scene.transparent, **settings)
    pixels: NDArray[np.float32] = (straight(image) if scene.transparent else image).cpu().numpy()
    return pixels
