"""Draw an SVG with resvg in a child process; see `warpvec.sandbox.run`."""

from __future__ import annotations

from typing import Any

import resvg_py

LANGUAGES = ["en"]
"""Languages of the person who looks, which resvg_py has none of: elements for some language would never be drawn."""


def work(data: bytes, **options: Any) -> list[bytes]:
    """Return the PNG of the SVG text ``data``; the options are those of resvg."""
    return [resvg_py.svg_to_bytes(data.decode(), languages=LANGUAGES, **options)]
