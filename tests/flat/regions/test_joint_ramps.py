"""Gradients that noise or a steep slope parts are one region, and what a designer drew stays apart."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from warpvec.flat.regions.color_moments import moments_of
from warpvec.flat.regions.regions import Regions, find_regions, unexplained
from warpvec.geometry.paints.registry import FLAT, LINEAR

Floats = NDArray[np.float64]
SIDE = 96


def as_noisy(picture: Floats, seed: int = 1) -> NDArray[np.float32]:
    """Return ``picture`` [h, w, 3] with noise of 4 levels, in whole levels."""
    noise = np.random.default_rng(seed).normal(0.0, 4.0, picture.shape)
    return (np.rint(255.0 * picture + noise).clip(0.0, 255.0) / 255.0).astype(np.float32)


def on_white(colors: Floats, top: int = 36, bottom: int = 60) -> Floats:
    """Return a page with a strip of ``colors`` [SIDE - 24, 3] across it."""
    page = np.ones((SIDE, SIDE, 3))
    page[top:bottom, 12:-12] = colors
    return page


def strip_of(regions: Regions) -> set[int]:
    """Return the regions inside the strip."""
    return set(np.unique(regions.label[40:56, 16:-16]).tolist())


def test_a_ramp_that_noise_breaks_is_one_region() -> None:
    place = np.linspace(0.0, 1.0, SIDE - 24)[:, None]
    first, last = np.array([0.10, 0.75, 0.98]), np.array([0.04, 0.38, 0.96])
    regions = find_regions(as_noisy(on_white(first + place * (last - first))))
    (name,) = strip_of(regions)
    assert regions.paints.kind[name] == LINEAR
    off = (regions.mixed()[..., :3] - on_white(first + place * (last - first)))[40:56, 16:-16]
    assert 255.0 * np.sqrt((off**2).mean()) < 4.0


@pytest.mark.parametrize("step", [0.1, 0.2])
def test_two_colors_that_meet_at_an_edge_stay_two_regions(step: float) -> None:
    colors = np.where(np.arange(SIDE - 24)[:, None] < 30, 0.5, 0.5 + step) * np.array([0.3, 0.8, 1.0])
    regions = find_regions(as_noisy(on_white(colors)))
    assert len(strip_of(regions)) == 2
    assert (regions.paints.kind[list(strip_of(regions))] == FLAT).all()


def test_a_band_whose_ramp_turns_round_a_corner_has_ramps() -> None:
    x, y = (place + 0.5 - 10.0 for place in np.indices((128, 128))[::-1])
    is_across, is_down = (
        (y > 0.0) & (y < 36.0) & (x > 0.0) & (x < 108.0),
        (x > 72.0) & (x < 108.0) & (y > 0.0) & (y < 108.0),
    )
    place = np.select([is_across & is_down, is_across], [x + 0.5 * y, x], y + 72.0) / 216.0
    stops = np.array([[1.0, 0.98, 0.3], [1.0, 0.7, 0.05], [1.0, 0.16, 0.34], [1.0, 0.2, 0.55]])
    colors = np.stack([np.interp(place, np.linspace(0.0, 1.0, 4), channel) for channel in stops.T], -1)
    picture = np.where((is_across | is_down)[..., None], colors, 1.0).astype(np.float32)
    regions = find_regions(picture)
    assert unexplained(regions.mixed(), picture) < 1.0
    assert len(regions) <= 6


def test_a_noisy_page_without_anything_on_it_is_one_region() -> None:
    assert len(find_regions(as_noisy(np.full((48, 48, 3), 0.7)))) == 1


def test_the_ramp_of_moments_is_that_of_the_pixels() -> None:
    random = np.random.default_rng(3)
    points = random.random((200, 2)) * [40.0, 9.0] + [300.0, 20.0]
    along, slope = np.array([0.6, 0.8]), np.array([0.01, -0.004, 0.002])
    colors = 0.4 + (points - points.mean(0)) @ along[:, None] * slope + random.normal(0.0, 0.01, (200, 3))
    parts = moments_of((points[:, 0] > 320.0).astype(np.int64), colors, points, 2)
    ramp = parts[0].joined(parts[1]).ramp()
    shown = ramp.color + ramp.direction.places(points)[:, None] * ramp.slope
    assert abs(ramp.direction.along @ along) > 0.999
    np.testing.assert_allclose(((colors - shown) ** 2).sum(), ramp.rest, rtol=1e-6)
    np.testing.assert_allclose(parts[0].joined(parts[1]).flat_rest(), ((colors - colors.mean(0)) ** 2).sum(), rtol=1e-9)
