"""Noise goes, and edges, thin lines, and black and white stay."""

from __future__ import annotations

import numpy as np
from damage import drawn, levels_of, noisy
from PIL import Image
from sweep import sweep

from warpvec.condition.denoising import before_noise
from warpvec.image.metrics import psnr


@sweep("deviation", [5.0, 8.0, 15.0])
def test_noise_falls_by_ten_decibels_and_edges_stay(deviation: float) -> None:
    clean, given = (
        (levels_of(image) / 255.0).astype(np.float32) for image in (drawn(240), noisy(drawn(240), deviation))
    )
    found = before_noise(given, (deviation,) * 3)
    assert psnr(found, clean) > psnr(given, clean) + 10.0
    is_edge = np.abs(np.diff(clean, axis=1, prepend=clean[:, :1])).max(2) > 0.1
    assert np.sqrt(((found - clean)[is_edge] ** 2).mean()) < 0.85 * deviation / 255.0


def test_black_and_white_are_so_again_although_half_of_their_noise_was_cut_off() -> None:
    levels = np.where(np.arange(120)[:, None, None] < 60, 255.0, 0.0).repeat(120, 1).repeat(3, 2).astype(np.uint8)
    given = (levels_of(noisy(Image.fromarray(levels), 10.0)) / 255.0).astype(np.float32)
    found = 255.0 * before_noise(given, (10.0,) * 3)
    assert found[:50].mean() > 254.0
    assert found[70:].mean() < 1.0


def test_a_picture_of_one_pixel_stays() -> None:
    pixel = np.full((1, 1, 3), 0.5, np.float32)
    assert np.abs(before_noise(pixel, (8.0, 0.0, 8.0)) - pixel).max() < 1e-3
