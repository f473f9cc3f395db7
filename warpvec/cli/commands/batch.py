"""``warpvec batch``: a folder of photos becomes a folder of SVGs."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

from warpvec.cli.arguments import background_option, json_option, preset_option
from warpvec.cli.options import OPTION_NAMES, requested, stated
from warpvec.cli.settings_command import SettingsCommand
from warpvec.config.fit_config import FitConfig
from warpvec.config.toml_file import write_settings
from warpvec.errors import InputError

if TYPE_CHECKING:
    from warpvec.batch.console import Tally
    from warpvec.batch.engines.base import Engine
    from warpvec.batch.jobs import Job, Vectorize


@click.command(cls=SettingsCommand)
@click.argument("source", metavar="IN_DIR")
@click.argument("target", metavar="OUT_DIR")
@preset_option
@background_option
@click.option("--recursive", is_flag=True, help="The photos of all folders in IN_DIR too.")
@click.option("--jobs", type=click.IntRange(min=1), help="Photos at a time [one for each GPU, or else each core].")
@click.option("--skip-existing", is_flag=True, help="Leave every photo alone that has an SVG, whatever it was made of.")
@click.option(
    "--retry", "retries", type=click.IntRange(min=0), default=2, show_default=True,
    help="More attempts at a photo whose worker dies or fails.",
)  # fmt: skip
@click.option("--svgz", is_flag=True, help="Write gzipped SVGs.")
@click.option("--keep-suffix", is_flag=True, help="Name SVGs photo.jpg.svg, not photo.svg.")
@click.option(
    "--engine", type=click.Choice(["local", "ray"]), default="local", show_default=True, help="Where workers run."
)
@click.option("--ray-address", metavar="ADDR", help="Of the Ray cluster [the one that runs here, as Ray finds it].")
@json_option
@click.option("-q", "--quiet", is_flag=True, help="No progress and no summary.")
@click.pass_context
def batch(
    ctx: click.Context,
    /,
    source: str,
    target: str,
    preset: str,
    background: str | None,
    recursive: bool,
    jobs: int | None,
    skip_existing: bool,
    retries: int,
    svgz: bool,
    keep_suffix: bool,
    engine: str,
    ray_address: str | None,
    as_json: bool,
    quiet: bool,
    write_config: str | None,
    **settings: Any,
) -> None:
    """Turn every photo of the folder IN_DIR into an SVG in the folder OUT_DIR.

    OUT_DIR/batch.csv and OUT_DIR/batch.jsonl get a line for each photo: the figures of its file, and the error if the
    last batch made none; a file from before then stays, and its figures too. A photo that cannot be read, or whose
    worker dies again and again, is reported, the others go on, and the exit code is 1. A batch that was stopped, by
    Ctrl-C or by force, goes on where it was: what has its SVG, of the same photo with the same settings, is not done
    again.

    With --engine ray the workers are those of a Ray cluster. Folders may then be s3://bucket/photos or any address
    that fsspec opens; a path must be one that all machines see. Names that begin with a dot are left alone.

    The settings below show the defaults of the default preset.
    """
    config, goal = requested(preset, {**settings, "gzip": settings["gzip"] or svgz})
    if ray_address is not None and engine != "ray":
        raise InputError("--ray-address must come with --engine ray, got it without; add that")
    from warpvec.batch.folders import open_folder
    from warpvec.batch.jobs import Vectorize, find_jobs
    from warpvec.image.colors import parse_color

    if background is not None:
        parse_color(background)
    work = Vectorize(
        open_folder(source, "IN_DIR"), open_folder(target, "OUT_DIR"), config, background, goal, OPTION_NAMES
    )
    photos = find_jobs(work.source.names(recursive), ".svgz" if svgz else ".svg", keep_suffix=keep_suffix)
    chosen = _ray_engine(config, jobs, retries, ray_address) if engine == "ray" else _engine(config, jobs, retries)
    if write_config is not None:
        write_settings(write_config, stated(preset, background, settings, config))
    tally, interrupted = _run(photos, work, chosen, skip_existing=skip_existing, quiet=quiet)
    if as_json or not quiet:
        click.echo(json.dumps(tally.facts()) if as_json else f"{target}: {tally.summary()}")
    ctx.exit(130 if interrupted else min(len(tally.failed), 1))


def _engine(config: FitConfig, jobs: int | None, retries: int) -> Engine:
    import torch

    from warpvec.batch.engines.local import LocalEngine
    from warpvec.rendering.launch import resolve_device

    device = resolve_device(config.device)
    every_gpu = config.device == "auto" and device != "cpu"
    devices = [f"cuda:{k}" for k in range(torch.cuda.device_count())] if every_gpu else [device]
    return LocalEngine(devices, config.threads, jobs, retries)


def _ray_engine(config: FitConfig, jobs: int | None, retries: int, address: str | None) -> Engine:
    from warpvec.batch.engines.ray import RayEngine

    return RayEngine(config.device, config.threads or 1, jobs, retries, address)


def _run(
    photos: Sequence[Job], work: Vectorize, engine: Engine, *, skip_existing: bool, quiet: bool
) -> tuple[Tally, bool]:
    """What came of the batch, and whether Ctrl-C ended it; the records are kept either way."""
    from warpvec.batch.console import Tally, show_batch
    from warpvec.batch.jobs import remaining, run_batch
    from warpvec.batch.journal import Journal

    with work.target.claim(), closing(Journal(work.target)) as journal:
        jobs = remaining(photos, work, journal, skip_existing=skip_existing)
        tally = Tally(skipped=len(photos) - len(jobs), total=len(jobs))
        try:
            with (
                show_batch(sys.stderr, tally, quiet=quiet) as view,
                closing(run_batch(jobs, work, engine, journal, view.watch)) as records,
            ):
                for record in records:
                    tally.records.append(record)
                    view.show(record, tally)
        except KeyboardInterrupt:
            return tally, True
    return tally, False
