"""``warpvec run``: a photo becomes an SVG."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.cli.arguments import background_option, check_out, json_option, preset_option, read_source, write_svg
from warpvec.cli.options import SettingsCommand, requested, stated
from warpvec.cli.report import report
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


@click.command(cls=SettingsCommand)
@click.argument("source", metavar="IN")
@click.argument("out", metavar="OUT")
@preset_option
@background_option
@click.option("--save-frames", metavar="DIR", help="Folder for a PNG of the scene now and then.")
@click.option("--video", metavar="FILE", help="The same as an .mp4, .gif or .webp.")
@click.option("--checkpoint", metavar="FILE", help="Keep the state of the fit here, to go on after a crash.")
@click.option("--resume", metavar="FILE", help="Go on from a checkpoint, with its settings.")
@click.option(
    "--every",
    type=click.IntRange(min=1),
    default=50,
    show_default=True,
    help="Iterations between frames and between checkpoints.",
)
@click.option("--report", "page", metavar="FILE", help="Write a page (HTML) to look at the result and edit it.")
@json_option
@click.option("-q", "--quiet", is_flag=True, help="No progress and no summary.")
@click.pass_context
def run(
    ctx: click.Context,
    /,
    source: str,
    out: str,
    preset: str,
    background: str | None,
    save_frames: str | None,
    video: str | None,
    checkpoint: str | None,
    resume: str | None,
    every: int,
    page: str | None,
    as_json: bool,
    quiet: bool,
    write_config: str | None,
    **settings: Any,
) -> None:
    """Turn the photo IN into the SVG OUT.

    IN is a PNG, JPEG, WebP, TIFF, BMP or GIF file, or - for stdin. OUT ends in .svg, or in .svgz to be gzipped, or
    is - for stdout. Ctrl-C ends the fit and saves the best result so far.

    The settings below show the defaults of the default preset.
    """
    gzip = settings["gzip"] or Path(out).suffix.lower() == ".svgz"
    config, goal = requested(preset, {**settings, "gzip": gzip})
    _check_places(out, page, checkpoint, resume, goal)
    from warpvec.image.read import read_image

    state = None if resume is None else _resumed(resume, config, {**PRESETS[preset], **_given(settings)})
    config = config if state is None else state.config
    photo_bytes = read_source(source)
    photo = read_image(photo_bytes, background, name="IN")
    # Only now what takes seconds to import: most mistakes have been found by then.
    from warpvec.cli.frames import watch
    from warpvec.rendering.launch import resolve_device
    from warpvec.vectorization.api import fit_photo

    resolve_device(config.device)
    title = None if source == "-" else Path(source).stem
    with ExitStack() as stack:
        on_progress = stack.enter_context(watch(photo, config, save_frames, video, every, quiet=quiet))
        if write_config is not None:
            write_settings(write_config, stated(preset, background, settings, config))
        result = fit_photo(
            photo, config, title=title, goal=goal, on_progress=on_progress,
            checkpoint=checkpoint, every=every, resume=state,
        )  # fmt: skip
        # Before the video, which may fail: a fit is worth more than the film of it.
        write_svg(result.svg(), out)
        if page is not None:
            _write_page(page, result, out, photo_bytes, background)
    if as_json or not quiet:
        report({**result.metrics, "history": result.history}, out, as_json)
    if result.interrupted:
        ctx.exit(130)


def _check_places(out: str, page: str | None, checkpoint: str | None, resume: str | None, goal: Goal) -> None:
    check_out(out)
    if page is not None:
        check_writable(page, "--report")
    if checkpoint is not None:
        check_writable(checkpoint, "--checkpoint")
    if goal and (checkpoint or resume):
        name = "--resume" if resume else "--checkpoint"
        raise InputError(f"{name} must stand without a goal, which takes several fits; leave one of them out")


def _given(options: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _resumed(path: str, config: FitConfig, options: dict[str, Any]) -> Checkpoint:
    """The checkpoint in ``path``, of which none of the ``options`` that were given, by a preset too, may differ."""
    from dataclasses import replace

    from warpvec.fit.checkpoint import read_checkpoint

    checkpoint = read_checkpoint(path)
    kept = checkpoint.config.to_dict()
    for name, value in options.items():
        if name in kept and name not in MACHINE_SETTINGS and getattr(config, name) != kept[name]:
            raise InputError(f"{name} must be as in the checkpoint, {kept[name]!r}, got {value!r}; leave it out")
    free = {name: options[name] for name in MACHINE_SETTINGS if name in options}
    return replace(checkpoint, config=replace(checkpoint.config, **free))


def _write_page(page: str, result: Result, out: str, photo: str | bytes, background: str | None) -> None:
    from warpvec.viewer.page import write_report

    data = photo if isinstance(photo, bytes) else Path(photo).read_bytes()
    name = None if out == "-" else Path(out).stem
    write_report(page, result.svg().encode(), photo=data, background=background, history=result.history, name=name)
