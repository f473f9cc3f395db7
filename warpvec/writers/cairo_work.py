"""Convert an SVG by CairoSVG in a child process; see `warpvec.sandbox.run`."""

from __future__ import annotations

import re

import cairosvg  # type: ignore[import-untyped]

from warpvec.writers.pdf_layers import can_have_layers, on_one_page, parts_of
from warpvec.writers.round_corners import with_round_paths

_DATE = re.compile(rb"(?<=/CreationDate \(D:)\d{14}|(?<=%%CreationDate: )[^\n]+")
"""The time of writing, which would make other bytes of the same drawing. That of a PDF has this many digits."""

if can_have_layers():
    import pikepdf  # noqa: F401  # the child process cannot import it later


def work(data: bytes, method: str) -> list[bytes]:
    """Return the file that a ``method`` of CairoSVG makes of the SVG text ``data``."""
    svg = data.decode()
    parts = parts_of(svg) if method == "svg2pdf" and can_have_layers() else []
    if not parts:
        return [_converted(svg, method)]
    return [on_one_page([part.name for part in parts], [_converted(part.svg, method) for part in parts])]


def _converted(svg: str, method: str) -> bytes:
    found: bytes = getattr(cairosvg, method)(bytestring=with_round_paths(svg).encode())
    return _DATE.sub(b"19700101000000", found)
