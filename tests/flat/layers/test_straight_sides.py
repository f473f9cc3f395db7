"""Tests of warpvec.flat.layers.straight_sides: stems of letters have straight sides and square ends."""

from __future__ import annotations

import numpy as np
import pytest
from flat_regions import box, coverage, disc

from warpvec.flat.curves.contours import signed_area
from warpvec.flat.layers.fine_outlines import fine_contours_of
from warpvec.flat.layers.straight_sides import with_straight_sides

STEM = (8.3, 4.0, 9.6, 15.5)
"""Left, top, right and bottom of a stem of a small letter."""


@pytest.mark.parametrize("is_level", [False, True])
def test_a_stem_is_a_rectangle_of_its_area(is_level: bool) -> None:
    left, top, right, bottom = STEM
    covered = coverage(box(*STEM), 24, 24)
    (loop,) = fine_contours_of(covered.T if is_level else covered)
    straight = with_straight_sides(loop)
    x, y = straight.T[::-1] if is_level else straight.T
    assert np.minimum(abs(x - left), abs(x - right)).max() < 0.1
    assert (y.min(), y.max()) == pytest.approx((top, bottom), abs=0.15)
    is_side = (y > top + 0.5) & (y < bottom - 0.5)
    assert len(np.unique(np.round(x[is_side], 9))) == 2
    assert abs(signed_area(straight)) == pytest.approx(abs(signed_area(loop)), rel=0.01)


@pytest.mark.parametrize(("radius", "width"), [(4.2, 1.5), (7.5, 1.2), (16.0, 1.3)])
def test_a_thin_ring_stays_round(radius: float, width: float) -> None:
    large, small = (coverage(disc(20.3, 19.8, radius + side * width), 40, 40) for side in (0.5, -0.5))
    for loop in fine_contours_of(large - small):
        assert (with_straight_sides(loop) == loop).all()


def test_the_ends_of_an_oblique_stroke_stay() -> None:
    rows, columns = np.mgrid[0:192, 0:192] / 8.0 + 1.0 / 16.0
    is_in = (abs(columns - 6.0 - 0.5 * rows) < 0.7) & (rows > 4.0) & (rows < 20.0)
    (loop,) = fine_contours_of(is_in.reshape(24, 8, 24, 8).mean((1, 3)))
    assert (with_straight_sides(loop) == loop).all()
