"""Tests of warpvec.flat.layers.fine_outlines: outlines of parts that are thinner than pixels."""

from __future__ import annotations

import numpy as np
import pytest
from flat_regions import box, coverage, disc
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.chains.traced import said_enlarged
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.curves.contours import signed_area
from warpvec.flat.layers.fine_outlines import fine_contours_of, fine_coverage


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.5])
def test_stroke_narrower_than_a_pixel_is_one_outline_of_its_area(offset: float) -> None:
    covered = coverage(box(8.0 + offset, 4.0, 8.8 + offset, 20.0), 24, 24)
    (loop,) = fine_contours_of(covered)
    assert abs(signed_area(loop)) == pytest.approx(0.8 * 16.0, rel=0.15)
    # Where in a pixel a narrower stroke lies, no coverage tells.
    assert (loop[:, 0].min() + loop[:, 0].max()) / 2.0 == pytest.approx(8.4 + offset, abs=0.12)


def test_hole_of_a_small_ring_stays_open() -> None:
    covered = coverage(disc(12.0, 12.0, 3.0), 24, 24) - coverage(disc(12.0, 12.0, 1.8), 24, 24)
    outer, inner = sorted((signed_area(loop) for loop in fine_contours_of(covered)), key=abs, reverse=True)
    assert abs(outer) == pytest.approx(9.0 * np.pi, rel=0.05)
    assert abs(inner) == pytest.approx(1.8**2 * np.pi, rel=0.1)
    assert outer * inner < 0


@pytest.mark.parametrize(("radius", "width"), [(4.2, 1.5), (5.0, 1.2), (3.3, 1.7)])
def test_outlines_of_a_thin_ring_are_round(radius: float, width: float) -> None:
    edges = [radius + side * width for side in (0.5, -0.5)]
    large, small = (coverage(disc(12.3, 11.8, edge), 24, 24) for edge in edges)
    loops = sorted(fine_contours_of(large - small), key=lambda loop: -abs(signed_area(loop)))
    for loop, edge in zip(loops, edges, strict=True):
        off = np.hypot(*(loop - (12.3, 11.8)).T) - edge
        assert np.sqrt((off**2).mean()) < 0.02


@pytest.mark.parametrize("ink", [0.0, 1.0])
def test_pixels_of_pure_ink_are_outlined_as_they_are(ink: float) -> None:
    covered = np.zeros((8, 8))
    covered[2:6, 3:5] = ink
    areas = [abs(signed_area(loop)) for loop in fine_contours_of(covered)]
    assert areas == pytest.approx([8.0] if ink else [], abs=0.1)


@pytest.mark.parametrize("columns", [[0.8, 0.3], [0.5, 0.5]])
def test_the_sides_of_a_stem_are_lines(columns: list[float]) -> None:
    covered = np.zeros((16, 8))
    covered[3:14, 3:5] = columns
    ((segments, is_line),) = said_enlarged(fine_contours_of(covered), [LETTERING.scale])
    length = np.linalg.norm(np.roll(segments[:, 0], -1, axis=0) - segments[:, 0], axis=1)
    assert (length[is_line] > 8.0).sum() == 2


def test_thin_oblique_strokes_side_by_side_stay_in_one_piece() -> None:
    # A W of 7 px: with the ink of rows and columns alone, a stroke broke.
    x, y = 6.25 + 9.3 / 4.0 * np.arange(5), 6.325 + 7.2 * (np.arange(5) % 2)
    covered = coverage(lambda px, py: _distance(px, py, x, y) <= 0.5, 24, 20)
    assert ndimage.label(fine_coverage(covered) > 0.5)[1] == 1


def _distance(px: Floats, py: Floats, x: Floats, y: Floats) -> Floats:
    """Return the distance of points from the line through ``x`` and ``y`` [n]."""
    found = np.full(px.shape, np.inf)
    for k in range(len(x) - 1):
        right, down = x[k + 1] - x[k], y[k + 1] - y[k]
        place = np.clip(((px - x[k]) * right + (py - y[k]) * down) / (right**2 + down**2), 0.0, 1.0)
        found = np.minimum(found, np.hypot(px - x[k] - place * right, py - y[k] - place * down))
    return found
