"""Writing OUT."""

from __future__ import annotations

import sys

from warpvec.files import encode_svg, write_atomic


def write_svg(text: str, out: str) -> None:
    """Writes the SVG ``text`` to the file ``out``, whole or not at all, gzipped for .svgz; or to stdout for "-"."""
    if out == "-":
        sys.stdout.buffer.write(text.encode())
    else:
        write_atomic(out, encode_svg(text, out))
