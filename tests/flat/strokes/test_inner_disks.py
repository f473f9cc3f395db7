"""The disks inside shapes whose width is known."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.flat.strokes.inner_disks import boundary_of, inner_disks, may_have_width, stroke_width


def _control(corners: list[tuple[float, float]]) -> np.ndarray:
    """Return the lines of a polygon as cubics [R, 4, 2]."""
    start = np.array(corners, np.float64)
    end, share = np.roll(start, -1, 0), np.linspace(0.0, 1.0, 4)[:, None]
    return start[:, None] * (1.0 - share) + end[:, None] * share


@pytest.mark.parametrize(("thick", "is_stroke"), [(6.0, True), (60.0, False)])
def test_a_glance_at_some_points_tells_a_stroke_from_a_wedge(thick: float, is_stroke: bool) -> None:
    control = _control([(10.0, 10.0), (210.0, 10.0), (210.0, 10.0 + thick), (10.0, 16.0)])
    boundary = boundary_of(control, 1.0)
    assert may_have_width(boundary) is is_stroke
    width, _ = stroke_width(boundary, inner_disks(boundary))
    assert (width == pytest.approx(6.0, abs=0.1)) if is_stroke else width == 0.0
