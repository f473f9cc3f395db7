"""The segments of any path data are counted."""

from __future__ import annotations

import pytest

from warpvec.svg.segments import count_path, count_segments


@pytest.mark.parametrize(
    ("data", "count"),
    [
        ("", 0), ("M0 0", 0), ("M0 0z", 0), ("M0 0 1 1 2 2z", 3), ("m0 0l1 1 2 2H3 4v5", 5),
        ("M0 0s1 2 3 4Q1 2 3 4 5 6 7 8t1 1T2 2", 5), ("M0 0a1 1 0 01.5.5", 1),
        ("M0 0A1 1 0 0 0 5 5 1 1 0 1,1 6e0-6", 2),
        ("M0 0L1e-5 2E+3", 1), ("M0 0zM1 1l2 2z", 2), ("M0,0C1,2,3,4,5,6 1-2-3-4.5.6 7", 2),
        ("M1 2h3v4h-3z", 4), ("M.1.2h.3v.4h-.3v-.4z", 4), ("m1 1h2v2zm5 5h1v1h-1zl1 1", 8), ("M1 2C3 4 5 6 1 2Z", 1),
        ("M1 2 5 5a1 1 0 01-4-3z", 2), ("m1 1h2v2zl-1 0 0 1zz", 6), ("M1 1 4 5 1 1.0000001z", 2),
        ("M0 0H1e999h1e999z", 3),
    ],
)  # fmt: skip
def test_segments_of_any_path_data_are_counted(data, count):
    assert count_segments(data) == count


def test_parameters_are_those_of_the_segments_without_moves_and_closes():
    assert (
        count_path("M1,1 2,2h3V4zm1 1q1 1 2 2t3 3C1 1 2 2 3 3s1-1.5.5-.25a1 1 0 012 2 1 1 0 1 0 1 1").parameters == 40
    )
    assert count_path("M1 1 4 5 1 1").parameters == 4


def test_counting_segments_is_linear_in_hostile_data():
    # The digits could be split between the numbers of an arc in any way: a careless expression would never return.
    assert count_segments("M0 0a" + "1" * 1_000_000) == 0
