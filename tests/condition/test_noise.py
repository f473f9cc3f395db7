"""Noise is measured within 15 %, also at black and white, and is 0 in clean pictures, textures and JPEG."""

from __future__ import annotations

import numpy as np
import pytest
from damage import as_jpeg, blurred, drawn, levels_of, noisy
from scipy.ndimage import gaussian_filter
from sweep import sweep

from warpvec.condition.noise import measure_noise

CLEAN = (0.0, 0.0, 0.0)


@sweep(("width", "deviation"), [(width, noise) for width in (200, 400) for noise in (2.0, 5.0, 8.0, 15.0)])
def test_noise_is_measured_within_15_percent(width: int, deviation: float) -> None:
    assert measure_noise(levels_of(noisy(drawn(width), deviation))) == pytest.approx([deviation] * 3, rel=0.15)


def test_noise_is_measured_for_each_channel() -> None:
    levels = levels_of(drawn(300))
    noise = np.random.default_rng(3).normal(size=levels.shape) * [3.0, 6.0, 9.0]
    assert measure_noise(np.rint((levels + noise).clip(0, 255))) == pytest.approx([3.0, 6.0, 9.0], rel=0.15)


def test_noise_of_black_and_white_is_measured_although_half_is_cut_off() -> None:
    levels = np.where(np.indices((240, 240)).sum(0)[..., None] // 60 % 2, 255.0, 0.0).repeat(3, 2)
    noise = 8.0 * np.random.default_rng(5).normal(size=levels.shape)
    assert measure_noise(np.rint((levels + noise).clip(0, 255))) == pytest.approx([8.0] * 3, rel=0.15)


@sweep("width", [16, 48, 64, 100, 257, 512])
def test_clean_and_compressed_pictures_have_no_noise(width: int) -> None:
    clean = drawn(width)
    for image in (clean, blurred(clean, 1.0), as_jpeg(clean, 50), as_jpeg(clean, 90)):
        assert measure_noise(levels_of(image)) == CLEAN


def test_texture_is_no_noise() -> None:
    grain = gaussian_filter(np.random.default_rng(1).normal(size=(256, 256)), 1.0)
    assert measure_noise((128.0 + 60.0 * grain)[..., None].repeat(3, 2)) == CLEAN


def test_a_grid_of_hairlines_on_white_is_no_noise() -> None:
    levels = np.full((320, 320, 3), 255.0)
    levels[::9], levels[:, ::14] = 211.0, 223.0
    assert measure_noise(levels) == CLEAN
