"""Areas of icons follow their shading: a gradient is one area, however steep, and two colours stay two."""

from __future__ import annotations

import numpy as np
import pytest
from flat_pictures import opaque
from numpy.typing import NDArray

from warpvec.flat.regions.region_growing import NONE
from warpvec.flat.regions.regions import find_regions
from warpvec.flat.regions.shading_joining import join_shading
from warpvec.flat.regions.surface_growing import grow_by_surface
from warpvec.geometry.paints.registry import FLAT

SIDE = 24


def rounded(gray: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return an opaque picture [h, w, 4] of ``gray`` [h, w] in whole levels."""
    return opaque(np.round(255 * gray) / 255)


def ball(radius: float = 9.0) -> NDArray[np.float64]:
    """Return a ball on white [SIDE, SIDE] that is darker towards its rim, by squares of 8 samples."""
    y, x = (np.indices((8 * SIDE, 8 * SIDE)) + 0.5) / 8 - SIDE / 2
    distance = np.hypot(x, y)
    shown = np.where(distance < radius, 0.9 - 0.6 * (distance / radius) ** 2, 1.0)
    return shown.reshape(SIDE, 8, SIDE, 8).mean((1, 3))


def test_an_area_grows_over_shading_that_bends_and_stops_at_an_edge() -> None:
    x = np.arange(SIDE) / SIDE
    picture = rounded(np.where(x < 0.7, 0.2 + 0.6 * x**2, 1.0) * np.ones((SIDE, 1)))
    seeds = np.full((SIDE, SIDE), NONE, np.int32)
    seeds[8:14, 1:7] = 0
    grown = grow_by_surface(seeds, picture)
    assert (grown[:, :16] == grown[0, 0]).all() and (grown[:, 18:] != grown[0, 0]).all()


def test_a_shaded_ball_of_few_pixels_is_one_gradient() -> None:
    regions = find_regions(rounded(ball())[..., :3])
    assert len(regions) == 2
    assert (regions.paints.kind != FLAT).tolist().count(True) == 1


@pytest.mark.parametrize(("step", "count"), [(0.0, 1), (0.04, 2)])
def test_areas_join_where_shading_bends_but_not_at_a_step(step: float, count: int) -> None:
    x = np.arange(SIDE)
    bent = 0.3 + np.where(x < 12, 0.01 * x, 0.12 + 0.03 * (x - 12) + step)
    picture = rounded(bent * np.ones((SIDE, 1)))
    halves = np.where(x < 12, 0, 1).astype(np.int32) * np.ones((SIDE, 1), np.int32)
    assert join_shading(halves, picture).max() + 1 == count


def test_a_shaded_ring_is_a_gradient_and_no_mark_of_one_ink() -> None:
    y, x = (np.indices((8 * SIDE, 8 * SIDE)) + 0.5) / 8 - SIDE / 2
    distance = np.hypot(x, y)
    ring = np.where((distance > 4.0) & (distance < 9.0), 0.45 + 0.02 * y, 1.0)
    regions = find_regions(rounded(ring.reshape(SIDE, 8, SIDE, 8).mean((1, 3)))[..., :3])
    assert regions.is_lettering is None
    assert regions.paints.kind[regions.label[12, 6]] != FLAT
