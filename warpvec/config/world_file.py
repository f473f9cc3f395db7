"""World files: the six numbers that place a picture on a map, beside map.png often as map.pgw."""

from __future__ import annotations

import math
from typing import Any

from warpvec.checks import show
from warpvec.config.limits import MAX_WORLD_FILE_BYTES
from warpvec.errors import InputError
from warpvec.inputs import read_file

_COUNT = 6


def check_world_file(name: str, value: object) -> str | None:
    """Return six numbers, given as text or as a sequence, with spaces between them; None stays None."""
    if isinstance(value, list | tuple):
        value = " ".join(map(str, value))
    return None if value is None else " ".join(map(repr, placing(name, value)))


def parse_world_file(name: str, path: str) -> str:
    """Return the six numbers in the file ``path``."""
    data = read_file(path, MAX_WORLD_FILE_BYTES, name, "a world file")
    return " ".join(map(repr, placing(name, data.decode("ascii", errors="replace"), path)))


def placing(name: str, text: Any, path: str | None = None) -> tuple[float, ...]:
    """Return A, D, B, E, C, F of a world file's ``text``: a pixel is at (A x + B y + C, D x + E y + F).

    The place of a pixel is that of its centre; the first one is at x = y = 0.

    Raises:
        InputError: these are not six numbers that place a picture; the message calls them ``name``.
    """
    words = text.split() if isinstance(text, str) else []
    try:
        found = tuple(float(word.replace(",", ".")) for word in words)
    except ValueError:
        found = ()
    is_placing = len(found) == _COUNT and all(map(math.isfinite, found)) and found[0] * found[3] != found[2] * found[1]
    if not is_placing:
        rule = "must have six numbers that place a picture, as .pgw, .jgw and .tfw files have"
        raise InputError(name, rule, show(text) if path is None else repr(path), "save one by a program for maps")
    return found
