"""Make many small calls of mixed modes in one process, and state its memory, threads and open files along the way.

    python bench/many_calls.py --calls 300 --seed 1

Pictures are photos, drawings, outlines on transparent ground, black and white and pixel art of 16 to 40 px.
"""

from __future__ import annotations

import gc
import os
import threading
import warnings
from collections import Counter
from pathlib import Path
from random import Random

import click
import numpy as np
from numpy.typing import NDArray

import warpvec
from warpvec.errors import InputError

CALLS = (
    ("photo", {"mode": "photo", "curves": 6, "iterations": 6}),
    ("splat", {"mode": "photo", "curves": 6, "iterations": 4, "renderer": "splat", "samples": 8, "lines": 4}),
    ("gradients", {"mode": "photo", "curves": 6, "iterations": 6, "gradients": 0.5}),
    ("bytes", {"mode": "photo", "max_bytes": 900, "iterations": 6}),
    ("flat", {"mode": "flat", "iterations": 8}),
    ("cut out", {"mode": "flat", "iterations": 8, "cutout": True}),
    ("mono", {"mode": "mono"}),
    ("lines", {"mode": "lines"}),
    ("pixel", {"mode": "pixel"}),
    ("mixed", {"mode": "mixed", "curves": 6, "iterations": 6}),
    ("auto", {"iterations": 6}),
    ("refine", {}),
)  # fmt: skip
"""Names of calls, and their settings."""


SECONDS = 2.0
"""Longest time of most calls: noise drawn as flat art takes up to a minute without."""


def picture(chance: Random) -> NDArray[np.uint8]:
    """Return a small picture [h, w, 3 or 4]."""
    height, width = chance.randrange(16, 40), chance.randrange(16, 40)
    generator = np.random.default_rng(chance.randrange(2**31))
    if chance.random() < 0.3:
        return generator.integers(0, 256, (height, width, 3), np.uint8)
    channels = chance.choice([3, 4])
    levels = np.full((height, width, channels), 255 if channels == 3 else 0, np.uint8)
    for _ in range(chance.randrange(1, 4)):
        top, left = chance.randrange(height - 8), chance.randrange(width - 8)
        levels[top : top + chance.randrange(4, 12), left : left + chance.randrange(4, 12)] = [
            *generator.integers(0, 256, 3, np.uint8), *([255] if channels == 4 else []),
        ]  # fmt: skip
    return levels


def call(name: str, settings: dict[str, object], chance: Random) -> str:
    """Make one call; return "done" or "refused"."""
    levels, threads = picture(chance), chance.choice([1, 2])
    try:
        if name == "refine":
            height, width = levels.shape[:2]
            drawing = (
                f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">'
                '<rect x="3" y="4" width="9" height="7" fill="#c31"/><path d="M2 2C9 1 12 9 4 12z" fill="#13c"/></svg>'
            )
            warpvec.refine(levels, drawing.encode(), iterations=3, threads=threads, device="cpu")
        else:
            budget = {} if settings.get("max_bytes") else {"time_budget": SECONDS}
            result = warpvec.vectorize(levels, threads=threads, device="cpu", **budget, **settings)
            assert result.svg() and result.metrics
    except InputError:
        return "refused"
    return "done"


def _row(count: int) -> str:
    gc.collect()
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
    tasks, files = len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd"))
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return (
        f"{count} calls: {resident:.0f} MiB, {threading.active_count()} threads of Python, {tasks} of the system,"
        f" {files} open files, {len(children)} children"
    )


@click.command()
@click.option("--calls", type=click.IntRange(min=1), default=300, show_default=True)
@click.option("--seed", type=int, default=1, show_default=True)
def main(calls: int, seed: int) -> None:
    """Make the calls."""
    warnings.simplefilter("ignore")
    chance, ends = Random(seed), Counter[str]()
    for number in range(calls):
        name, settings = CALLS[number % len(CALLS)] if number < len(CALLS) else chance.choice(CALLS)
        ends[f"{name} {call(name, dict(settings), chance)}"] += 1
        if number + 1 == len(CALLS) or (number + 1) % 48 == 0 or number + 1 == calls:
            click.echo(_row(number + 1))
    click.echo(f"{calls} calls, seed {seed}: {dict(sorted(ends.items()))}")


if __name__ == "__main__":
    main()
