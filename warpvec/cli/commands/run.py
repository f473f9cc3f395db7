"""``warpvec run``: turn an image into an SVG."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.cli.arguments import (
    background_option,
    check_out,
    check_page,
    json_option,
    preset_option,
    quiet_option,
    read_source,
    verbose_option,
    write_svg_file,
)
from warpvec.cli.loading import quick_loading
from warpvec.cli.options import file_options, options_of_mode, requested, stated
from warpvec.cli.settings_command import SettingsCommand
from warpvec.cli.side_files import SideFile
from warpvec.cli.summary import end_fit
from warpvec.cli.value_types import WholeNumber
from warpvec.config.fit_config import MACHINE_SETTINGS
from warpvec.config.presets import PRESETS
from warpvec.config.toml_file import write_settings
from warpvec.errors import InputError
from warpvec.files import check_writable

if TYPE_CHECKING:
    from warpvec.config.fit_config import FitConfig
    from warpvec.fit.checkpoint import Checkpoint
    from warpvec.vectorization.goal import Goal
    from warpvec.vectorization.result import Result


@click.command(cls=SettingsCommand, short_help="Turn an image into an SVG.")
@click.argument("source", metavar="IN")
@click.argument("out", metavar="[OUT]", required=False)
@preset_option
@background_option
@click.option("--report", "page", metavar="FILE", help="Write an HTML page to inspect and edit the result.")
@click.option("--video", metavar="FILE", help="Record the fit as .mp4, .gif or .webp.")
@click.option("--save-frames", metavar="DIR", help="Record the fit as PNG files in a folder.")
@click.option("--checkpoint", metavar="FILE", help="Save the state of the fit here every --every iterations.")
@click.option("--resume", metavar="FILE", help="Continue from a checkpoint, with its settings.")
@click.option(
    "--every", type=WholeNumber(minimum=1), default=50, metavar="N",
    help="Iterations between two frames (1 in fits of fewer) and between two checkpoints. [50]",
)  # fmt: skip
@click.option("--placeholder", is_flag=True, help="Print a rough drawing of 1000 bytes as a data URI.")
@json_option
@verbose_option
@quiet_option
@click.pass_context
def run(ctx: click.Context, /, source: str, out: str, **options: Any) -> None:
    """Turn the image IN (PNG, JPEG, WebP, TIFF, BMP, GIF; - for stdin) into the SVG file OUT. For photo.png, OUT is
    photo.svg unless given. OUT may end in .svgz (gzipped), .pdf or .eps; - is stdout. Ctrl-C saves the best result.

    The mode follows the picture: paths are fitted to photos, and the regions of logos, icons and drawings are outlined.
    Settings that only one mode has decide it; the help of each says so.

    --placeholder is for web pages to show while the image loads: it prints a drawing as a data URI of at most
    --max-bytes (300 to 5000, 1000 if not given). If OUT is an .svg file, it gets the SVG. No other setting changes it.

    With --max-bytes, a photo is fitted once, in 1.25 times as many iterations as asked for. Its paths have --segments
    cubics; if these are not given, 3 in the mean, or 2 in files of many bytes and with --gzip.

    The defaults in brackets are those of the preset "default"; other presets change some of them.
    """
    if options["placeholder"]:
        from warpvec.cli.placeholder import run_placeholder

        run_placeholder(ctx, source, out, options)
        return
    config, goal = _requested(out, options)
    _check_outputs(out, options, goal)
    config = _with_mode_of_checkpoints(config, options)
    checkpoint = None if options["resume"] is None else _resumed(config, options)
    config = config if checkpoint is None else checkpoint.config
    result = _fit(source, out, config, goal, checkpoint, options)
    end_fit(ctx, result, out, options, options_of_mode(options["preset"], options))


def _requested(out: str, options: dict[str, Any]) -> tuple[FitConfig, Goal]:
    gzip = options["gzip"] or Path(out).suffix.lower() == ".svgz"
    return requested(options["preset"], {**options, "gzip": gzip})


def _check_outputs(out: str, options: dict[str, Any], goal: Goal) -> None:
    check_out(out, may_print=True)
    if options["page"] is not None:
        check_page(options["page"])
    if options["checkpoint"] is not None:
        check_writable(options["checkpoint"], "--checkpoint")
    if goal and (options["checkpoint"] or options["resume"]):
        name = "--resume" if options["resume"] else "--checkpoint"
        rule = "must be given without a goal for the file, whose fits have no state"
        raise InputError(name, rule, remedy="leave one of them out")


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
    from dataclasses import replace

    return replace(config, mode="photo")


def _resumed(config: FitConfig, options: dict[str, Any]) -> Checkpoint:
    """Read the checkpoint to continue from.

    Args:
        config: what the options lead to.
        options: settings that are given, here or by a preset, must be those of the checkpoint.
    """
    from dataclasses import replace

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
    source: str, out: str, config: FitConfig, goal: Goal, checkpoint: Checkpoint | None, options: dict[str, Any]
) -> Result:
    """Fit the image and write the SVG, the page and the settings.

    Raises:
        OSError: the SVG cannot be written. What else cannot is a warning: it is worth less than the fit.
    """
    from warpvec.image.read import read_image

    image = read_source(source, "IN")
    photo = read_image(image, options["background"], name="IN")
    with quick_loading():  # These imports take a second. By now most mistakes have been reported.
        from warpvec.cli.frames import watch
        from warpvec.rendering.launch import resolve_device
        from warpvec.vectorization.api import fit_photo, title_of

    resolve_device(config.device)
    frames, video, every = options["save_frames"], options["video"], options["every"]
    failure: OSError | None = None
    with watch(photo, config, frames, video, every, quiet=options["quiet"]) as watcher:
        if options["write_config"] is not None:
            settings = stated(options["preset"], options["background"], options, config)
            SideFile("--write-config").attempt(write_settings, options["write_config"], settings)
        result = fit_photo(
            photo, config, title=title_of(image), goal=goal, on_progress=watcher,
            checkpoint=options["checkpoint"], every=every, resume=checkpoint,
            on_checkpoint_error=SideFile("--checkpoint").fail, file_options=file_options(options),
        )  # fmt: skip
        # Written before the video is finished: the fit is worth more than its video.
        try:
            write_svg_file(result.svg(), out)
        except OSError as error:
            failure = error
        watcher.end(result)
    if options["page"] is not None:
        SideFile("--report").attempt(_write_page, options["page"], result, out)
    if failure is not None:  # only now, so that the video and the page are there
        raise failure
    return result


def _write_page(page: str, result: Result, out: str) -> None:
    from warpvec.viewer.page import write_page

    name = None if out == "-" else Path(out).stem
    write_page(page, result.svg().encode(), photo=result.photo, history=result.history, name=name)
