"""Convert an SVG of warpvec to PDF and EPS, for print shops, cutters and typesetting.

CairoSVG does it (LGPL, maintained by CourtBouillon; the extra "print"). It keeps paths, gradients and the size in real
units. EPS knows no opacity: cairo draws the parts of a page below translucent paths as pixels.
"""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType
from typing import Any

from warpvec.errors import InputError
from warpvec.files import encode_svg

PRINT_SUFFIXES = (".pdf", ".eps")
"""Suffixes of files that need the extra "print"."""


def is_print_file(path: str | os.PathLike[str]) -> bool:
    """Return whether the suffix of ``path`` is one of ``PRINT_SUFFIXES``, in any case."""
    return Path(path).suffix.lower() in PRINT_SUFFIXES


def check_print_support(path: str | os.PathLike[str], name: str) -> None:
    """Check that `encode_drawing` can make the file ``path``, before work is spent on its contents.

    Raises:
        InputError: ``path`` is for print, and CairoSVG or the library cairo is missing; ``name`` is for the message.
    """
    if is_print_file(path):
        _cairosvg(path, name)


def encode_drawing(text: str, path: str | os.PathLike[str]) -> bytes:
    """Return the bytes of a file ``path`` with the SVG ``text``: PDF, EPS, gzipped for ``.svgz``, or the text.

    Raises:
        InputError: as `check_print_support`.
    """
    if not is_print_file(path):
        return encode_svg(text, path)
    cairosvg: Any = _cairosvg(path, "path")
    convert = cairosvg.svg2pdf if Path(path).suffix.lower() == ".pdf" else cairosvg.svg2eps
    data: bytes = convert(bytestring=text.encode())
    return data


def _cairosvg(path: str | os.PathLike[str], name: str) -> ModuleType:
    try:
        import cairosvg  # type: ignore[import-untyped]
    except ImportError:
        rule = f"must end in .svg unless CairoSVG is installed, which writes {Path(path).suffix.lower()}"
        raise InputError(name, rule, repr(os.fspath(path)), "pip install 'warpvec[print]'") from None
    except OSError:  # cairocffi finds no library
        rule = "must end in .svg unless the library cairo is installed"
        remedy = "install it, on Debian as libcairo2"
        raise InputError(name, rule, repr(os.fspath(path)), remedy) from None
    module: ModuleType = cairosvg
    return module
