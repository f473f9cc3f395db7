"""``warpvec run``: a photo becomes an SVG."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.commands.inputs import background_option, check_out, json_option, preset_option, read_source
from warpvec.commands.report import report
from warpvec.config import FitConfig, make_config
from warpvec.errors import InputError
from warpvec.options import SettingsCommand

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from warpvec.api import Result
    from warpvec.fit import Progress


@click.command(cls=SettingsCommand)
@click.argument("source", metavar="IN")
@click.argument("out", metavar="OUT")
@preset_option
@background_option
@click.option("--save-frames", metavar="DIR", help="Folder for a PNG of the scene now and then.")
@click.option("--every", type=click.IntRange(min=1), default=50, show_default=True, help="Iterations between frames.")
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
    every: int,
    as_json: bool,
    quiet: bool,
    **settings: Any,
) -> None:
    """Turn the photo IN into the SVG OUT.

    IN is a PNG, JPEG, WebP, TIFF, BMP or GIF file, or - for stdin. OUT ends in .svg, or in .svgz to be gzipped, or
    is - for stdout. Ctrl-C ends the fit and saves the best result so far.

    The settings below show the defaults of the default preset.
    """
    config = make_config(preset, **{name: value for name, value in settings.items() if value is not None})
    check_out(out)
    from warpvec.image import read_image

    photo = read_image(read_source(source), background, name="IN")
    # Only now what takes seconds to import: most mistakes have been found by then.
    from warpvec.api import fit_photo
    from warpvec.launch import resolve_device
    from warpvec.progress import show_progress

    resolve_device(config.device)
    save_frame = _frame_saver(save_frames, every, photo, config) if save_frames is not None else None
    title = None if source == "-" else Path(source).stem
    with show_progress(sys.stderr, quiet=quiet) as show:
        result = fit_photo(photo, config, title=title, on_progress=_both(show, save_frame))
    _write_result(result, out)
    if as_json or not quiet:
        report(result.metrics, out, as_json)
    if result.interrupted:
        ctx.exit(130)


def _frame_saver(folder: str, every: int, photo: NDArray[np.float32], config: FitConfig) -> Callable[[Progress], None]:
    """Writes the scene of every ``every``-th iteration, at the size of the fit, to ``folder``."""
    from warpvec.api import draw_as_fitted
    from warpvec.image import fit_image, write_png

    height, width = fit_image(photo, config.fit_size).shape[:2]
    _make_folder(folder)

    def save(progress: Progress) -> None:
        if progress.iteration % every == 0 or progress.iteration == progress.iteration_count:
            frame = draw_as_fitted(progress.scene(), height, width, config)
            write_png(Path(folder) / f"frame-{progress.iteration:06}.png", frame)

    return save


def _make_folder(folder: str) -> None:
    if not folder:  # which pathlib takes for the current folder
        raise InputError("--save-frames must be a folder or a name for one, got ''; choose another")
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(
            f"--save-frames must be a folder or a name for one, got {folder!r} ({reason}); choose another"
        ) from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"--save-frames must be a folder you may write to, got {folder!r}; choose another")


def _both(first: Callable[[Progress], None], second: Callable[[Progress], None] | None) -> Callable[[Progress], None]:
    def call(progress: Progress) -> None:
        first(progress)
        if second is not None:
            second(progress)

    return call


def _write_result(result: Result, out: str) -> None:
    if out == "-":
        sys.stdout.buffer.write(result.svg().encode())
    else:
        result.save(out)
