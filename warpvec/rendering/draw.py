"""Draw images of scenes outside the fit, as NumPy arrays."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.scene import Scene
from warpvec.image.alpha import straight
from warpvec.image.write import to_8_bits
from warpvec.rendering.operator import draw

BAND_PIXELS = 4_000_000
"""Number of pixels drawn at a time. The renderer's working memory, about 100 bytes per pixel, stays below 1 GB."""


def draw_8_bits(scene: Scene, height: int, width: int, threads: int | None) -> NDArray[np.uint8]:
    """Draw the image of `draw_exactly`, clamped and rounded to 8 bits, in a quarter of the memory."""
    image = np.empty((height, width, 4 if scene.transparent else 3), np.uint8)
    for top, band in _bands(scene, height, width, threads):
        image[top : top + len(band)] = to_8_bits(band)
    return image


def draw_exactly(scene: Scene, height: int, width: int, threads: int | None) -> NDArray[np.float32]:
    """Draw the exact image [h, w, 3 or 4] in bands of rows, so that memory does not grow with the photo."""
    image = np.empty((height, width, 4 if scene.transparent else 3), np.float32)
    for top, band in _bands(scene, height, width, threads):
        image[top : top + len(band)] = band
    return image


def _bands(scene: Scene, height: int, width: int, threads: int | None) -> Iterator[tuple[int, NDArray[np.float32]]]:
    """Yield the exact image in bands of rows, each with its first row."""
    row_count = max(1, BAND_PIXELS // width)
    for top in range(0, height, row_count):
        band = scene.moved(0.0, -top)
        yield top, draw_pixels(band, min(row_count, height - top), width, threads=threads)


def draw_pixels(scene: Scene, height: int, width: int, **settings: Any) -> NDArray[np.float32]:
    """Draw ``scene`` as an array [h, w, 3], or [h, w, 4] with straight alpha if it is transparent.

    ``settings`` go to `warpvec.rendering.operator.draw`: the renderer, its settings, and the threads.
    """
    image = draw(scene, height, width, alpha=scene.transparent, **settings)
    pixels: NDArray[np.float32] = (straight(image) if scene.transparent else image).cpu().numpy()
    return pixels
