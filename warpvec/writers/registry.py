"""The table of the kinds of files. To add a kind, write a file in this folder, and add its name here."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path

from warpvec.errors import InputError
from warpvec.writers import svg, svgz
from warpvec.writers.writer import DEFAULT_TARGET, Target, Writer

_FILES = ("svg", "svgz", "png", "pdf", "eps", "dxf", "geojson", "kicad_mod", "jsx", "xml")
"""Modules of this folder with a `WRITER`, in the order of messages."""

_FOUND: list[Writer] = [import_module(f"warpvec.writers.{name}").WRITER for name in _FILES]

WRITERS: dict[str, Writer] = {writer.suffix: writer for writer in _FOUND}
"""Suffix -> writer."""

SVG_SUFFIXES = (svg.WRITER.suffix, svgz.WRITER.suffix)
"""Suffixes of files that hold the text of the SVG."""

PAGE_SUFFIXES = (*SVG_SUFFIXES, ".jsx")
"""Suffixes of files that web pages include as text."""


def writer_of(path: str | os.PathLike[str]) -> Writer:
    """Return the writer for the suffix of ``path``, in any case; that of SVG for an unknown one, as of a device."""
    return WRITERS.get(Path(path).suffix.lower(), svg.WRITER)


def check_suffix(path: str | os.PathLike[str], name: str) -> None:
    """Check that a drawing can be saved as ``path``.

    Raises:
        InputError: no writer has the suffix of ``path``, or what its writer needs is missing; ``name`` is for the
            message.
    """
    given = os.fspath(path)
    if Path(path).suffix.lower() not in WRITERS:
        raise InputError(name, f"must end in {listed(tuple(WRITERS))}", repr(given), "rename it")
    writer_of(path).check(given, name)


def listed(suffixes: tuple[str, ...]) -> str:
    """Return ``suffixes`` as a list for a message: ".svg, .svgz or .png"."""
    return f"{', '.join(suffixes[:-1])} or {suffixes[-1]}"


def encode(text: str, path: str | os.PathLike[str], target: Target = DEFAULT_TARGET) -> bytes:
    """Return the bytes of the file ``path`` of the SVG ``text``; see `Writer.encode`.

    Raises:
        InputError: what the writer needs is missing.
    """
    return writer_of(path).encode(text, target._replace(name=Path(path).stem))
