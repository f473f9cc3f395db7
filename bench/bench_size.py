"""Measure `warpvec run` as photos and path counts grow: time of a step, (path, tile) pairs, peak memory.

Each case is the command in a process of its own, on one photo resampled to the size of the case. The time of a step
is the median lap of the second half of the run, which has all paths, so a short run suffices for it and for the peak.

A pair is a path in a tile of 16 x 16 pixels, the unit of work of every stage. If the time for each pair stays the
same, a step scales as its work does. A pair is partial if an edge of the path crosses the tile: its coverage must be
computed, whereas the other pairs have one colour. Smaller paths have more partial pairs.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import click
import numpy as np
from bench_fit import cli_options, run_child
from harness import (
    comma_separated,
    comma_separated_counts,
    default_cache,
    machine_facts,
    machine_line,
    markdown_table,
    parse_settings,
    settings_option,
)

HEADER = (
    "photo", "fitted", "curves", "PSNR", "wall s", "/ first", "fit s", "step ms", "change ms", "pairs", "partial",
    "ns a pair", "ns a partial", "peak MB", "whole run, s"
)  # fmt: skip

_WATCHED = Path(__file__).with_name("watched_run.py")


@dataclass(frozen=True)
class SizedRun:
    """One run.

    Attributes:
        size: width and height of the photo in pixels.
        metrics: the report of `warpvec run --json`.
        seen: the report of `watched_run.py`.
        wall: seconds of the process.
        whole: estimated seconds of the run with all iterations of its preset.
    """

    size: tuple[int, int]
    metrics: dict[str, Any]
    seen: dict[str, Any]
    wall: float
    whole: float

    @property
    def terms(self) -> tuple[float, float, float, float]:
        """Variables of the memory formula: 1, megapixels of the photo, megapixels of the fit, thousands of curves."""
        fitted = self.seen["fitted"]
        return 1.0, np.prod(self.size) / 1e6, np.prod(fitted) / 1e6, self.metrics["curves"] / 1e3

    def cells(self, first: SizedRun) -> list[str]:
        """Return the cells of the row, in the order of ``HEADER``."""
        seen, metrics = self.seen, self.metrics
        sizes = ["x".join(map(str, size)) for size in (self.size, seen["fitted"])]
        times = [f"{self.wall:.1f}", f"{self.wall / first.wall:.2f}", f"{seen['fit_seconds']:.1f}"]
        times += [f"{1e3 * seen[name]:.1f}" for name in ("step", "change")]
        counts = [seen[name] for name in ("pairs", "partial_pairs")]
        pairs = [*map(str, counts), *(f"{1e9 * seen['step'] / max(count, 1):.0f}" for count in counts)]
        last = [f"{seen['peak_bytes'] / 1e6:.0f}", f"{self.whole:.0f}"]
        return [*sizes, str(metrics["curves"]), f"{metrics['psnr']:.2f}", *times, *pairs, *last]

    def to_dict(self) -> dict[str, Any]:
        """Return the row for JSON."""
        return {"size": self.size, "metrics": self.metrics, "seen": self.seen, "wall": self.wall, "whole": self.whole}


def sized_run(photo: Path, size: tuple[int, int], settings: dict[str, Any], preset: str) -> SizedRun:
    """Run `warpvec run` on ``photo``; ``size`` is its width and height in pixels."""
    with tempfile.TemporaryDirectory() as folder:
        command = [_WATCHED, photo, Path(folder, "out.svg"), "--json", "-q", "--preset", preset]
        run = run_child([*command, *cli_options(settings)])
    metrics, seen = map(json.loads, run.stdout.splitlines()[-2:])
    return SizedRun(size, metrics, seen, run.wall, _whole_run(run.wall, seen, settings, preset))


def _whole_run(wall: float, seen: dict[str, Any], settings: dict[str, Any], preset: str) -> float:
    """Estimate the seconds of the run with all iterations of the preset from the measured steps and changes."""
    from warpvec.config.presets import make_config
    from warpvec.fit.schedule import inflation_count

    config = make_config(preset, **{**settings, "iterations": make_config(preset).iterations})
    recycled = int(config.recycle_until * config.iterations / config.recycle_gap) if config.recycle_gap else 0
    changes = inflation_count(config) + recycled
    return wall - seen["fit_seconds"] + config.iterations * seen["step"] + changes * seen["change"]


def memory_formula(runs: list[SizedRun]) -> str:
    """Fit the peak as a linear function of pixels and curves by least squares; return "" if ``runs`` are too alike."""
    terms = np.array([run.terms for run in runs])
    varied = [column for column in range(4) if column == 0 or len(np.unique(terms[:, column])) > 1]
    if np.linalg.matrix_rank(terms[:, varied]) < max(2, len(varied)):
        return ""
    peaks = np.array([run.seen["peak_bytes"] / 1e6 for run in runs])
    found = np.linalg.lstsq(terms[:, varied], peaks)[0]
    names = ("MB", "MB a megapixel of the photo", "MB a megapixel fitted", "MB a thousand curves")
    text = " + ".join(f"{value:.0f} {names[column]}" for column, value in zip(varied, found, strict=True))
    worst = np.abs(terms[:, varied] @ found / peaks - 1.0).max()
    return f"peak memory = {text}; within {worst:.0%} of each row"


def _sizes(ctx: click.Context, param: click.Parameter, value: str) -> list[tuple[int, int]]:
    """Parse an option such as 768x512,2040x1344."""
    sizes = [item.partition("x")[::2] for item in comma_separated(ctx, param, value)]
    if not all(side.isdecimal() and int(side) > 0 for size in sizes for side in size):
        raise click.BadParameter(f"must be sizes, as in 768x512,2040x1344, got {value!r}")
    return [(int(width), int(height)) for width, height in sizes]


def _fit_sizes(ctx: click.Context, param: click.Parameter, value: str) -> list[int | None]:
    """Parse an option such as 1024,photo; None stands for the photo's own size."""
    words = comma_separated(ctx, param, value)
    return [None if word == "photo" else comma_separated_counts(ctx, param, word)[0] for word in words]


