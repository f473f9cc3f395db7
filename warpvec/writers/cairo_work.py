"""Convert an SVG by CairoSVG in a child process; see `warpvec.sandbox.run`."""

from __future__ import annotations

import cairosvg  # type: ignore[import-untyped]

from warpvec.writers.round_corners import with_round_paths


def work(data: bytes, method: str) -> list[bytes]:
    """Return the file that a ``method`` of CairoSVG makes of the SVG text ``data``."""
    return [getattr(cairosvg, method)(bytestring=with_round_paths(data.decode()).encode())]
