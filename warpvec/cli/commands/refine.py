"""``warpvec refine``: fit an existing SVG to its photo, and add detail."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from warpvec.checks import in_one_line
from warpvec.cli.arguments import (
    check_out,
    page_option,
    read_photo_file,
    read_svg_bytes,
    report_options,
    start_options,
    write_result,
)
from warpvec.cli.cutting import check_cutting, cut, cut_options
from warpvec.cli.loading import quick_loading
from warpvec.cli.options import file_options, given_options
from warpvec.cli.settings_command import SettingsCommand
from warpvec.cli.side_files import write_config
from warpvec.cli.signals import drawing_listener
from warpvec.cli.summary import end_fit

DECIDED = ("mode", "curves", "iterations", "precision", "recycle_gap", "segments")
"""Settings that the drawing or the command decides unless they are given. Then --write-config leaves them out."""


@click.command(cls=SettingsCommand, short_help="Fit an existing SVG to its image and add detail.")
@click.argument("source", metavar="IN")
@click.argument("out", metavar="OUT")
@click.option("--from", "drawing", metavar="SVG", required=True, help="SVG file to begin with.")
@start_options
@page_option
@cut_options
@report_options
@click.option("--free", is_flag=True, help="Let corners, lines, opacities and crossings change too.")
@click.pass_context
def refine(ctx: click.Context, /, source: str, out: str, drawing: str, free: bool, **options: Any) -> None:
    """Fit the paths of the file SVG to the image IN and write them to OUT.

    SVG is a file of warpvec, or any file of filled paths. Other content is left out and reported. OUT has the size,
    the layers and the paths of the drawing: lines stay lines, smooth nodes stay smooth, opaque paths stay opaque, and
    no path crosses itself more often. --free lifts these bounds. The result is never worse than the drawing: if the fit
    finds nothing better, OUT is the drawing, unchanged. --iterations 0 writes the drawing as it was read. --opaque
    first makes every path opaque, which may make the drawing worse. With --blur, the drawing is blurred before it is
    compared with the image: OUT is sharp.

    If --curves is above the number of paths, new paths are added on top where the picture is worst, unless the drawing
    is better without them. If --curves is below, the paths that matter least are removed. With a new number of paths,
    a goal, --recycle-gap, --colors, --palette, --lod or --min-area, the drawing is fitted like a photo: without the
    bounds above, and with 0.4 times the learning rates of run.

    --one-generation, --initial-curves, --initial-radius and --radius-decay are never used. A fit that keeps the paths
    of the drawing uses --lr-scale, but no other learning rate and no weight of the loss.
    """
    check_out(out, any_kind=True)
    check_cutting(options)
    with quick_loading():
        from warpvec.drawing.given import place_on_picture, read_drawing
        from warpvec.modes.refine import Refine, blur_to_undo, refine_settings
        from warpvec.modes.request import Request

    data = read_svg_bytes(drawing, "--from")
    loaded = read_drawing(data, "--from")
    given = given_options(options)
    config, goal, iterations = refine_settings(loaded, options["preset"], given)
    for text in loaded.omitted:
        click.echo(in_one_line(f"warpvec: {drawing}: {text}"), err=True)
    from warpvec.cli.progress import show_progress
    from warpvec.rendering.launch import resolve_device
    from warpvec.result import Result
    from warpvec.watch.watch import Watch

    resolve_device(config.device)
    pixels, unread, _ = read_photo_file(source, options["background"], "IN", options["page_number"])
    title = None if source == "-" else Path(source).stem
    mode = Refine(loaded, data, iterations, free, name="--from", blur=blur_to_undo(given))
    with show_progress(sys.stderr, quiet=options["quiet"]) as show:
        watch = Watch(show, config.time_budget, drawing_listener())
        given_file = file_options(options)
        request = Request.of(pixels, config, goal, title=title, unread=unread, options=given_file, watch=watch)
        place_on_picture(loaded, request.picture, "--from")  # report a wrong picture before anything is written
        write_config(options, config, undecided=[name for name in DECIDED if options[name] is None])
        result = Result(mode.draw(request), watch.facts())
    write_result(result, out)
    if iterations != 0 and config.gradients == "auto" and not options["quiet"] and not result.metrics["gradients"]:
        click.echo("warpvec: no path got a gradient: none would have made the picture plainly better", err=True)
    made = cut(result, out, options)
    end_fit(ctx, result, out, options, more=made)
