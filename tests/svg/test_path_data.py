"""Numbers of path data are exact and short, and loops close; `test_write.py` tests whole paths."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from svgelements import Path

from warpvec.svg.path_data import Loop, format_number, format_path, is_own_data, read_loops


@pytest.mark.parametrize(
    ("ticks", "decimals", "text"),
    [
        (0, 2, "0"), (0, 0, "0"), (1250, 2, "12.5"), (1200, 2, "12"), (-25, 2, "-.25"), (5, 2, ".05"), (-1, 3, "-.001"),
        (100, 2, "1"), (-100, 2, "-1"), (-7, 0, "-7"), (120, 0, "120"), (1005, 2, "10.05"), (10, 1, "1"),
    ],
)  # fmt: skip
def test_format_number_is_exact_and_short(ticks, decimals, text):
    assert format_number(ticks, decimals) == text
    assert Fraction(text) == Fraction(ticks, 10**decimals)


@pytest.mark.parametrize("has_arcs", [False, True])
def test_sums_of_binary_numbers_close_each_loop_exactly(has_arcs):
    """Sums of tenths in binary numbers end beside the start, and the line that closes the loop may then cross it."""
    rng = np.random.default_rng(3)
    circle = 12345 + np.rint(1000.0 * _circle(8)).astype(np.int64)
    loops = [Loop(rng.integers(0, 99999, (5, 3, 2)), np.zeros(5, bool)) for _ in range(20)]
    loops += [Loop(circle, np.zeros(8, bool)), Loop(rng.integers(0, 99999, (3, 3, 2)), np.array([True, False, True]))]
    data = format_path(loops, 2, has_arcs, closes_exactly=True)
    assert ("A" in data) == has_arcs
    assert is_own_data(data)
    for read, loop in zip(read_loops(data, 2), loops, strict=True):
        assert (read.ticks[:, 0] == loop.ticks[:, 0]).all() or len(read.ticks) != len(loop.ticks)
    for loop in Path(data).as_subpaths():
        start, end = (complex(*point) for point in (loop[0].end, loop[-1].end))
        before = complex(*loop[-2].end)
        assert start == end
        assert before == start or abs(before - start) > 0.005


def _circle(count):
    """Return the control points [count, 3, 2] of curves around a circle of radius 1."""
    angle = 2.0 * np.pi * np.arange(count + 1) / count
    on, along = np.stack([np.cos(angle), np.sin(angle)], 1), np.stack([-np.sin(angle), np.cos(angle)], 1)
    handle = 4.0 / 3.0 * np.tan(np.pi / (2.0 * count))
    return np.stack([on[:-1], on[:-1] + handle * along[:-1], on[1:] - handle * along[1:]], 1)
