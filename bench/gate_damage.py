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

JPEG_SIDE, JPEG_QUALITY = 256, 50
"""The same of a picture that was saved too often."""

SMALL_SIDE, SMALL_QUALITY, ENLARGED_QUALITY = 110, 75, 80
"""Longest side in px, and quality, of a small JPEG, and quality of the JPEG that it is enlarged to."""

BLUR_SIGMA = 1.0
"""Sigma in px."""

NOISE_SIGMA = 5.0
"""Standard deviation in levels; each channel has noise of its own."""


def web(pixels: Pixels) -> Pixels:
    """Reduce ``pixels`` [h, w, 3] by bicubic interpolation, and save them as JPEG with half the chroma."""
    return as_jpeg(resized(Image.fromarray(pixels), WEB_SIDE), WEB_QUALITY)


def jpeg(pixels: Pixels) -> Pixels:
    """Reduce ``pixels`` [h, w, 3], and save them as a poor JPEG."""
    return as_jpeg(resized(Image.fromarray(pixels), JPEG_SIDE), JPEG_QUALITY)


def small(pixels: Pixels) -> Pixels:
    """Save ``pixels`` [h, w, 3] as a small JPEG, enlarge it by bicubic interpolation, and save that as JPEG."""
    tiny = Image.fromarray(as_jpeg(resized(Image.fromarray(pixels), SMALL_SIDE), SMALL_QUALITY))
    return as_jpeg(resized(tiny, JPEG_SIDE), ENLARGED_QUALITY)


def resized(image: Image.Image, side: int) -> Image.Image:
    """Return ``image`` with a longest side of ``side`` px."""
    scale = side / max(image.size)
    return image.resize((round(scale * image.width), round(scale * image.height)), Image.Resampling.BICUBIC)


def as_jpeg(image: Image.Image, quality: int) -> Pixels:
    """Return ``image`` as it comes back from a JPEG."""
    return np.asarray(saved(image, "JPEG", quality=quality))


def saved(image: Image.Image, format: str, **options: int) -> Image.Image:
    """Return ``image`` as it comes back from a file."""
    file = io.BytesIO()
    image.save(file, format, **options)
    return Image.open(file).convert("RGB")


def blur(pixels: Pixels) -> Pixels:
    """Blur ``pixels`` [h, w, 3]."""
    blurred = gaussian_filter(pixels.astype(np.float64), (BLUR_SIGMA, BLUR_SIGMA, 0), mode="nearest")
    return np.round(blurred).astype(np.uint8)


def noise(pixels: Pixels) -> Pixels:
    """Add noise to ``pixels`` [h, w, 3]."""
    added = np.random.default_rng(0).normal(0.0, NOISE_SIGMA, pixels.shape)
    return np.round((pixels + added).clip(0, 255)).astype(np.uint8)


DAMAGES: dict[str, Callable[[Pixels], Pixels]] = {
    "web": web, "blur": blur, "noise": noise, "jpeg": jpeg, "small": small,
}  # fmt: skip
