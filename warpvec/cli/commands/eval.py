"""``warpvec eval``: compare an SVG with an image."""

from __future__ import annotations

import click

from warpvec.cli.arguments import background_option, check_one_stdin, json_option, read_photo, read_svg_bytes
from warpvec.cli.summary import print_summary


@click.command("eval", short_help="Measure how well an SVG matches an image.")
@click.argument("source", metavar="IMAGE")
@click.argument("svg", metavar="SVG")
@background_option
@json_option
def evaluate(source: str, svg: str, background: str | None, as_json: bool) -> None:
    """Measure how well the file SVG, drawn by resvg, matches IMAGE. One of them may be - for stdin."""
    check_one_stdin({"IMAGE": source, "SVG": svg})
    from warpvec.svg.measure import evaluate as measure

    photo = read_photo(source, background, "IMAGE")
    print_summary(measure(read_svg_bytes(svg), photo), "SVG" if svg == "-" else svg, as_json)
