"""The goal of a largest size of the file."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from warpvec.checks import check_count
from warpvec.config.control import slider
from warpvec.config.kinds import Custom
from warpvec.errors import InputError
from warpvec.files import text_bytes
from warpvec.goals.quantity import Quantity

if TYPE_CHECKING:
    from warpvec.drawing.drawing import Drawing

LIMIT_MAX = 10**12
"""Largest size that a file may be asked to have, above any file; larger numbers would overflow in the search."""

_SIZE = re.compile(r"([0-9]+(?:\.[0-9]*)?)\s*(k|m)?b?", re.IGNORECASE)
_UNITS = {"": 1, "k": 1_000, "m": 1_000_000}


def parse_size(name: str, text: str) -> int:
    """Return the bytes of a size such as "50000", "50k" or "1.5M". A k is 1000, as in size budgets of web pages.

    Raises:
        InputError: the text is not such a size; messages call the option ``name``.
    """
    match = _SIZE.fullmatch(text.strip())
    count = 0.0 if match is None else float(match[1]) * _UNITS[(match[2] or "").lower()]
    if not 1.0 <= count < math.inf:
        remedy = "give at least 1" if match else "k is 1,000 bytes, and M a million"
        raise InputError(name, "must be a size such as 50000, 80k or 1.5M", repr(text), remedy)
    return round(count)


def _check(name: str, value: object) -> int:
    return check_count(name, value, 1, LIMIT_MAX)


def _measure(drawing: Drawing, gzip: bool) -> float:
    return text_bytes(drawing.text, gzip=gzip)


def _describe(facts: Mapping[str, object]) -> str:
    return f"{facts['bytes']:,} of {facts['max_bytes']:,} {'gzipped bytes' if facts['gzip'] else 'bytes'}"


_KILOBYTES = (2, 3, 5, 7, 10, 15, 20, 30, 40, 50, 60, 80, 100, 120, 150, 200, 300, 400, 500, 700, 1000)
_CONTROL = slider(
    "File size", "Largest size of the SVG file in kilobytes (KB). The detail then follows from it.",
    (None, *(1000 * count for count in _KILOBYTES)), lambda size: "any" if size is None else f"{size // 1000} KB",
    overrides="detail",
)  # fmt: skip

QUANTITY = Quantity(
    "max_bytes", Custom(_check, parse_size, "SIZE", f"1 to {LIMIT_MAX:g}", "int"),
    "Make the best file of at most this size (50000, 80k).", "SIZE", "largest", _measure, _describe,
    is_of_text=True, page=_CONTROL,
)  # fmt: skip
