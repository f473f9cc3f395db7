"""Options and arguments that several commands take, and how they are read."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from warpvec.config.presets import PRESETS
from warpvec.errors import InputError
from warpvec.files import check_writable, encode_svg, write_atomic

preset_option = click.option("--preset", default="default", show_default=True, help=f"{', '.join(PRESETS)}.")
json_option = click.option("--json", "as_json", is_flag=True, help="Report as one JSON object (infinity as null).")
background_option = click.option("--background", help="Colour to put behind transparency; else it is kept.")


def check_out(out: str, name: str = "OUT") -> None:
    if out == "-":
        return
    check_writable(out, name)
    special = Path(out).exists() and not Path(out).is_file()  # /dev/null and the like
    if not special and Path(out).suffix.lower() not in (".svg", ".svgz"):
        raise InputError(f"{name} must end in .svg or .svgz, or be - for stdout, got {out!r}; rename it")


def check_background(background: str | None, image: str | None) -> None:
    if background is not None and image is None:
        raise InputError(f"background must come with --image, got {background!r} alone; add the photo")


def read_source(source: str) -> str | bytes:
    return sys.stdin.buffer.read() if source == "-" else source


def read_svg(path: str, name: str = "OUT") -> bytes:
    return read_bytes(path, name, "an SVG file")


def read_bytes(path: str, name: str, kind: str = "a file") -> bytes:
    try:
        return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{name} must be {kind}, got {path!r} ({reason}); check the path") from error


def write_svg(text: str, out: str) -> None:
    """Writes the SVG ``text`` to the file ``out``, whole or not at all, gzipped for .svgz; or to stdout for "-"."""
    if out == "-":
        sys.stdout.buffer.write(text.encode())
    else:
        write_atomic(out, encode_svg(text, out))
