"""``warpvec refine``: a drawing that is there already is fitted to the photo, and given more detail."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.commands.inputs import background_option, check_out, json_option, preset_option, read_source, read_svg
from warpvec.commands.report import report
from warpvec.config import FitConfig
from warpvec.errors import InputError
from warpvec.goal import Goal
from warpvec.options import SettingsCommand, requested

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from warpvec.scene import Scene
    from warpvec.svg_reader import Drawing

RATE = 0.4
"""Learning rates over those of a fit, as `warpvec.search.CORRECTION_RATE`: paths that stand well must not be thrown."""

ITERATIONS = 500
"""As many as a correction of the default preset has."""


@click.command(cls=SettingsCommand)
@click.argument("source", metavar="IN")
@click.argument("out", metavar="OUT")
@click.option("--from", "drawing", metavar="SVG", required=True, help="The drawing to begin with.")
@preset_option
@background_option
@json_option
@click.option("-q", "--quiet", is_flag=True, help="No progress and no summary.")
@click.pass_context
def refine(
    ctx: click.Context,
    /,
    source: str,
    out: str,
    drawing: str,
    preset: str,
    background: str | None,
    as_json: bool,
    quiet: bool,
    **settings: Any,
) -> None:
    """Fit the drawing SVG to the photo IN and write it to OUT.

    The drawing is warpvec's own, or any file of filled paths; what a scene of closed paths cannot say (strokes,
    gradients, holes) is named and left out. Its layers stay. With --curves above the number of its paths new ones are
    added on top, where the picture is worst; below, the least important go. --iterations is 500 and --recycle-gap 0
    unless given, and learning rates are 0.4 times those of a run.
    """
    settings["iterations"] = settings["iterations"] or ITERATIONS
    if settings["recycle_gap"] is None:
        settings["recycle_gap"] = 0
    check_out(out)
    begun = _read_drawing(drawing)
    settings["segments"] = begun.scene.piece_count
    if settings["precision"] is None:
        settings["precision"] = begun.precision
    config, goal = requested(preset, settings)
    if settings["curves"] is None and not goal:
        config = replace(config, curves=max(1, len(begun.scene)))
    config = replace(config, lr_scale=RATE * config.lr_scale)
    for text in begun.omitted:
        click.echo(f"warpvec: {drawing}: {text}", err=True)
    _fit(ctx, source, out, begun, config, goal, background, as_json=as_json, quiet=quiet)


def _fit(
    ctx: click.Context,
    source: str,
    out: str,
    begun: Drawing,
    config: FitConfig,
    goal: Goal,
    background: str | None,
    *,
    as_json: bool,
    quiet: bool,
) -> None:
    from warpvec.api import fit_photo
    from warpvec.image import read_image
    from warpvec.progress import show_progress

    photo = read_image(read_source(source), background, name="IN")
    start = _on_photo(begun, photo)
    title = None if source == "-" else Path(source).stem
    with show_progress(sys.stderr, quiet=quiet) as show:
        result = fit_photo(photo, config, title=title, goal=goal, start=start, on_progress=show)
    if out == "-":
        sys.stdout.buffer.write(result.svg().encode())
    else:
        result.save(out)
    if as_json or not quiet:
        report(result.metrics, out, as_json)
    if result.interrupted:
        ctx.exit(130)


def _read_drawing(path: str) -> Drawing:
    from warpvec.svg_reader import read_svg as read_drawing

    begun = read_drawing(read_svg(path))
    if not len(begun.scene):
        raise InputError(f"--from must hold filled paths, got {path!r} without any; use warpvec run to begin anew")
    return begun


def _on_photo(begun: Drawing, photo: NDArray[np.float32]) -> Scene:
    """The drawing in the photo's pixels."""
    height, width = photo.shape[:2]
    if abs(begun.width * height / begun.height - width) > max(1.0, width / height):
        raise InputError(
            f"--from must have the proportions of the photo, {width} x {height}, got {begun.width:g} x"
            f" {begun.height:g}; is it of another photo?"
        )
    return begun.scene.scaled(width / begun.width, height / begun.height)
