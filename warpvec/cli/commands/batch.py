"""``warpvec batch``: turn a folder of images into a folder of SVGs or VectorDrawables."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

from warpvec.checks import in_one_line
from warpvec.cli.arguments import json_option, quiet_option, start_options
from warpvec.cli.options import OPTION_NAMES, file_options, requested
from warpvec.cli.settings_command import SettingsCommand
from warpvec.cli.side_files import write_config
from warpvec.cli.signals import raised_interrupts
from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.purposes.table import PURPOSES

if TYPE_CHECKING:
    from warpvec.batch.console import Tally
    from warpvec.batch.engines.base import Engine
    from warpvec.batch.jobs import PhotoJob, Vectorize


@click.command(cls=SettingsCommand, short_help="Turn a folder of images into a folder of SVGs.")
@click.argument("source", metavar="IN_DIR")
@click.argument("target", metavar="OUT_DIR")
@start_options
@click.option("--recursive", is_flag=True, help="Include the images in folders of IN_DIR.")
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Images at a time. [one per GPU, else per core]")
@click.option("--skip-existing", is_flag=True, help="Skip every image that has a file of any settings.")
@click.option(
    "--retry", "retries", type=click.IntRange(min=0), default=2, metavar="N",
    help="Further attempts at an image that fails or whose worker dies. [2]",
)  # fmt: skip
@click.option("--svgz", is_flag=True, help="Write gzipped SVGs.")
@click.option("--keep-suffix", is_flag=True, help="Name files photo.jpg.svg, not photo.svg.")
@click.option(
    "--engine", type=click.Choice(["local", "ray"]), default="local", help="Workers on this machine or on Ray. [local]"
)
@click.option("--ray-address", metavar="ADDR", help="Address of the Ray cluster. [found by Ray]")
@json_option
@quiet_option
@click.pass_context
def batch(ctx: click.Context, /, source: str, target: str, **options: Any) -> None:
    """Turn every image in the folder IN_DIR into an SVG in the folder OUT_DIR.

    With --for android the files are VectorDrawables, NAME.xml. OUT_DIR/batch.csv and OUT_DIR/batch.jsonl get a line per
    image with the figures of its file, or the error. Images that fail do not stop the others; the exit code is then 1.
    A batch that was stopped continues when it is started again: images with a file of the same image and settings are
    skipped.

    With --engine ray the folders must be visible to all machines, or be addresses such as s3://bucket/photos that
    fsspec can open. Names that begin with a dot are ignored.
    """
    config, goal = requested({**options, "gzip": options["gzip"] or options["svgz"]})
    if options["ray_address"] is not None and options["engine"] != "ray":
        raise InputError("--ray-address", "must come with --engine ray", remedy="add it, or leave the address out")
    from warpvec.batch.folders import open_folder
    from warpvec.batch.jobs import Vectorize, find_jobs
    from warpvec.image.colors import parse_color

    background = options["background"]
    if background is not None:
        parse_color(background)
    folders = open_folder(source, "IN_DIR"), open_folder(target, "OUT_DIR")
    work = Vectorize(*folders, config, background, goal, file_options(options), OPTION_NAMES)
    suffix = _suffix(work.file_options.purpose, is_gzipped=options["svgz"])
    jobs = find_jobs(work.source.names(options["recursive"]), suffix, keep_suffix=options["keep_suffix"])
    engine = _engine(config, options)
    write_config(options, config)
    tally, interrupted = _run(jobs, work, engine, skip_existing=options["skip_existing"], quiet=options["quiet"])
    if options["as_json"] or not options["quiet"]:
        click.echo(json.dumps(tally.facts()) if options["as_json"] else f"{in_one_line(target)}: {tally.summary()}")
    ctx.exit(130 if interrupted else min(len(tally.failed), 1))


def _suffix(purpose: str, *, is_gzipped: bool) -> str:
    """Return the suffix of the files.

    Raises:
        InputError: they are no SVGs, and ``is_gzipped``.
    """
    suffix = PURPOSES[purpose].suffix
    if not is_gzipped:
        return suffix
    if suffix != ".svg":
        raise InputError("--svgz", "must be for SVGs", f"--for {purpose}, which writes {suffix}", "leave one out")
    return ".svgz"


def _engine(config: FitConfig, options: dict[str, Any]) -> Engine:
    count, retries = options["jobs"], options["retries"]
    if options["engine"] == "ray":
        from warpvec.batch.engines.ray import RayEngine

        return RayEngine(config.device, config.threads or 1, count, retries, options["ray_address"])
    from warpvec.cli.loading import load_drawing, quick_loading

    with quick_loading():
        from warpvec.batch.engines.local import LocalEngine
        from warpvec.rendering.devices import gpu_count
        from warpvec.rendering.launch import resolve_device

    device = resolve_device(config.device)
    every_gpu = config.device == "auto" and device != "cpu"
    devices = [f"cuda:{k}" for k in range(gpu_count())] if every_gpu else [device]
    return LocalEngine(devices, config.threads, count, retries, load_drawing)


def _run(
    jobs: Sequence[PhotoJob], work: Vectorize, engine: Engine, *, skip_existing: bool, quiet: bool
) -> tuple[Tally, bool]:
    """Run the batch; return its results and whether a signal ended it. The records are kept either way."""
    from warpvec.batch.console import Tally, show_batch
    from warpvec.batch.jobs import longest_first, remaining, run_batch
    from warpvec.batch.journal import Journal

    with raised_interrupts(), work.target.lock(), closing(Journal(work.target)) as journal:
        left = longest_first(remaining(jobs, work, journal, skip_existing=skip_existing), work.source)
        if left:
            work.target.check_room()
        efforts = {job.input: job.effort for job in left}
        tally = Tally(skipped=len(jobs) - len(left), total=len(left), efforts=efforts)
        try:
            with (
                show_batch(sys.stderr, tally, quiet=quiet) as view,
                closing(run_batch(left, work, engine, journal, view.update)) as records,
            ):
                for record in records:
                    tally.records.append(record)
                    view.show(record, tally)
        except KeyboardInterrupt:
            return tally, True
    return tally, False
