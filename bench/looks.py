"""Measures of how alike two images look, beside PSNR and SSIM: LPIPS with two backbones, SSIMULACRA2, and two more.

These two are what the evaluation that Vector Scaffolding's authors released takes (full_eval.py of
ironjr/vector-scaffolding at 2b11004), and so what the paper's columns can be compared with: SSIM with the Gaussian
window of 3D Gaussian Splatting, and LPIPS (VGG) of images in [0, 1] where its network expects [-1, 1], which is not
LPIPS as defined.

Each needs something that the benchmarks do not bring: LPIPS its weights (`lpips_weights`), SSIMULACRA2 the package
``ssimulacra2``. A measure whose need is not there is left out, and no other number takes its place.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import torch
from lpips_metric import lpips_metrics
from numpy.typing import NDArray
from PIL import Image
from torch import Tensor
from torch.nn.functional import conv2d

from warpvec.image.metrics import SSIM_C1, SSIM_C2

Pixels = NDArray[np.uint8]

NAMES = ("ssim_gaussian", "lpips_vgg", "lpips_vgg_released", "lpips_alex", "ssimulacra2")
"""All measures: a similarity, three distances, and a score that is 100 for equal images."""

TITLES = {
    "ssim_gaussian": "SSIM (Gaussian 11)",
    "lpips_vgg": "LPIPS (VGG)",
    "lpips_vgg_released": "LPIPS (VGG, fed [0, 1])",
    "lpips_alex": "LPIPS (AlexNet)",
    "ssimulacra2": "SSIMULACRA2",
}

SSIM_SIGMA, SSIM_REACH = 1.5, 5
"""Standard deviation and reach in pixels of the Gaussian window: 11 x 11."""

NEEDS = {
    "ssim_gaussian": "nothing",
    "lpips_vgg_released": "python bench/lpips_weights.py",
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
    if "lpips_vgg" in found:
        vgg = lpips_metrics()["vgg"]
        found["lpips_vgg_released"] = lambda image, original: vgg(image, original, is_centered=False)
    found["ssim_gaussian"] = gaussian_ssim
    return {**found, "ssimulacra2": ssimulacra2} if find_spec("ssimulacra2") else found


def gaussian_ssim(image: Pixels, original: Pixels) -> float:
    """Return the mean SSIM (Wang et al. 2004) of the channels in windows of a Gaussian; zeros lie around the images."""
    a, b = (torch.from_numpy(pixels / 255.0).permute(2, 0, 1)[:, None] for pixels in (image, original))
    offset = torch.arange(-SSIM_REACH, SSIM_REACH + 1, dtype=torch.float64)
    weights = torch.exp(-0.5 * (offset / SSIM_SIGMA).square())
    window = torch.outer(weights, weights)[None, None] / weights.sum().square()

    def mean(values: Tensor) -> Tensor:
        return conv2d(values, window, padding=SSIM_REACH)

    mean_a, mean_b = mean(a), mean(b)
    variances = mean(a * a + b * b) - mean_a.square() - mean_b.square()
    covariance = mean(a * b) - mean_a * mean_b
    luminance = (2.0 * mean_a * mean_b + SSIM_C1) / (mean_a.square() + mean_b.square() + SSIM_C1)
    return float((luminance * (2.0 * covariance + SSIM_C2) / (variances + SSIM_C2)).mean())


def ssimulacra2(image: Pixels, original: Pixels) -> float:
    """Return the score of the package ``ssimulacra2``."""
    files = []
    for pixels in (original, image):
        files.append(io.BytesIO())
        Image.fromarray(pixels).save(files[-1], "PNG")
    return float(import_module("ssimulacra2").compute_ssimulacra2(*files))
