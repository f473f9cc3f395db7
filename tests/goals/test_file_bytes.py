"""Sizes of files as people write them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import warpvec
from warpvec.errors import InputError
from warpvec.goals.file_bytes import parse_size
from warpvec.modes import choice


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


@pytest.mark.parametrize("options", [{}, {"gzip": True}, {"size": "90mm"}, {"minify": False}])
def test_a_size_that_no_file_has_is_refused_before_the_work(
    options: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(choice, "chosen_mode", None)  # the work begins with it
    photo = np.zeros((30, 40, 3), np.uint8)
    with pytest.raises(InputError, match=r"^max_bytes is too small for one path, got 90; give more than 1\d\d$"):
        warpvec.vectorize(photo, max_bytes=90, **options)


def test_a_size_that_a_file_of_one_path_has_is_not_refused() -> None:
    photo = np.zeros((30, 40, 3), np.uint8)
    photo[10:20, 10:20] = 255
    smallest = warpvec.vectorize(photo, mode="flat", minify=True).metrics["bytes"]
    assert warpvec.vectorize(photo, mode="flat", max_bytes=smallest).metrics["bytes"] <= smallest
