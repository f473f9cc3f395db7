"""``warpvec refine``: fit an SVG that exists already to its photo, and give it more detail."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import click

from warpvec.checks import in_one_line
from warpvec.cli.arguments import (
    background_option,
    check_out,
    json_option,
    preset_option,
    quiet_option,
    read_source,
    read_svg_bytes,
    verbose_option,
    write_svg_file,
)
from warpvec.cli.loading import quick_loading
from warpvec.cli.options import GOALS, file_options, requested, stated
from warpvec.cli.settings_command import SettingsCommand
from warpvec.cli.side_files import SideFile
from warpvec.cli.summary import end_fit
from warpvec.config.toml_file import write_settings

if TYPE_CHECKING:
    from warpvec.config.fit_config import FitConfig
    from warpvec.svg.read import LoadedSvg
    from warpvec.vectorization.goal import Goal

DECIDED = ("mode", "curves", "iterations", "precision", "recycle_gap", "segments")
"""Settings that the drawing or the command decides unless they are given. Then --write-config leaves them out."""


@click.command(cls=SettingsCommand, short_help="Fit an existing SVG to its image and add detail.")
@click.argument("source", metavar="IN")
@click.argument("out", metavar="OUT")
@click.option("--from", "drawing", metavar="SVG", required=True, help="SVG file to begin with.")
@preset_option
@background_option
@json_option
@verbose_option
@quiet_option
@click.option("--free", is_flag=True, help="Let corners, lines, opacities and crossings change too.")
@click.pass_context
def refine(ctx: click.Context, /, source: str, out: str, drawing: str, free: bool, **options: Any) -> None:
    """Fit the paths of the file SVG to the image IN and write them to OUT.

    SVG is a file of warpvec, or any file of filled paths. Content of other kinds is reported. OUT has the size,
    the layers and the paths of the drawing: lines stay lines, smooth nodes smooth, opaque paths opaque, and no path
    crosses itself more often; --free lifts these bounds. The file is never worse than the drawing: if the
    fit finds nothing better, it is the drawing unchanged. --iterations 0 writes the drawing as it was read. --opaque
    first makes every path opaque, which may make it worse.

    If --curves is above the number of paths, new ones are added on top where the picture is worst; if it is below,
    those that matter least are removed. With these, a goal, --recycle-gap, --colors, --palette, --lod or
    --min-area the fit is that of run from the drawing on, with 0.4 times its learning rates, and without these bounds.

    --flat, --initial-curves, --initial-radius and --radius-decay are never used. A fit that keeps the paths
    of the drawing uses --lr-scale, but no other learning rate and no weight of the loss.
    """
    check_out(out, may_print=True)
    with quick_loading():
        from warpvec.vectorization.refine import form_of, place_on_photo, read_drawing, refine_photo

    data = read_svg_bytes(drawing, "--from")
    loaded = read_drawing(data, "--from")
    given = {name: value for name, value in options.items() if value is not None}
    config, goal, count = _settings(options, given, loaded)
    for text in loaded.omitted:
        click.echo(in_one_line(f"warpvec: {drawing}: {text}"), err=True)
    from warpvec.cli.progress import show_progress
    from warpvec.image.read import read_image
    from warpvec.rendering.launch import resolve_device
    from warpvec.vectorization.api import title_of

    resolve_device(config.device)
    image = read_source(source, "IN")
    photo = read_image(image, options["background"], name="IN")
    start, form = place_on_photo(loaded, photo, "--from"), form_of(loaded, data, config, photo)
    _write_config(options, given, config)
    kept: dict[str, Any] = {"title": title_of(image), "form": form, "iterations": count, "free": free, "given": data}
    with show_progress(sys.stderr, quiet=options["quiet"]) as show:
        result = refine_photo(photo, start, config, goal, on_progress=show, file_options=file_options(options), **kept)
    write_svg_file(result.svg(), out)
    if count != 0 and config.gradients == "auto" and not options["quiet"] and not result.metrics["gradients"]:
        click.echo("warpvec: no path got a gradient: none would have made the picture plainly better", err=True)
    end_fit(ctx, result, out, options)


def _settings(options: dict[str, Any], given: dict[str, Any], drawing: LoadedSvg) -> tuple[FitConfig, Goal, int | None]:
    """Return the settings of the fit, its goal, and 0 if there is no fit, else None."""
    from warpvec.vectorization.refine import refine_config, with_drawing_settings, without_zero_iterations

    has_goal = any(options[name] for name in GOALS) or options["curves"] == "auto"
    kept, is_fitted = (given, True) if has_goal else without_zero_iterations(given)
    config, goal = requested(options["preset"], with_drawing_settings(kept, drawing))
    return refine_config(config, given, goal, drawing), goal, None if is_fitted else 0


def _write_config(options: dict[str, Any], given: dict[str, Any], config: FitConfig) -> None:
    if options["write_config"] is not None:
        found = stated(options["preset"], options["background"], options, config)
        kept = {name: value for name, value in found.items() if name in given or name not in DECIDED}
        SideFile("--write-config").attempt(write_settings, options["write_config"], kept)
