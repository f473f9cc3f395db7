"""Measures of how alike two images look, beside PSNR and SSIM: LPIPS with two backbones, and SSIMULACRA2.

Each needs something that the benchmarks do not bring: LPIPS its weights (`lpips_weights`), SSIMULACRA2 the package
``ssimulacra2``. A measure whose need is not there is left out, and no other number takes its place.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

import numpy as np
from lpips_metric import lpips_metrics
from numpy.typing import NDArray
from PIL import Image

Pixels = NDArray[np.uint8]

NAMES = ("lpips_vgg", "lpips_alex", "ssimulacra2")
"""All measures: two distances, and a score that is 100 for equal images."""

TITLES = {"lpips_vgg": "LPIPS (VGG)", "lpips_alex": "LPIPS (AlexNet)", "ssimulacra2": "SSIMULACRA2"}

NEEDS = {
    "lpips_vgg": "python bench/lpips_weights.py",
    "lpips_alex": "python bench/lpips_weights.py",
    "ssimulacra2": "pip install ssimulacra2",
}
"""The command that brings what a measure needs."""


def measures() -> dict[str, Callable[[Pixels, Pixels], float]]:
    """Return the measures by name that can be taken here: of an image and the original [h, w, 3]."""
    found: dict[str, Callable[[Pixels, Pixels], float]] = {
        f"lpips_{network}": metric for network, metric in lpips_metrics().items()
    }
    return {**found, "ssimulacra2": ssimulacra2} if find_spec("ssimulacra2") else found


def ssimulacra2(image: Pixels, original: Pixels) -> float:
    """Return the score of the package ``ssimulacra2``."""
    files = []
    for pixels in (original, image):
        files.append(io.BytesIO())
        Image.fromarray(pixels).save(files[-1], "PNG")
    return float(import_module("ssimulacra2").compute_ssimulacra2(*files))
