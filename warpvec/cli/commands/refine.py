"""``warpvec refine``: a drawing that is there already is fitted to the photo, and given more detail."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.cli.arguments import (
    background_option,
    check_out,
    json_option,
    preset_option,
    read_source,
    read_svg,
    write_svg,
)
from warpvec.cli.options import requested, stated
from warpvec.cli.report import report
from warpvec.cli.settings_command import SettingsCommand
from warpvec.config.fit_config import FitConfig
from warpvec.config.toml_file import write_settings
from warpvec.errors import InputError
from warpvec.vectorization.goal import CORRECTION_RATE, Goal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from warpvec.geometry.scene import Scene
    from warpvec.svg.read import LoadedSvg
    from warpvec.vectorization.result import Result

ITERATIONS = 500
"""As many as a correction of the default preset has."""

DECIDED = ("curves", "iterations", "precision", "recycle_gap", "segments")
"""What the drawing or the command decides unless it is given; it is not written to a file of settings."""


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
    write_config: str | None,
    **settings: Any,
) -> None:
    """Fit the drawing SVG to the photo IN and write it to OUT.

    The drawing is warpvec's own, or any file of filled paths; what a scene of closed paths cannot say (strokes,
    gradients, holes) is named and left out. Its layers stay. With --curves above the number of its paths new ones are
    added on top, where the picture is worst; below, the least important go. --recycle-gap is 0 unless given. Without a
    goal --iterations is 500 unless given, and learning rates are 0.4 times those of a run; with one the search for it
    shortens and slows its fits.

    --flat, --initial-curves, --initial-radius and --radius-decay are not used: the first paths are the drawing's.
    """
    check_out(out)
    begun = _read_drawing(drawing)
    config, goal = _settings(preset, settings, begun)
    for text in begun.omitted:
        click.echo(f"warpvec: {drawing}: {text}", err=True)
    from warpvec.image.read import read_image
    from warpvec.rendering.launch import resolve_device

    resolve_device(config.device)
    photo = read_image(read_source(source), background, name="IN")
    start = _on_photo(begun, photo)
    if write_config is not None:
        found = stated(preset, background, settings, config)
        unsaid = [name for name in DECIDED if settings[name] is None]
        write_settings(write_config, {name: value for name, value in found.items() if name not in unsaid})
    result = _fit(photo, start, config, goal, title=None if source == "-" else Path(source).stem, quiet=quiet)
    write_svg(result.svg(), out)
    if as_json or not quiet:
        report({**result.metrics, "history": result.history}, out, as_json)
    if result.interrupted:
        ctx.exit(130)


def _settings(preset: str, given: dict[str, Any], begun: LoadedSvg) -> tuple[FitConfig, Goal]:
    """The settings of the fit, and its goal, where ``given`` is None for what is not given."""
    if given["segments"] not in (None, begun.scene.piece_count):
        rule = f"segments must be the drawing's, {begun.scene.piece_count}, got {given['segments']}"
        raise InputError(f"{rule}; leave it out")
    decided = {"recycle_gap": 0, "precision": begun.precision, "segments": begun.scene.piece_count}
    settings = {**given, **{name: value for name, value in decided.items() if given[name] is None}}
    config, goal = requested(preset, settings)
    if config.path_model != "segments":
        rule = f"path_model must be segments to refine a drawing, got {config.path_model!r}"
        raise InputError(f"{rule}; give segments, or another --preset")
    if config.policy != "scaffolding":
        raise InputError(f"policy must be scaffolding to refine a drawing, got {config.policy!r}; give scaffolding")
    if goal:
        return config, goal
    if given["iterations"] is None:
        config = replace(config, iterations=ITERATIONS)
    if given["curves"] is None:
        config = replace(config, curves=max(1, len(begun.scene)))
    return config, goal


def _fit(
    photo: NDArray[np.float32], start: Scene, config: FitConfig, goal: Goal, *, title: str | None, quiet: bool
) -> Result:
    from warpvec.cli.progress import show_progress
    from warpvec.vectorization.api import fit_photo

    if not goal:
        config = replace(config, lr_scale=CORRECTION_RATE * config.lr_scale)
    with show_progress(sys.stderr, quiet=quiet) as show:
        return fit_photo(photo, config, title=title, goal=goal, start=start, on_progress=show)


def _read_drawing(path: str) -> LoadedSvg:
    from warpvec.svg.read import read_svg as read_drawing

    begun = read_drawing(read_svg(path, "--from"))
    if not len(begun.scene):
        raise InputError(f"--from must hold filled paths, got {path!r} without any; use warpvec run to begin anew")
    return begun


def _on_photo(begun: LoadedSvg, photo: NDArray[np.float32]) -> Scene:
    """The drawing in the photo's pixels."""
    height, width = photo.shape[:2]
    if abs(begun.width * height / begun.height - width) > max(1.0, width / height):
        raise InputError(
            f"--from must have the proportions of the photo, {width} x {height}, got {begun.width:g} x"
            f" {begun.height:g}; is it of another photo?"
        )
    return begun.scene.scaled(width / begun.width, height / begun.height)
