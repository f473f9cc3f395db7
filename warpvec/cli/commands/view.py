"""``warpvec view``: inspect and edit an SVG in the browser."""

from __future__ import annotations

import json
import tempfile
import webbrowser
from pathlib import Path
from typing import Any

import click

from warpvec.checks import in_one_line
from warpvec.cli.arguments import (
    background_option,
    check_background,
    check_one_stdin,
    check_page,
    read_bytes,
    read_photo,
    read_svg_bytes,
)
from warpvec.cli.paths import check_distinct_files
from warpvec.errors import InputError

MAX_HISTORY_BYTES = 2**26
"""Largest file with the history of a fit. A record takes 80 bytes, and comes every ten iterations."""


@click.command(short_help="Inspect and edit an SVG in the browser.")
@click.argument("svg", metavar="SVG")
@click.option("--image", metavar="IMAGE", help="Image to compare with.")
@background_option
@click.option("--history", metavar="FILE", help="Output of run --json, for the convergence plot.")
@click.option("--report", "page", metavar="FILE", help="Write the page to this HTML file instead of opening it.")
def view(svg: str, image: str | None, background: str | None, history: str | None, page: str | None) -> None:
    """Inspect and edit the file SVG (- for stdin) in the browser.

    The page is one HTML file without links. It compares the drawing with the image, shows levels of detail,
    generations and the residual, and lets you select, move, scale, recolour, reorder, delete and draw paths and save
    the SVG.
    """
    inputs = {"SVG": svg, "--image": image, "--history": history}
    check_one_stdin(inputs)
    check_distinct_files({**inputs, "--report": page})
    check_background(background, image)
    if page is not None:
        check_page(page)
    data = read_svg_bytes(svg)
    photo = read_photo(image, background) if image is not None else None
    records = _read_history(history) if history is not None else None
    # This import takes seconds. By now most mistakes have been reported.
    from warpvec.viewer.page import write_page

    name = "drawing" if svg == "-" else Path(svg).stem
    path = Path(page) if page is not None else _temporary_folder() / f"{name}.html"
    try:
        write_page(path, data, photo=photo, history=records, name=name)
    except BaseException:
        if page is None:
            path.parent.rmdir()
        raise
    if page is None and not webbrowser.open(path.as_uri()):
        click.echo(f"no browser could be started; open {in_one_line(str(path))}", err=True)


def _temporary_folder() -> Path:
    try:
        return Path(tempfile.mkdtemp(prefix="warpvec-"))
    except OSError as error:
        rule, value = "must be given where no folder for temporary files can be written", error.strerror or str(error)
        raise InputError("--report", rule, value, "give a file, or set TMPDIR to a folder") from error


def _read_history(path: str) -> Any:
    """Return the records in the output of a command with --json, or in a file with only the list."""
    data = read_bytes(path, MAX_HISTORY_BYTES, "--history")
    try:
        found = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError("--history", "must be a JSON file", f"{path!r} ({error})", "write it again") from error
    return found.get("history", found) if isinstance(found, dict) else found
