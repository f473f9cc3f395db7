"""``warpvec eval``: a file against a photo."""

from __future__ import annotations

import click

from warpvec.cli.arguments import background_option, json_option, read_source, read_svg
from warpvec.cli.report import report


@click.command("eval")
@click.argument("source", metavar="IN")
@click.argument("svg", metavar="OUT")
@background_option
@json_option
def evaluate(source: str, svg: str, background: str | None, as_json: bool) -> None:
    """Measure how well the SVG file OUT, drawn by resvg, matches the photo IN."""
    from warpvec.image.read import read_image
    from warpvec.svg.measure import evaluate as measure

    photo = read_image(read_source(source), background, name="IN")
    report(measure(read_svg(svg), photo), svg, as_json)
