"""The noise of pictures whose noise is known, and how far regions reach into edges of known width."""

from __future__ import annotations

import io

import numpy as np
import pytest
from flat_pictures import opaque
from PIL import Image

from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.noise import measure_noise, measure_reach, measure_tolerances

LEVEL = 1 / 255


def _noisy(sigma: float) -> np.ndarray:
    return 0.5 + sigma * np.random.default_rng(0).standard_normal((96, 96))


@pytest.mark.parametrize("levels", [1.0, 2.0])
def test_noise_of_known_deviation_is_measured(levels: float) -> None:
    """A second difference has the deviation sqrt(6); nine tenths of the larger of two are below 1.9 of these."""
    assert measure_noise(opaque(_noisy(levels * LEVEL))) == pytest.approx(1.9 * 6**0.5 * levels * LEVEL, rel=0.05)


def test_rounding_and_flat_colours_are_no_noise() -> None:
    ramp = np.round(np.tile(np.linspace(0.2, 0.6, 96), (96, 1)) * 255) / 255
    two = np.where(np.arange(96) < 48, 0.1, 0.9) * np.ones((96, 1))
    assert measure_noise(opaque(ramp)) == measure_noise(opaque(two)) == 0.0


def test_the_shading_of_an_icon_bends_and_is_no_noise() -> None:
    y, x = np.indices((48, 48)) / 48
    shading = np.round((0.2 + 0.7 * x**2 + 0.1 * np.sin(9 * y)) * 255) / 255
    assert measure_noise(opaque(shading)) == 0.0
    rough = shading + 2 * LEVEL * np.random.default_rng(0).standard_normal(shading.shape)
    assert measure_noise(opaque(rough)) > 0.0


@pytest.mark.parametrize(("levels", "is_noise"), [(1, False), (3, True)])
def test_ramps_that_a_browser_dithers_by_a_level_are_no_noise(levels: int, is_noise: bool) -> None:
    ramp = np.tile(np.linspace(240.0, 243.0, 256)[:, None], (1, 256))
    chess = (np.indices(ramp.shape).sum(0) % 2 - 0.5) * levels
    assert bool(measure_noise(opaque(np.round(ramp + chess) * LEVEL))) == is_noise


def test_tolerances_of_noise_are_bounded_and_see_less_colour() -> None:
    clean, noisy = (measure_tolerances(opaque(_noisy(levels * LEVEL))) for levels in (0.0, 4.0))
    assert clean.noise == 0.0
    assert noisy.noise == pytest.approx(REGIONS.noise_max)
    assert noisy.mix > clean.mix and noisy.paint > clean.paint
    blue = np.array([0.0, 0.0, 1.0, 0.0], np.float32)
    assert np.abs(blue @ clean.metric).max() == 1.0
    assert np.abs(blue @ noisy.metric).max() < 0.5


@pytest.mark.parametrize(("width", "reach"), [(1, 3), (3, 6), (4, 8), (12, 8)])
def test_regions_reach_across_edges_of_known_width(width: int, reach: int) -> None:
    """The rise of a straight ramp over its slope is its width, and regions reach twice as far."""
    profile = np.clip((np.arange(96) - 47.5) / width + 0.5, 0.0, 1.0)
    assert measure_reach(opaque(np.tile(profile, (96, 1)))) == (min(reach, 8) if width > 2 else REGIONS.sharp_reach)


def test_pale_details_away_from_edges_are_no_noise() -> None:
    """Pale words between dark ones; noise would be beside the dark ones as well."""
    page = np.ones((256, 256))
    page[:, ::16] = 0.0
    for column in (6, 10):
        page[::7, column::16] -= 5 * LEVEL
    assert measure_noise(opaque(page)) == 0.0


@pytest.mark.parametrize(("is_webp", "noise"), [(True, REGIONS.noise_min), (False, 0.0)])
def test_edges_that_ring_as_in_webp_are_noise(is_webp: bool, noise: float) -> None:
    y, x = np.indices((1024, 1024))
    is_disk = ((x // 8 % 32 - 16) ** 2 + (y // 8 % 32 - 16) ** 2)[..., None] < 120
    large = np.where(is_disk, [55.0, 110.0, 128.0], [140.0, 175.0, 191.0])
    image = Image.fromarray(np.uint8(large)).resize((256, 256), Image.Resampling.BICUBIC)
    if is_webp:
        file = io.BytesIO()
        image.save(file, "WEBP", quality=80)
        image = Image.open(file).convert("RGB")
    alpha = np.ones((256, 256, 1), np.float32)
    assert measure_noise(np.concatenate([np.float32(image) / np.float32(255), alpha], 2)) == noise
