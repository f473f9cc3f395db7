"""The order of lines lets a pen travel little."""

from __future__ import annotations

import numpy as np

from warpvec.flat.lines.line import DrawnLine
from warpvec.flat.lines.pen_travel import ordered, pen_travel
from warpvec.flat.strokes.line_fitting import Rows


def line(start: tuple[float, float], end: tuple[float, float]) -> DrawnLine:
    a, b = np.array(start), np.array(end)
    control = np.array([[a, a + (b - a) / 3.0, a + (b - a) * 2.0 / 3.0], [b, b, b]])
    return DrawnLine(Rows(control, np.array([True, True]), True), 1.0)


def test_a_row_of_lines_is_drawn_from_one_end_to_the_other() -> None:
    rungs = [line((10.0 * k, 0.0), (10.0 * k, 50.0)) for k in (3, 0, 4, 1, 2)]
    found = ordered(rungs)
    assert pen_travel(found) == 40.0
    assert sorted(float(each.ends()[0][0]) for each in found) == [0.0, 10.0, 20.0, 30.0, 40.0]


def test_a_line_that_is_reversed_stays_the_same_line() -> None:
    one = line((0.0, 0.0), (30.0, 10.0))
    back = one.reversed()
    assert [end.tolist() for end in back.ends()] == [[30.0, 10.0], [0.0, 0.0]]
    assert np.allclose(back.reversed().rows.control, one.rows.control)
