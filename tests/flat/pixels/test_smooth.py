"""Pixel art as curves: strokes hold together, neighbours leave no gap, and a disk of pixels is nearly one again."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.arrays import Integers
from warpvec.flat.pixels.cells import Cells
from warpvec.flat.pixels.smooth import smooth_scene
from warpvec.flat.pixels.touching import APART, FALLING, RISING, joined_corners
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg

COLORS = np.array([[255, 255, 255, 255], [200, 30, 30, 255], [30, 60, 200, 255], [20, 20, 20, 255]])
SCALE = 8


def _label(*rows: str) -> Integers:
    return np.array([list(map(int, row)) for row in rows], np.int64)


def _drawn(label: Integers) -> Integers:
    height, width = label.shape
    scene = smooth_scene(Cells(label, COLORS[: int(label.max()) + 1]), is_opaque=True)
    return draw(write_svg(scene, width, height), SCALE * width, SCALE * height)[..., :3].astype(np.int64)


def test_a_line_by_corners_is_a_stroke_and_its_ground_is_none() -> None:
    falling = _label("0000000", "0100000", "0010000", "0001000", "0000100", "0000010", "0000000")
    assert set(np.diag(joined_corners(falling))[1:-1]) == {FALLING}
    assert set(np.diag(joined_corners(falling[:, ::-1])[:, ::-1])[1:-1]) == {RISING}


@pytest.mark.parametrize(
    ("label", "joined"),
    [
        (_label("0000", "0110", "0110", "0000"), APART),  # all of one colour
        (_label("000000", "011000", "011000", "000110", "000110", "000000"), FALLING),  # the sparser colour
        (_label("1111111", "1000111", "1110111", "1111011", "1111101", "1111101", "1111111"), FALLING),  # the curve
    ],
)
def test_the_published_rules_decide_which_diagonal_is_one(label: Integers, joined: int) -> None:
    middle = label.shape[0] // 2 - 1
    assert joined_corners(label)[middle, middle] == joined


def test_joined_pixels_are_drawn_as_one_and_others_apart() -> None:
    line = _label("0000000", "0100000", "0010000", "0001000", "0000100", "0000010", "0000000")
    dark = _drawn(line).sum(2) < 600
    assert all(dark[SCALE * k, SCALE * k] for k in range(2, 6))
    two = _label("00000000", "01110000", "01110000", "01110000", "00002220", "00002220", "00002220", "00000000")
    assert _drawn(two)[SCALE * 4, SCALE * 4].min() > 40


def test_no_gap_shows_between_colours_and_each_pixel_keeps_its_colour() -> None:
    rng = np.random.default_rng(3)
    label = np.zeros((20, 20), np.int64)
    label[2:18, 2:18] = rng.integers(1, 4, (8, 8)).repeat(2, 0).repeat(2, 1)
    image = _drawn(label)
    inside = image[3 * SCALE : 17 * SCALE, 3 * SCALE : 17 * SCALE]
    assert inside.min(2).max() < 120  # white would show
    centers = image[SCALE // 2 :: SCALE, SCALE // 2 :: SCALE]
    is_right = np.abs(centers - COLORS[label, :3]).max(2) < 60
    assert is_right.mean() > 0.98


def test_a_disk_of_pixels_is_nearly_a_disk_of_few_curves() -> None:
    y, x = np.indices((44, 44)) + 0.5
    away = np.hypot(x - 22.0, y - 22.0)
    scene = smooth_scene(Cells((away < 14.0).astype(np.int64), COLORS[:2]), is_opaque=True)
    assert np.abs(np.hypot(*(scene.segments[:, 0].double().numpy() - 22.0).T) - 14.0).max() < 0.7
    assert scene.structure.segment_count <= 24
