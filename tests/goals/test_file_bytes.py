"""Sizes of files as people write them."""

from __future__ import annotations

import pytest

from warpvec.errors import InputError
from warpvec.goals.file_bytes import parse_size


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("50000", 50_000), ("80k", 80_000), ("80 K", 80_000), ("80kB", 80_000), ("1.5M", 1_500_000), ("2.m", 2_000_000),
        (" 7 ", 7), ("1.001M", 1_001_000), ("0.001k", 1), ("300b", 300),
    ],
)  # fmt: skip
def test_sizes_are_read_in_thousands(text: str, size: int) -> None:
    assert parse_size("max_bytes", text) == size


@pytest.mark.parametrize(
    "text",
    ["", "k", "0", "-5", "0.5", "1e5", "80KiB", "8_0", "80kk", "5 apples", "٣k", "nan", "inf", "9" * 400, "1\n\n2"],
)
def test_a_text_that_is_not_a_size_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match="^max_bytes must be a size such as 50000, 80k or 1.5M, got ") as caught:
        parse_size("max_bytes", text)
    assert "\n" not in str(caught.value)
