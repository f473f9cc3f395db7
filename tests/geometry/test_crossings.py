"""Counting where an outline crosses itself."""

import pytest

from warpvec.geometry.crossings import self_crossings
from warpvec.svg.read import read_svg

SQUARE = "M10 10 H50 V50 H10z"


@pytest.mark.parametrize(
    ("data", "count"),
    [
        (SQUARE, 0),
        ("M10 10 L50 50 H10 L50 11z", 1),
        ("M10 10 C80 50 -20 50 50 10 V0 H10z", 1),
        (SQUARE + " M40 21 H70 V31 H40z", 2),
        (SQUARE + " M20 20 H30 V30 H20z", 0),
        ("M10 10 H50 V50.3 L49.7 50 H50.3 V50 H10z", 0),
    ],
    ids=["square", "bow tie", "curve", "two loops", "hole", "too small to see"],
)
def test_crossings_of_an_outline_are_counted(data: str, count: int) -> None:
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="80" height="60"><path d="{SQUARE}"/><path d="{data}"/></svg>'
    )
    assert self_crossings(read_svg(text).scene).tolist() == [0, count]
