"""Measure how `warpvec run` ends on patterns that have as many outlines as a picture can have.

Each pattern is run with a budget, with a budget and cut out, and without a budget, on one thread. The clock of a run is
its own CPU time, so that other work on the machine changes nothing. Stated are the CPU seconds of the whole process,
those that it takes beyond its budget and the run of a blank picture, and its mode.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Sequence
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import click
import numpy as np
from bench_fit import run_child
from harness import machine_facts, machine_line, markdown_table
from numpy.typing import NDArray
from PIL import Image

Levels = NDArray[np.uint8]

BUDGET = 5
"""Seconds that a run may take with a budget; its start and its files come on top."""

_BY_CPU = """
import sys, time
time.perf_counter = time.process_time
sys.argv = ["warpvec", *sys.argv[1:]]
from warpvec.__main__ import main
main()
"""


def _checkers(width: int) -> Callable[[int], Levels]:
    def draw(side: int) -> Levels:
        row = np.arange(side) // width % 2
        return (255 * (row[:, None] ^ row)).astype(np.uint8)

    return draw


def noise(side: int) -> Levels:
    """Return noise of two levels [side, side]."""
    return (255 * np.random.default_rng(1).integers(0, 2, (side, side))).astype(np.uint8)


def _polar(side: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    y, x = np.indices((side, side)) - (side - 1) / 2
    return np.hypot(x, y), np.arctan2(y, x)


def rays(side: int) -> Levels:
    """Return 180 rays [side, side] that meet in the centre."""
    return np.where(np.sin(180 * _polar(side)[1]) > 0.0, 255, 0).astype(np.uint8)


def spiral(side: int) -> Levels:
    """Return a spiral [side, side] whose turns are 4 px apart."""
    radius, angle = _polar(side)
    return np.where(np.sin(2.0 * np.pi * radius / 4.0 + angle) > 0.0, 255, 0).astype(np.uint8)


def hilbert(side: int) -> Levels:
    """Return a Hilbert curve [side, side], 2 px wide and 4 px apart."""
    steps = [(0, 0)]
    order = (side // 4).bit_length() - 1
    for level in range(order):
        size = 2**level
        turned, flipped = [(y, x) for x, y in steps], [(size - 1 - y, size - 1 - x) for x, y in steps]
        steps = [
            *turned,
            *((x, y + size) for x, y in steps),
            *((x + size, y + size) for x, y in steps),
            *((x + size, y) for x, y in flipped),
        ]
    levels = np.full((side, side), 255, np.uint8)
    for (x0, y0), (x1, y1) in pairwise(steps):
        left, top = 4 * min(x0, x1) + 1, 4 * min(y0, y1) + 1
        levels[top : 4 * max(y0, y1) + 3, left : 4 * max(x0, x1) + 3] = 0
    return levels


PATTERNS = {
    "checkers of 1 px": _checkers(1),
    "checkers of 4 px": _checkers(4),
    "noise": noise,
    "rays": rays,
    "spiral": spiral,
    "hilbert": hilbert,
}

RUNS = {
    "budget": ("--time-budget", BUDGET),
    "budget, cut out": ("--time-budget", BUDGET, "--cutout"),
    "budget, flat": ("--time-budget", BUDGET, "--mode", "flat"),
    "free": (),
    "free, flat": ("--mode", "flat"),
}
"""Options of each run by its name."""


def seconds_of(levels: Levels, options: Sequence[object]) -> tuple[float, dict[str, Any]]:
    """Return the CPU seconds of a run of ``levels`` [h, w], and the facts that it prints.

    Raises:
        click.ClickException: the picture is refused.
    """
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder, "in.png")
        Image.fromarray(levels).save(picture)
        command = ["-c", _BY_CPU, "run", picture, Path(folder, "out.svg"), "--threads", 1, "--json", "-q", *options]
        run = run_child(command)
    return run.cpu, json.loads(run.stdout)


@click.command()
@click.option("--side", "sides", type=int, multiple=True, default=(512, 1024), help="Side of the pictures in pixels.")
@click.option("--pattern", "patterns", type=click.Choice(list(PATTERNS)), multiple=True, default=tuple(PATTERNS))
@click.option("--run", "runs", type=click.Choice(list(RUNS)), multiple=True, default=tuple(RUNS))
def main(sides: tuple[int, ...], patterns: tuple[str, ...], runs: tuple[str, ...]) -> None:
    """Run every pattern in every way."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    facts = machine_facts()
    start = seconds_of(np.full((16, 16), 255, np.uint8), ())[0]
    rows = []
    for side, pattern, name in product(sides, patterns, runs):
        options = RUNS[name]
        try:
            cpu, found = seconds_of(PATTERNS[pattern](side), options)
        except click.ClickException as error:
            rows.append([f"{pattern}, {side} px", name, "", "", error.message])
        else:
            over = f"{cpu - start - BUDGET:.1f}" if "--time-budget" in options else ""
            rows.append(
                [f"{pattern}, {side} px", name, f"{cpu:.1f}", over, f"{found['mode']}, {found['curves']} paths"]
            )
        click.echo(" | ".join(rows[-1]), err=True)
    click.echo(markdown_table(["pattern", "run", "CPU s", "over", "mode"], rows) + "\n")
    click.echo(f"the run of a blank picture takes {start:.1f} s; {machine_line(facts)}")


if __name__ == "__main__":
    main()
