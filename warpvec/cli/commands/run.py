"""``warpvec run``: turn an image into an SVG."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.cli.arguments import (
    check_out,
    check_page,
    page_option,
    read_photo_file,
    read_svg_bytes,
    report_options,
    start_options,
    write_result,
)
from warpvec.cli.cutting import check_cutting, cut, cut_options
from warpvec.cli.loading import quick_loading
from warpvec.cli.options import file_options, options_of_mode, requested
from warpvec.cli.settings_command import SettingsCommand
from warpvec.cli.side_files import SideFile, write_config
from warpvec.cli.signals import drawing_listener
from warpvec.cli.summary import end_fit
from warpvec.config.fit_config import MACHINE_SETTINGS
from warpvec.config.presets import PRESETS
from warpvec.errors import InputError
from warpvec.files import check_writable, write_atomic
from warpvec.goals.goal import refuse_states
from warpvec.purposes.table import PURPOSES
from warpvec.writers.registry import writer_of

if TYPE_CHECKING:
    from warpvec.config.fit_config import FitConfig
    from warpvec.fit.checkpoint import Checkpoint
    from warpvec.goals.goal import Goal
    from warpvec.image.read import PictureFile
    from warpvec.result import Result


@click.command(cls=SettingsCommand, short_help="Turn an image into an SVG.")
@click.argument("source", metavar="IN")
@click.argument("out", metavar="[OUT]", required=False)
@start_options
@page_option
@click.option("--from-svg", is_flag=True, help="IN is an SVG, which is drawn at its size and vectorized anew.")
@click.option("--report", "page", metavar="FILE", help="Write an HTML page to inspect and edit the result.")
@click.option("--why", metavar="FILE", help="Write each decision about the drawing as a line of JSON.")
@click.option("--video", metavar="FILE", help="Record the fit as .mp4, .gif or .webp.")
@click.option("--save-frames", metavar="DIR", help="Record the fit as PNG files in a folder.")
@click.option("--checkpoint", metavar="FILE", help="Save the state of the fit here every --every iterations.")
@click.option("--resume", metavar="FILE", help="Continue from a checkpoint, with its settings.")
@click.option(
    "--every", type=click.IntRange(min=1), default=50, metavar="N",
    help="Iterations from one frame or checkpoint to the next. In shorter fits every iteration is a frame. [50]",
)  # fmt: skip
@click.option("--placeholder", is_flag=True, help="Print a rough drawing of 1000 bytes as a data URI.")
@cut_options
@report_options
@click.pass_context
def run(ctx: click.Context, /, source: str, out: str, **options: Any) -> None:
    """Turn the image IN (PNG, JPEG, WebP, TIFF ...; - for stdin) into OUT: {suffixes}, or - for
    stdout. Without OUT, photo.png becomes photo.svg.

    The mode follows the picture: paths are fitted to photos, and the regions of logos, icons and drawings are outlined.
    A setting that only one mode has selects that mode.

    --placeholder prints a rough drawing as a data URI, for web pages to show while the image loads. It has at most
    --max-bytes (300 to 5000, by default 1000). If OUT is given, the drawing is also written to this .svg file. Other
    settings do not change a placeholder.

    With --max-bytes, a photo is fitted once, with 1.25 times the iterations. Its paths have --segments cubics on
    average; by default 3, or 2 in large files and with --gzip.

    The defaults in brackets are those of the preset "default"; other presets change some of them.
    """
    if options["placeholder"]:
        from warpvec.cli.placeholder import run_placeholder

        run_placeholder(ctx, source, out, options)
        return
    gzip = options["gzip"] or Path(out).suffix.lower() == ".svgz"
    options["purpose"] = options["purpose"] or writer_of(out).purpose
    config, goal = requested({**options, "gzip": gzip})
    _check_outputs(out, options, goal)
    check_cutting(options)
    config = _with_mode_of_checkpoints(config, options)
    checkpoint = None if options["resume"] is None else _resumed(config, options)
    config = config if checkpoint is None else checkpoint.config
    picture = _read(source, options)
    words = _take_size(picture, options)
    result = _fit(picture, source, out, config, goal, checkpoint, options)
    more = {**(cut(result, out, options) or {}), **({"size_words": words} if words else {})}
    end_fit(ctx, result, out, options, options_of_mode(options), more)


def _read(source: str, options: dict[str, Any]) -> PictureFile:
    """Read the image, or draw the SVG.

    Raises:
        InputError: it cannot be read or drawn.
    """
    if not options["from_svg"]:
        return read_photo_file(source, options["background"], "IN", options["page_number"])
    if options["page_number"] is not None:
        raise InputError("--page", "must not be given with --from-svg", remedy="leave one of them out")
    from warpvec.image.read import read_picture
    from warpvec.svg.measure import draw

    return read_picture(draw(read_svg_bytes(source, "IN"), transparent=True), options["background"], "IN")


def _take_size(picture: PictureFile, options: dict[str, Any]) -> str | None:
    """Let the width that the file states in the world be that of the drawing, unless one is given, and say so."""
    if options["size"] is not None or picture.meters is None:
        return None
    from warpvec.svg.units import scaled_size, world_size

    size = world_size(picture.meters)
    if size is not None:
        options["size"] = size
        return f"as wide as the GeoTIFF states, {picture.meters:,.6g} m; --size 100% for pixels"
    scale, example = scaled_size(picture.meters)
    return f"the GeoTIFF shows {picture.meters:,.6g} m: --size {example} draws it 1 : {scale:,}"


def _check_outputs(out: str, options: dict[str, Any], goal: Goal) -> None:
    check_out(out, any_kind=True)
    if options["page"] is not None:
        check_page(options["page"])
    for name in ("checkpoint", "why"):
        if options[name] is not None:
            check_writable(options[name], f"--{name}")
    refuse_states(goal, {"--resume": options["resume"], "--checkpoint": options["checkpoint"]})


def _with_mode_of_checkpoints(config: FitConfig, options: dict[str, Any]) -> FitConfig:
    """Return ``config`` with the mode photo if the state of the fit is saved or read: only that fit has one.

    Raises:
        InputError: another mode is asked for.
    """
    name = next((name for name in ("resume", "checkpoint") if options[name] is not None), None)
    if name is None or config.mode == "photo":
        return config
    if config.mode != "auto":
        rule = f"must not be given in the mode {config.mode}, whose work takes seconds"
        raise InputError(f"--{name}", rule, remedy="leave it out, or give --mode photo")
    return replace(config, mode="photo")


def _resumed(config: FitConfig, options: dict[str, Any]) -> Checkpoint:
    """Read the checkpoint to continue from.

    Args:
        config: what the options lead to.
        options: settings that are given, here or by a preset, must be those of the checkpoint.
    """
    from warpvec.fit.checkpoint import read_checkpoint

    checkpoint = read_checkpoint(options["resume"])
    kept = checkpoint.config.to_dict()
    given = {name: value for name, value in options.items() if name in kept and value is not None}
    given.pop("mode", None)  # a checkpoint is of a photo's fit
    for name, value in {**PRESETS[options["preset"]].settings, **given}.items():
        if name not in MACHINE_SETTINGS and getattr(config, name) != kept[name]:
            raise InputError(name, f"must be as in the checkpoint, {kept[name]!r}", repr(value), "leave it out")
    machine = {name: given[name] for name in MACHINE_SETTINGS if name in given}
    return replace(checkpoint, config=replace(checkpoint.config, **machine))


def _fit(
    picture: PictureFile,
    source: str,
    out: str,
    config: FitConfig,
    goal: Goal,
    checkpoint: Checkpoint | None,
    options: dict[str, Any],
) -> Result:
    """Fit the ``picture`` of ``source`` and write the SVG, the page and the settings.

    Raises:
        OSError: the SVG cannot be written. What else cannot is a warning: it is worth less than the fit.
    """
    photo, unread, _ = picture
    title = None if source == "-" else Path(source).stem
    with quick_loading():  # These imports take a second. By now most mistakes have been reported.
        from warpvec.cli.frames import recorded
        from warpvec.fit.checkpoint import saving_to
        from warpvec.modes.choice import draw_picture
        from warpvec.modes.photo import Photo
        from warpvec.modes.request import Request
        from warpvec.rendering.launch import resolve_device
        from warpvec.result import Result
        from warpvec.watch.decisions import noted
        from warpvec.watch.watch import Watch

    resolve_device(config.device)
    frames, video, every = options["save_frames"], options["video"], options["every"]
    failure: OSError | InputError | click.ClickException | None = None
    with recorded(photo, config, frames, video, every, quiet=options["quiet"]) as recorder:
        write_config(options, config)
        watch = Watch(recorder, config.time_budget, drawing_listener())
        given = file_options(options)
        request = Request.of(photo, config, goal, title=title, unread=unread, options=given, watch=watch)
        photo_mode, path = Photo(resume=checkpoint), options["checkpoint"]
        if path is not None:  # saving may fail without ending the fit
            warn = SideFile("--checkpoint").fail
            photo_mode = replace(photo_mode, saving=saving_to(path, every, config, request.picture.reduced, warn))
        with ExitStack() as stack:
            decisions = stack.enter_context(noted()) if options["why"] is not None else []
            result = Result(draw_picture(request, photo_mode), watch.facts())
        # Written before the video is finished: the fit is worth more than its video.
        try:
            write_result(result, out)
        except (OSError, InputError, click.ClickException) as error:
            failure = error
        recorder.end(result)
    if PURPOSES[options["purpose"]].has_picture and out != "-" and failure is None:
        beside = f"{out}.png"
        SideFile(f"--for {options['purpose']}").attempt(write_atomic, beside, result.encoded(beside))
    if options["why"] is not None:
        lines = "".join(f"{decision.line()}\n" for decision in decisions)
        SideFile("--why").attempt(write_atomic, options["why"], lines.encode())
    if options["page"] is not None:
        from warpvec.drawing.not_kept import not_kept
        from warpvec.viewer.page import write_page

        svg, history, name = result.svg().encode(), result.history, None if out == "-" else Path(out).stem
        lost = list(not_kept(result.drawing).values())
        SideFile("--report").attempt(
            write_page, options["page"], svg, photo=photo, history=history, name=name, not_kept=lost
        )
    if failure is not None:  # only now, so that the video and the page are there
        raise failure
    return result
