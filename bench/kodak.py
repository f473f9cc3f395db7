"""Fit every image of a folder and measure the files as resvg draws them.

It reports PSNR, SSIM and size of the files, and the seconds of the fits, in a process that compiles and loads all
kernels before its first fit. Papers on vectorization report means over the Kodak set.

Every result is written to a CSV file at once (`fits.py`), so a run that was interrupted continues where it ended.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from statistics import fmean
from typing import Any

import click
from fits import ResultFile, Row, engine_for, find_images, fit_key, jobs_option, results_of, warm_up
from harness import (
    comma_separated_counts,
    default_cache,
    machine_facts,
    machine_line,
    markdown_table,
    parse_settings,
    settings_option,
    source_digest,
)

from warpvec import vectorize
from warpvec.batch.engines.base import Engine, Report, WorkerShare
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.rendering.launch import resolve_device

METRICS = ("psnr", "ssim", "internal_psnr", "bytes", "gzip_bytes", "mean_opacity", "iterations", "seconds", "device")
FIELDS = ("key", "image", "preset", "curves", "settings", *METRICS, "gap", "total_seconds", "source")
"""Columns of the CSV. ``seconds`` is the time of the fit, ``total_seconds`` includes reading and writing the files."""

_HEADER = ("PSNR", "SSIM", "internal", "gap", "bytes", "opacity", "fit s", "total s")
_FORMATS = {
    "psnr": ".3f", "ssim": ".4f", "internal_psnr": ".3f", "gap": ".3f",
    "bytes": ",.0f", "mean_opacity": ".3f", "seconds": ".1f", "total_seconds": ".1f",
}  # fmt: skip


# The fits


def row_key(image: Path, config: FitConfig) -> str:
    """Return the key of an image's row."""
    return fit_key(image.read_bytes(), config)


def measure_image(image: Path, preset: str, config: FitConfig, given: dict[str, Any]) -> dict[str, Any]:
    """Fit one image and return its row.

    Raises:
        click.Abort: Ctrl-C ended the fit, so its result is not that of the settings.
    """
    start = time.perf_counter()
    result = vectorize(image, preset=preset, **{**given, "curves": config.curves})
    result.svg()
    total_seconds = time.perf_counter() - start
    if result.interrupted:
        raise click.Abort
    metrics = result.metrics
    gap = metrics["internal_psnr"] - metrics["psnr"]
    known = {"key": row_key(image, config), "image": image.name, "preset": preset, "curves": config.curves}
    measured = {name: metrics[name] for name in METRICS}
    run = {"settings": json.dumps(given), "total_seconds": total_seconds, "source": source_digest()}
    return {**known, **measured, "gap": gap, **run}


Case = tuple[Path, FitConfig]


@dataclass(frozen=True)
class Measure:
    """The work of an engine: fit and measure a case."""

    preset: str
    given: dict[str, Any]

    def __call__(self, case: Case, share: WorkerShare, report: Report) -> dict[str, Any]:
        """Return the row of a case, after a warm-up that is not measured."""
        del share, report
        image, config = case
        warm_up(self.preset, self.given)
        return measure_image(image, self.preset, config, self.given)


def collect(cases: Iterable[Case], out: Path, measure: Measure, engine: Engine) -> list[Row]:
    """Return the row of every case: from the file ``out`` if it has one, else measured and added to it."""
    results = ResultFile(out, FIELDS)
    done, keyed = results.read(), {row_key(*case): case for case in cases}
    for row in results_of(engine, [case for key, case in keyed.items() if key not in done], measure):
        results.append(row)
        done[row["key"]] = {name: str(value) for name, value in row.items()}
        click.echo(f"{row['image']} {row['curves']}: {row['psnr']:.2f} dB, {row['total_seconds']:.1f} s", err=True)
    return [done[key] for key in keyed]


# The tables


def means_table(rows: Sequence[Row], curves: Sequence[int]) -> str:
    """Return the means over the images for each number of curves; PSNRs are averaged in decibels, as in papers."""
    lines = []
    for count in curves:
        chosen = [row for row in rows if int(row["curves"]) == count]
        means = [format(fmean(float(row[name]) for row in chosen), form) for name, form in _FORMATS.items()]
        lines.append([count, len(chosen), *means])
    return markdown_table(("curves", "images", *_HEADER), lines)


def details_table(rows: Sequence[Row]) -> str:
    """Return a table with a row for every image and number of curves."""
    values = ([format(float(row[name]), form) for name, form in _FORMATS.items()] for row in rows)
    lines = [[row["image"], row["curves"], *cells] for row, cells in zip(rows, values, strict=True)]
    return markdown_table(("image", "curves", *_HEADER), lines)


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--curves", callback=comma_separated_counts, default="256,512,1024", show_default=True)
@click.option("--preset", default="default", show_default=True)
@click.option("--threads", type=int, help="CPU threads of the kernels [all cores].")
@jobs_option
@click.option("--limit", type=click.IntRange(min=1), help="Use only the first N images.")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="CSV file [kodak.csv in a temp folder].")
@click.option("--details", is_flag=True, help="Also print a table of every image.")
@settings_option
def main(
    folder: Path,
    curves: list[int],
    preset: str,
    threads: int | None,
    jobs: int,
    limit: int | None,
    out: Path | None,
    details: bool,
    assignments: tuple[str, ...],
) -> None:
    """Fit every image of FOLDER and measure the files as resvg draws them."""
    settings = {**parse_settings(assignments), **({} if threads is None else {"threads": threads})}
    engine, given = engine_for(jobs, settings)
    out = out or default_cache() / "kodak.csv"
    try:
        configs = [make_config(preset, **{**given, "curves": count}) for count in curves]
        facts = machine_facts(resolve_device(configs[0].device))
        cases = [(image, config) for config, image in product(configs, find_images(folder, limit))]
        rows = collect(cases, out, Measure(preset, given), engine)
    except InputError as error:
        raise click.UsageError(str(error)) from error
    if details:
        click.echo(details_table(rows) + "\n")
    click.echo(means_table(rows, curves) + "\n")
    click.echo(f"preset {preset}, settings {json.dumps(given)}; results in {out}")
    click.echo(machine_line(facts))


if __name__ == "__main__":
    main()
