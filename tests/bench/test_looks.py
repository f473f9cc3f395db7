"""SSIM with a Gaussian window, against a plain sum over the pixels around each pixel."""

from __future__ import annotations

import numpy as np
import pytest
from looks import gaussian_ssim


def _plain(a: np.ndarray, b: np.ndarray) -> float:
    """Return the mean over pixels and channels, one pixel at a time; outside of the images all is zero."""
    offset = np.arange(-5, 6)
    weights = np.exp(-(offset[:, None] ** 2 + offset[None] ** 2) / (2 * 1.5**2))
    weights /= weights.sum()
    padded = [np.pad(image / 255.0, ((5, 5), (5, 5), (0, 0))) for image in (a, b)]
    values = []
    for row, column, channel in np.ndindex(a.shape):
        x, y = (image[row : row + 11, column : column + 11, channel] for image in padded)
        mx, my = (weights * x).sum(), (weights * y).sum()
        vx, vy = (weights * x * x).sum() - mx**2, (weights * y * y).sum() - my**2
        cov = (weights * x * y).sum() - mx * my
        values.append((2 * mx * my + 1e-4) * (2 * cov + 9e-4) / ((mx**2 + my**2 + 1e-4) * (vx + vy + 9e-4)))
    return float(np.mean(values))


def test_ssim_with_a_gaussian_window_is_the_plain_sum() -> None:
    random = np.random.default_rng(2)
    a = random.integers(0, 256, (13, 17, 3), dtype=np.uint8)
    b = np.clip(a.astype(int) + random.integers(-60, 61, a.shape), 0, 255).astype(np.uint8)
    assert gaussian_ssim(b, a) == pytest.approx(_plain(b, a), rel=1e-9)
    assert gaussian_ssim(a, a) == pytest.approx(1.0, abs=1e-12)
