"""Damage of the icon gate: pictures of icons as people have them, from their clean pictures over white."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from flat_originals import Pixels
from PIL import Image
from scipy.ndimage import gaussian_filter

WEB_SIDE, WEB_QUALITY = 400, 80
"""Longest side in px, and quality of the JPEG, of a picture of the web."""

BLUR_SIGMA = 1.0
"""Sigma in px."""

NOISE_SIGMA = 5.0
"""Standard deviation in levels; each channel has noise of its own."""


def web(pixels: Pixels) -> Pixels:
    """Reduce ``pixels`` [h, w, 3] by bicubic interpolation, and save them as JPEG with half the chroma."""
    image = Image.fromarray(pixels)
    scale = WEB_SIDE / max(image.size)
    file = io.BytesIO()
    size = (round(scale * image.width), round(scale * image.height))
    image.resize(size, Image.Resampling.BICUBIC).save(file, "JPEG", quality=WEB_QUALITY)
    return np.asarray(Image.open(file))


def blur(pixels: Pixels) -> Pixels:
    """Blur ``pixels`` [h, w, 3]."""
    blurred = gaussian_filter(pixels.astype(np.float64), (BLUR_SIGMA, BLUR_SIGMA, 0), mode="nearest")
    return np.round(blurred).astype(np.uint8)


def noise(pixels: Pixels) -> Pixels:
    """Add noise to ``pixels`` [h, w, 3]."""
    added = np.random.default_rng(0).normal(0.0, NOISE_SIGMA, pixels.shape)
    return np.round((pixels + added).clip(0, 255)).astype(np.uint8)


DAMAGES: dict[str, Callable[[Pixels], Pixels]] = {"web": web, "blur": blur, "noise": noise}
