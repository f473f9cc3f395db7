"""Refuse JPEG 2000 files of colours with more than 8 bits, whose white Pillow 13 makes black."""

from __future__ import annotations

_SIZES = b"\xff\x4f\xff\x51"
"""Begin of a codestream: the markers of the start and of the size (ITU-T T.800, annex A)."""

_COUNT_AT = 40
"""Bytes from the start to the number of components, after which each has three bytes: depth less 1, and two steps."""


def check_depth(data: bytes) -> None:
    """Raise ValueError if the JPEG 2000 file ``data`` has several components, one of more than 8 bits."""
    start = data.find(_SIZES)
    at = start + _COUNT_AT
    count = int.from_bytes(data[at : at + 2], "big")
    depths = data[at + 2 : at + 2 + 3 * count : 3]
    if start >= 0 and count > 1 and any((depth & 0x7F) + 1 > 8 for depth in depths):
        raise ValueError("colours of more than 8 bits in JPEG 2000; save it as PNG")
