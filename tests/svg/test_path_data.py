"""Numbers of path data are exact and short; `test_write.py` tests whole paths."""

from __future__ import annotations

from fractions import Fraction

import pytest

from warpvec.svg.path_data import format_number


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
