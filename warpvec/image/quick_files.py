"""Tell which picture files are decoded in little time and memory, whoever made them.

All others are decoded in the sandbox: a JPEG has as many scans as its maker likes, each of which changes all pixels;
tens of thousands of EXIF tags may each hold the same megabytes (Pillow 13 refuses them); a file may have millions of
parts. What is left of that in a short file takes a second or so. The sandbox costs a quarter of a second, which few
small files should pay.
"""

from __future__ import annotations

import re

MAX_SCANS = 500
"""Most scans of a JPEG, as libjpeg-turbo's own tests with hostile files have it. Programs write some ten."""

_QUICK_BYTES = 2**20
"""Longest file that is decoded in this process: most logos are shorter."""

_QUICK_SCANS = 32
"""Most scans of a JPEG that is decoded in this process."""

_JPEG, _SCAN = b"\xff\xd8", b"\xff\xda"
"""Begin of a JPEG file, and of a scan."""

_EXIF = (b"eXIf", b"EXIF", b"Raw profile type")
"""What PNG and WebP files with EXIF tags contain. Those of a JPEG have at most 64 KB if there are some only once."""

_JPEG_EXIF = b"Exif\x00\x00"

_QUICK = (b"\x89PNG", _JPEG, b"GIF8", b"BM", b"RIFF")
"""Begin of the files that may be decoded in this process: PNG, JPEG, GIF, BMP and WebP."""

# Within compressed data 0 follows 0xFF, or the number of a restart.
_MARKER = re.compile(rb"\xff[^\x00\xff\xd0-\xd7]")

_END, _SCAN_CODE, _BARE = 0xD9, 0xDA, (0x01, 0xD8)
"""Markers of a JPEG: its end, a scan, and those without a length (ITU-T T.81, table B.1)."""


def is_quick(data: bytes) -> bool:
    """Return whether the picture file ``data`` is decoded, or refused, in little time and memory."""
    if len(data) > _QUICK_BYTES or not data.startswith(_QUICK):
        return False
    if data.startswith(_JPEG):
        return data.count(_JPEG_EXIF) <= 1 and data.count(_SCAN) <= _QUICK_SCANS
    return not any(word in data for word in _EXIF)


def scan_count(data: bytes) -> int:
    """Return the number of scans of a JPEG file, and `MAX_SCANS` + 1 for more; 0 for another file."""
    place, count = 2, 0
    while data.startswith(_JPEG) and count <= MAX_SCANS:
        found = _MARKER.search(data, place)
        if found is None or data[found.end() - 1] == _END:
            break
        code, place = data[found.end() - 1], found.end()
        count += code == _SCAN_CODE
        if code not in _BARE:
            place += max(2, int.from_bytes(data[place : place + 2], "big"))
    return count
