"""Measures what is asked for by its result: bytes, decibels, few colours, levels of detail. Each by `warpvec run`.

What: the figures of each file as resvg draws it, beside a plain fit of the same photo with as many paths, and the wall
time of the whole command. A level of detail is compared with a fit that was made for its number of paths.
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


class Outcome(NamedTuple):
    """What a command made: its figures (as `warpvec run --json` gives them), its fills, its wall time in seconds."""

    metrics: dict[str, Any]
    fills: int
    wall: float


class Runs:
    """Runs of `warpvec run` with some options in common; a command is run once."""

    def __init__(self, common: Sequence[str]) -> None:
        self._common = common
        self._done: dict[tuple[object, ...], Outcome] = {}

    def __call__(self, image: Path, *options: object) -> Outcome:
        if (image, *options) not in self._done:
            self._done[image, *options] = self._run(image, *options)
        return self._done[image, *options]

    def _run(self, image: Path, *options: object) -> Outcome:
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder, "out.svg")
            run = run_child(["-m", "warpvec", "run", image, out, *options, *self._common, "--json", "-q"])
            fills = len(set(_FILL.findall(out.read_text(encoding="utf-8"))))
        return Outcome(json.loads(run.stdout.splitlines()[-1]), fills, run.wall)


def goal_rows(runs: Runs, image: Path, sizes: Sequence[str], decibels: Sequence[str]) -> list[list[str]]:
    """A row for each budget of bytes and each quality asked of ``image``."""
    asked = [("--max-bytes", size) for size in sizes] + [("--target-psnr", value) for value in decibels]
    rows = []
    for option, value in asked:
        outcome = runs(image, option, value)
        tried = ", ".join(str(trial["curves"]) for trial in outcome.metrics["goal"]["trials"])
        rows.append([f"{option} {value}", *_figures(outcome), tried])
    return rows


def palette_rows(runs: Runs, image: Path, colors: int, curves: int) -> list[list[str]]:
    """Fits of ``image`` with a palette, opaque, both, and neither."""
    palette = ["--colors", colors]
    kinds = [[], palette, ["--opaque"], [*palette, "--opaque"]]
    rows = []
    for options in kinds:
        outcome = runs(image, "--curves", curves, *options)
        name = " ".join(map(str, options)) or "neither"
        rows.append([name, *_figures(outcome), str(outcome.fills)])
    return rows


def level_rows(runs: Runs, image: Path, curves: int) -> list[list[str]]:
    """The prefixes of a fit with levels of detail, each beside a fit made for its number of paths."""
    rows = []
    for level in runs(image, "--curves", curves, "--lod").metrics["levels"]:
        own = runs(image, "--curves", level["curves"]).metrics["psnr"]
        cells = (f"{level['psnr']:.2f}", f"{own:.2f}", f"{level['psnr'] - own:+.2f}")
        rows.append([str(level["curves"]), *cells])
    return rows


def _figures(outcome: Outcome) -> list[str]:
    metrics = outcome.metrics
    return [f"{metrics['psnr']:.2f}", f"{metrics['bytes']:,}", str(metrics["curves"]), f"{outcome.wall:.1f}"]


@click.command()
@click.argument("image", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--colorful", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Photo for the palette.")
@click.option("--max-bytes", "sizes", default="50k", callback=comma_separated, help="Budgets of bytes.")
@click.option("--target-psnr", "decibels", default="28", callback=comma_separated, help="Qualities in dB.")
@click.option("--colors", default=16, show_default=True, help="Entries of the palette.")
@click.option("--curves", default=512, show_default=True, help="Paths of the fits with a palette.")
@click.option("--lod-curves", default=1024, show_default=True, help="Paths of the fit with levels of detail.")
@click.option("--option", "common", multiple=True, help="An option of every `warpvec run`, as --iterations=40.")
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
    """Ask for results of IMAGE, and print what came of it."""
    runs = Runs(common)
    runs(image, "--curves", 16)  # compiles what is not cached
    head = ["PSNR, dB", "bytes", "curves", "wall s"]
    click.echo(markdown_table(["asked for", *head, "fits of"], goal_rows(runs, image, sizes, decibels)))
    click.echo("\n" + markdown_table(["fills", *head, "fills"], palette_rows(runs, colorful or image, colors, curves)))
    levels = ["level's curves", "PSNR, dB", "own fit, dB", "difference"]
    click.echo("\n" + markdown_table(levels, level_rows(runs, image, lod_curves)))
    click.echo("\n" + machine_line(machine_facts()))


if __name__ == "__main__":
    main()
