"""Areas of pure pixels: where they begin, and how far they grow."""

from __future__ import annotations

import numpy as np
from flat_pictures import flat_paints, opaque
from scipy import ndimage

from warpvec.flat.regions.noise import measure_tolerances
from warpvec.flat.regions.region_growing import (
    NONE,
    connected_areas,
    grow_by_paint,
    grow_seeds,
    linked_areas,
    pixels_of,
    without_small,
)
from warpvec.flat.regions.seeding import find_seeds

RED, BLUE = (0.8, 0.0, 0.1), (0.0, 0.2, 0.7)


def _halves(middle: float) -> np.ndarray:
    """Return red on the left and blue on the right of a column of pixels that mix both."""
    share = np.where(np.arange(16) < 8, 1.0, 0.0)
    share[8] = middle
    return share[None, :, None] * np.array(RED) + (1 - share)[None, :, None] * np.array(BLUE) + np.zeros((12, 1, 1))


def test_two_halves_are_two_areas_and_the_edge_is_none() -> None:
    picture = opaque(_halves(0.4))
    seeds = find_seeds(picture, picture, measure_tolerances(picture))
    assert (seeds[:, :8] == seeds[0, 0]).all() and (seeds[:, 9:] == seeds[0, -1]).all()
    assert seeds[0, 0] != seeds[0, -1]
    assert (seeds[:, 8] == NONE).all()


def test_a_steep_ramp_is_one_area_and_the_slope_of_a_soft_edge_is_none() -> None:
    ramp = opaque(np.round(np.tile(np.linspace(0.1, 0.7, 24), (24, 1)) * 255) / 255)
    assert np.unique(find_seeds(ramp, ramp, measure_tolerances(ramp))).tolist() == [0]
    edge = opaque(np.tile(np.clip((np.arange(24) - 10) / 4, 0, 1), (24, 1)))
    seeds = find_seeds(edge, edge, measure_tolerances(edge))
    assert (seeds[:, 11:14] == NONE).all()
    assert len(np.unique(seeds)) == 3


def test_a_soft_square_that_no_paint_shows_keeps_its_flat_areas() -> None:
    place = np.clip((np.abs(np.arange(60) - 29.5) - 6) / 16, 0, 1)
    profile = (1 - np.cos(np.pi * place)) / 2
    square = np.round((0.2 + 0.2 * np.maximum(profile[:, None], profile)) * 255) / 255
    picture = opaque(square)
    seeds = find_seeds(picture, picture, measure_tolerances(picture))
    assert seeds[30, 30] != seeds[0, 0] and min(seeds[30, 30], seeds[0, 0]) >= 0


def test_noise_has_no_areas() -> None:
    picture = opaque(np.random.default_rng(0).random((24, 24, 3)))
    assert (grow_seeds(picture, 2.5 / 255, 2) == NONE).all()


def test_areas_are_connected_by_sides_or_by_corners_too() -> None:
    mask = np.array([[1, 0, 0], [0, 1, 0], [0, 1, 1]], bool)
    assert connected_areas(mask).max() == 1
    assert connected_areas(mask, diagonal=True).max() == 0
    assert [pixels.tolist() for pixels in pixels_of(connected_areas(mask))] == [[0], [4, 7, 8]]
    assert without_small(connected_areas(mask), 2).tolist() == [[NONE, NONE, NONE], [NONE, 0, NONE], [NONE, 0, 0]]


def test_an_area_grows_over_its_paint_and_not_over_another() -> None:
    picture = opaque(_halves(0.0))
    labels = np.full(picture.shape[:2], NONE, np.int32)
    labels[5, 2], anywhere = 0, np.ones(picture.shape[:2], bool)
    grown = grow_by_paint(labels, anywhere, picture, flat_paints(RED, BLUE), np.eye(4, dtype=np.float32), 0.01)
    assert (grown[:, :8] == 0).all() and (grown[:, 8:] == NONE).all()
    held = grow_by_paint(labels, labels != NONE, picture, flat_paints(RED, BLUE), np.eye(4, dtype=np.float32), 0.01)
    assert (held == labels).all()


def test_linked_areas_are_those_of_a_grid_on_which_links_are_pixels_too() -> None:
    random = np.random.default_rng(1)
    for _ in range(100):
        height, width = random.integers(1, 20, 2)
        shapes = ((height, width), (height, width - 1), (height - 1, width))
        pure, right, below = (random.random(shape) < random.random() for shape in shapes)
        grid = np.zeros((2 * height - 1, 2 * width - 1), bool)
        grid[::2, ::2] = pure
        grid[::2, 1::2] = right & pure[:, 1:] & pure[:, :-1]
        grid[1::2, ::2] = below & pure[1:] & pure[:-1]
        assert np.array_equal(linked_areas(pure, right, below), ndimage.label(grid)[0][::2, ::2] - 1)
