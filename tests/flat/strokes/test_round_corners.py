"""Centre lines whose corners and short lines the fit may bend."""

from __future__ import annotations

import numpy as np

from warpvec.flat.strokes.line_fitting import Rows
from warpvec.flat.strokes.round_corners import with_bent_lines

WIDTH = 10.0


def hook(length: float) -> Rows:
    """Return two lines, a quarter of a circle, and a line of ``length`` pixels that goes on from it."""
    bend = [(40.0, 10.0), (51.0, 10.0), (60.0, 19.0)]
    straight = [(10.0, 20.0), (10.0, 10.0), bend, (60.0, 30.0), (60.0, 30.0 + length)]
    control = [place if isinstance(place, list) else [place] * 3 for place in straight]
    return Rows(np.array(control), np.array([True, True, False, True, True]), True)


def test_a_short_line_after_a_curve_may_bend() -> None:
    assert with_bent_lines(hook(8.0), WIDTH).is_line.tolist() == [True, True, False, False, True]


def test_long_lines_and_lines_beyond_a_corner_stay_straight() -> None:
    assert with_bent_lines(hook(30.0), WIDTH).is_line.tolist() == [True, True, False, True, True]
    short = hook(8.0)
    control = short.control.copy()
    control[4] = (68.0, 30.0)  # the curve ends at a corner
    assert with_bent_lines(short._replace(control=control), WIDTH).is_line.tolist() == [True, True, False, True, True]
