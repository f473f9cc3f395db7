"""Measure fits with a goal: a file size, a PSNR, a number of colours, or levels of detail.

Each row is one `warpvec run`: the metrics of its file as resvg draws it, and the wall time of the whole command. Fits
with a palette are compared with a plain fit of as many paths, each level of detail with a fit made for its number of
paths.
"""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
from bench_fit import run_child
from harness import comma_separated, machine_facts, machine_line, markdown_table

_FILL = re.compile(r'fill="(#[0-9a-f]+)"')


class Measured(NamedTuple):
    """One command: the metrics of `warpvec run --json`, the number of distinct fills, and wall seconds."""

    metrics: dict[str, Any]
    fills: int
    wall: float


class Runs:
    """Runs of `warpvec run` with shared options; equal commands are run only once."""

    def __init__(self, common: Sequence[str]) -> None:
        self._common = common
        self._done: dict[tuple[object, ...], Measured] = {}

    def __call__(self, image: Path, *options: object) -> Measured:
        """Return the figures of ``image`` under ``options``, which are measured once."""
        if (image, *options) not in self._done:
            self._done[image, *options] = self._run(image, *options)
        return self._done[image, *options]

    def _run(self, image: Path, *options: object) -> Measured:
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder, "out.svg")
            run = run_child(["-m", "warpvec", "run", image, out, *options, *self._common, "--json", "-q"])
            fills = len(set(_FILL.findall(out.read_text(encoding="utf-8"))))
        return Measured(json.loads(run.stdout.splitlines()[-1]), fills, run.wall)


def goal_rows(runs: Runs, image: Path, sizes: Sequence[str], decibels: Sequence[str]) -> list[list[str]]:
    """Fit ``image`` to each file size, in the short and in the long form, and each PSNR; return a row for each."""
    asked: list[tuple[str, ...]] = []
    for size in sizes:
        asked += [("--max-bytes", size), ("--max-bytes", size, "--no-minify")]
    asked += [("--target-psnr", value) for value in decibels]
    rows = []
    for options in asked:
        measured = runs(image, *options)
        tried = ", ".join(str(trial["curves"]) for trial in measured.metrics["goal"]["trials"])
        rows.append([" ".join(options), *_figures(measured), str(measured.metrics["iterations"]), tried])
    return rows


def palette_rows(runs: Runs, image: Path, colors: int, curves: int) -> list[list[str]]:
    """Fit ``image`` with neither, one or both of a palette and --opaque; return a row for each."""
    palette = ["--colors", colors]
    kinds = [[], [*palette, "--opacity", "free"], ["--opaque"], [*palette, "--opaque"]]
    rows = []
    for options in kinds:
        measured = runs(image, "--curves", curves, *options)
        name = " ".join(map(str, options)) or "neither"
        rows.append([name, *_figures(measured), str(measured.fills)])
    return rows


def level_rows(runs: Runs, image: Path, curves: int) -> list[list[str]]:
    """Compare each prefix of a fit with levels of detail with a fit of as many paths; return a row for each."""
    rows = []
    for level in runs(image, "--curves", curves, "--lod").metrics["levels"]:
        own = runs(image, "--curves", level["curves"]).metrics["psnr"]
        cells = (f"{level['psnr']:.2f}", f"{own:.2f}", f"{level['psnr'] - own:+.2f}")
        rows.append([str(level["curves"]), *cells])
    return rows


def _figures(measured: Measured) -> list[str]:
    metrics = measured.metrics
    return [f"{metrics['psnr']:.2f}", f"{metrics['bytes']:,}", str(metrics["curves"]), f"{measured.wall:.1f}"]


@click.command()
@click.argument("image", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--colorful", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Photo for the palettes [IMAGE]."
)
@click.option("--max-bytes", "sizes", default="50k", callback=comma_separated, help="File sizes to fit, as in 50k,80k.")
@click.option("--target-psnr", "decibels", default="28", callback=comma_separated, help="PSNRs to reach, in dB.")
@click.option("--colors", default=16, show_default=True, help="Number of palette entries.")
@click.option("--curves", default=512, show_default=True, help="Number of paths of the fits with a palette.")
@click.option("--lod-curves", default=1024, show_default=True, help="Number of paths of the fit with levels of detail.")
@click.option("--option", "common", multiple=True, help="Option for every `warpvec run`, as in --iterations=40.")
def main(
    image: Path,
    colorful: Path | None,
    sizes: list[str],
    decibels: list[str],
    colors: int,
    curves: int,
    lod_curves: int,
    common: tuple[str, ...],
) -> None:
    """Fit IMAGE with goals, palettes and levels of detail, and print the results."""
    runs = Runs(common)
    runs(image, "--curves", 16)  # compiles the kernels that are not cached
    head = ["PSNR, dB", "bytes", "curves", "wall s"]
    click.echo(
        markdown_table(["goal", *head, "iterations", "curves of its fits"], goal_rows(runs, image, sizes, decibels))
    )
    click.echo("\n" + markdown_table(["fills", *head, "fills"], palette_rows(runs, colorful or image, colors, curves)))
    levels = ["curves of the level", "PSNR, dB", "fit of as many, dB", "difference"]
    click.echo("\n" + markdown_table(levels, level_rows(runs, image, lod_curves)))
    click.echo("\n" + machine_line(machine_facts()))


if __name__ == "__main__":
    main()
