"""Measure how `warpvec run` ends on patterns that have as many outlines as a picture can have.

Each pattern is run with a budget, with a budget and cut out, and without a budget. Stated are the seconds beyond the
budget, of the wall clock and of the CPU, and the CPU seconds without one. A run has one thread.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import click
import numpy as np
from bench_fit import run_child
from harness import machine_facts, machine_line, markdown_table
from numpy.typing import NDArray
from PIL import Image

Levels = NDArray[np.uint8]

BUDGET = 5
"""Seconds that a run may take with a budget; its start and its files come on top."""


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
    "free": (),
    "free, flat": ("--mode", "flat"),
}
"""Options of each run by its name."""


def measure(pattern: str, side: int, options: tuple[object, ...]) -> dict[str, object]:
    """Run the ``pattern`` of ``side`` pixels; return its wall and CPU seconds and what the command said of the mode."""
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder, "in.png")
        Image.fromarray(PATTERNS[pattern](side)).save(picture)
        command = ["-m", "warpvec", "run", picture, Path(folder, "out.svg"), "--threads", 1, "--json", "-q", *options]
        try:
            run = run_child(command)
        except click.ClickException as error:
            return {"pattern": pattern, "side": side, "refused": error.message}
        facts = json.loads(run.stdout)
    return {
        "pattern": pattern, "side": side, "wall": round(run.wall, 1), "cpu": round(run.cpu, 1),
        "mode": facts["mode"], "paths": facts["curves"],
    }  # fmt: skip


@click.command()
@click.option("--side", "sides", type=int, multiple=True, default=(512, 1024), help="Side of the pictures in pixels.")
@click.option("--pattern", "patterns", type=click.Choice(list(PATTERNS)), multiple=True, default=tuple(PATTERNS))
@click.option("--run", "runs", type=click.Choice(list(RUNS)), multiple=True, default=tuple(RUNS))
def main(sides: tuple[int, ...], patterns: tuple[str, ...], runs: tuple[str, ...]) -> None:
    """Run every pattern in every way."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    facts = machine_facts()
    rows = []
    for side in sides:
        for pattern in patterns:
            for name in runs:
                found = measure(pattern, side, RUNS[name])
                click.echo(json.dumps({"bench": "hostile", "run": name, **found}), err=True)
                rows.append([f"{pattern}, {side} px", name, *(str(value) for value in list(found.values())[2:])])
    click.echo(markdown_table(["pattern", "run", "wall s", "CPU s", "mode", "paths"], rows) + "\n")
    click.echo(machine_line(facts))


if __name__ == "__main__":
    main()