@click.command()
@click.option("--photo", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Photo [coffee.png].")
@click.option("--sizes", callback=_sizes, default="768x512", show_default=True, help="Sizes to resample it to.")
@click.option("--curves", callback=comma_separated_counts, default="1024", show_default=True)
@click.option("--fit-size", "fit_sizes", callback=_fit_sizes, default="photo", show_default=True, help="As in run.")
@click.option("--preset", default="default", show_default=True)
@click.option("--iterations", default=60, show_default=True, help="Iterations of each run; 0 for the preset's own.")
@click.option("--cache", type=click.Path(path_type=Path), default=default_cache, help="Folder of the resampled photos.")
@settings_option
def main(
    photo: Path | None,
    sizes: list[tuple[int, int]],
    curves: list[int],
    fit_sizes: list[int | None],
    preset: str,
    iterations: int,
    cache: Path,
    assignments: tuple[str, ...],
) -> None:
    """Measure `warpvec run` by photo size and number of paths."""
    from bench_scenes import resampled_photo, sample_photo

    given, facts = parse_settings(assignments), machine_facts()
    given |= {"iterations": iterations} if iterations else {}
    source = photo or sample_photo(cache)
    runs = []
    for size, count, fit_size in product(sizes, curves, fit_sizes):
        settings = {**given, "curves": count, "fit_size": fit_size or max(size)}
        runs.append(sized_run(resampled_photo(source, *size, cache), size, settings, preset))
        click.echo(f"{len(runs)} of {len(sizes) * len(curves) * len(fit_sizes)} runs", err=True)
    click.echo(markdown_table(HEADER, [run.cells(runs[0]) for run in runs]) + "\n")
    if formula := memory_formula(runs):
        click.echo(formula)
    click.echo(machine_line({**facts, "photo": source.name, "preset": preset, "iterations": iterations or None}))
    rows = [run.to_dict() for run in runs]
    click.echo(json.dumps({"bench": "size", **facts, "preset": preset, "settings": given, "runs": rows}))


if __name__ == "__main__":
    main()
