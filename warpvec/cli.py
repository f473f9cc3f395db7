"""The command ``warpvec``: run, eval, info, sample.

Exit codes: 0 done, 1 unexpected failure, 2 wrong input or usage (nothing is written), 130 interrupted (``run`` has
then saved the best result so far). Messages are one line on stderr. Where OUT is ``-`` stdout carries the SVG alone
and the report goes to stderr. Torch and Warp are imported inside the commands, so that ``--help`` is quick.
"""

from __future__ import annotations

import json
import math
import os
import platform
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec import __version__
from warpvec.config import PRESETS, FitConfig, make_config
from warpvec.errors import InputError
from warpvec.files import check_writable
from warpvec.options import SettingsCommand

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from warpvec.api import Result
    from warpvec.fit import Progress

_INTERNAL_IMAGES = {"exact": "internally", "splat": "in the soft image"}
"""Renderer of the fit -> where the summary says the internal PSNR is from."""


class _Group(click.Group):
    """Errors in one line, with the exit codes that this module's docstring states."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise click.UsageError(_with_option_name(str(error))) from error
        except (click.ClickException, click.exceptions.Exit, click.Abort, BrokenPipeError):
            raise
        except Exception as error:
            if ctx.params["debug"]:
                raise
            hint = f"warpvec --debug {ctx.invoked_subcommand} ... shows where"
            raise click.ClickException(f"{type(error).__name__}: {error}; {hint}") from error

    def main(self, *args: Any, **kwargs: Any) -> Any:
        kwargs["standalone_mode"] = False
        try:
            code = super().main(*args, **kwargs)
        except click.Abort:
            code = 130  # 128 + SIGINT, as shells have it
        except click.exceptions.NoArgsIsHelpError as error:
            error.show()
            code = error.exit_code
        except click.ClickException as error:
            click.echo(f"warpvec: error: {' '.join(error.format_message().split())}", err=True)
            code = error.exit_code
        sys.exit(code or 0)


def _with_option_name(message: str) -> str:
    """A message about a setting with the name that the setting has on the command line."""
    name, space, rest = message.partition(" ")
    is_option = name in {"preset", "background"} | {field.name for field in fields(FitConfig)}
    return "--" + name.replace("_", "-") + space + rest if is_option else message


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="warpvec")
@click.option("--debug", is_flag=True, envvar="WARPVEC_DEBUG", help="Show the traceback of an unexpected failure.")
def main(debug: bool) -> None:
    """A photo becomes an editable SVG, measured on the file that is written."""
    del debug


_json_option = click.option("--json", "as_json", is_flag=True, help="Report as one JSON object (infinity as null).")
_background_option = click.option("--background", default="#ffffff", show_default=True, help="Behind transparency.")


@main.command(cls=SettingsCommand)
@click.argument("source", metavar="IN")
@click.argument("out", metavar="OUT")
@click.option("--preset", default="default", show_default=True, help=f"{', '.join(PRESETS)}.")
@_background_option
@click.option("--save-frames", metavar="DIR", help="Folder for a PNG of the scene now and then.")
@click.option("--every", type=click.IntRange(min=1), default=50, show_default=True, help="Iterations between frames.")
@_json_option
@click.option("-q", "--quiet", is_flag=True, help="No progress and no summary.")
@click.pass_context
def run(
    ctx: click.Context,
    /,
    source: str,
    out: str,
    preset: str,
    background: str,
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
    _check_out(out)
    from warpvec.image import read_image

    photo = read_image(_read_source(source), background, name="IN")
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
        _report(result.metrics, out, as_json)
    if result.interrupted:
        ctx.exit(130)


@main.command("eval")
@click.argument("source", metavar="IN")
@click.argument("svg", metavar="OUT")
@_background_option
@_json_option
def evaluate_file(source: str, svg: str, background: str, as_json: bool) -> None:
    """Measure how well the SVG file OUT, drawn by resvg, matches the photo IN."""
    from warpvec.api import evaluate
    from warpvec.image import read_image

    photo = read_image(_read_source(source), background, name="IN")
    _report(evaluate(_read_svg(svg), photo), svg, as_json)


@main.command()
@click.option("--compile", "compiles", is_flag=True, help="Compile the kernels now, so that no run has to.")
@_json_option
def info(compiles: bool, as_json: bool) -> None:
    """Show versions, devices and the kernel cache."""
    spent = {"compile_seconds": _compile_kernels()} if compiles else {}
    facts = {**_describe_environment(), **spent}
    lines = (f"{name.replace('_', ' ')}: {value}" for name, value in facts.items())
    click.echo(json.dumps(facts) if as_json else "\n".join(lines))


@main.command()
@click.argument("name", default="coffee.png")
@click.argument("out", required=False)
def sample(name: str, out: str | None) -> None:
    """Write the real photo NAME to OUT, without a download. OUT is NAME in this folder unless given."""
    from warpvec.samples import write_sample

    target = name if out is None else out
    check_writable(target, "OUT")
    write_sample(name, target)
    click.echo(target)


def _check_out(out: str) -> None:
    if out == "-":
        return
    check_writable(out, "OUT")
    special = Path(out).exists() and not Path(out).is_file()  # /dev/null and the like
    if not special and Path(out).suffix.lower() not in (".svg", ".svgz"):
        raise InputError(f"OUT must end in .svg or .svgz, or be - for stdout, got {out!r}; rename it")


def _read_source(source: str) -> str | bytes:
    return sys.stdin.buffer.read() if source == "-" else source


def _read_svg(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"OUT must be an SVG file, got {path!r} ({reason}); check the path") from error


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


def _report(metrics: dict[str, Any], out: str, as_json: bool) -> None:
    finite = {name: None if value in (math.inf, -math.inf) else value for name, value in metrics.items()}
    text = json.dumps(finite, allow_nan=False) if as_json else _summary(metrics, out)
    click.echo(text, err=out == "-")


def _summary(metrics: dict[str, Any], out: str) -> str:
    """What a person wants to know of the file, and of the fit where there was one."""
    lines = [
        "{out}: {curves} curves, {segments} segments, {bytes:,} bytes, {gzip_bytes:,} gzipped",
        "PSNR {psnr:.2f} dB, SSIM {ssim:.4f}, as resvg draws the file",
    ]
    if "internal_psnr" in metrics:
        lines[1] += "; {internal_psnr:.2f} dB " + _INTERNAL_IMAGES[metrics["renderer"]]
        if metrics["degree"] != 3:
            lines.append("sides of degree {degree} written as cubics within {conversion_px:.3f} px")
        lines.append("{iterations} iterations in {seconds:.1f} s on {device}")
    return "\n".join(lines).format(out="SVG" if out == "-" else out, **metrics)


def _compile_kernels() -> float:
    from warpvec.precompile import compile_kernels

    return round(compile_kernels(), 1)


def _describe_environment() -> dict[str, Any]:
    import numpy as np
    import resvg_py
    import torch
    import warp as wp

    from warpvec.launch import start_warp

    start_warp()
    cache = Path(wp.config.kernel_cache_dir or "")
    return {
        "warpvec": __version__,
        "warp": wp.config.version,
        "torch": torch.__version__,
        "numpy": np.__version__,
        "resvg": resvg_py.__resvg_version__,
        "python": platform.python_version(),
        "cpu_count": os.cpu_count(),
        "devices": ["cpu", *(f"cuda:{k} {torch.cuda.get_device_name(k)}" for k in range(torch.cuda.device_count()))],
        "kernel_cache": str(cache),
        "kernel_cache_bytes": sum(file.stat().st_size for file in cache.rglob("*") if file.is_file()),
    }
