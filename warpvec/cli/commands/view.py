"""``warpvec view``: a page to look and edit in."""

from __future__ import annotations

import json
import tempfile
import webbrowser
from pathlib import Path
from typing import Any

import click

from warpvec.cli.arguments import background_option, check_background, read_bytes, read_svg
from warpvec.cli.paths import check_places
from warpvec.errors import InputError
from warpvec.files import check_writable


@click.command()
@click.argument("svg", metavar="OUT")
@click.option("--image", metavar="IN", help="The photo, to compare with.")
@background_option
@click.option("--history", metavar="FILE", help="What run --json said of the fit, for the convergence plot.")
@click.option("--report", metavar="FILE", help="Write the page to this HTML file and open nothing.")
def view(svg: str, image: str | None, background: str | None, history: str | None, report: str | None) -> None:
    """Look at the SVG file OUT, and edit it, in the browser.

    The page is one file without any link: compare with the photo, slide through the levels of detail, colour by
    generation, map the residual; select, move, scale, recolour, reorder, delete and paint paths, and save the SVG.
    """
    check_places({"OUT": svg, "--image": image, "--history": history, "--report": report})
    check_background(background, image)
    if report is not None:
        check_writable(report, "--report")
    data = read_svg(svg)
    photo = read_bytes(image, "--image") if image is not None else None
    records = _read_history(history) if history is not None else None
    # Only now what takes seconds to import: most mistakes have been found by then.
    from warpvec.viewer.page import write_report

    name = Path(svg).stem
    page = Path(report) if report is not None else Path(tempfile.mkdtemp(prefix="warpvec-")) / f"{name}.html"
    write_report(page, data, photo=photo, background=background, history=records, name=name)
    if report is None and not webbrowser.open(page.as_uri()):
        click.echo(f"no browser could be started; open {page}", err=True)


def _read_history(path: str) -> Any:
    """The records in what a command said with --json, or a list of them alone."""
    try:
        found = json.loads(read_bytes(path, "--history"))
        return found.get("history", found) if isinstance(found, dict) else found
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"--history must be a JSON file, got {path!r} ({error}); write it again") from error
