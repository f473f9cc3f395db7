"""Tests of warpvec.flat.layers.fine_outlines: outlines of parts that are thinner than pixels."""

from __future__ import annotations

import numpy as np
import pytest
from flat_regions import box, coverage, disc

from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.curves.contours import signed_area
from warpvec.flat.curves.curve_fitting import fit_enlarged
from warpvec.flat.layers.fine_outlines import fine_contours_of


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
    ((segments, is_line),) = fit_enlarged(fine_contours_of(covered), [LETTERING.scale])
    assert len(segments) == 4 and is_line.sum() >= 2
