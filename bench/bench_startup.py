"""Measure what a run costs around its fit: the time to the first iteration, and the extra cost of a first run.

It times `warpvec --help`, and a short `warpvec run` from the start of the process to its first iteration and to its
end, with cached kernels and with an empty kernel cache. The run uses every kernel of a fit: it adds and recycles
paths. "import torch" is timed too, as a lower limit for any program that uses torch, and a whole run of the image with
default settings on one thread, whose CPU time is stated as a multiple of it. Last, the time of the imports of flat art
is shared out among the packages that they load. Children keep the bytecode of modules, as installed packages do.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import click
from bench_fit import CHECKOUT, run_child
from harness import Span, Statistics, machine_facts, machine_line, markdown_table, summarize

_WATCHED = Path(__file__).with_name("watched_run.py")
_SHORT = ("--curves", 32, "--iterations", 40, "--inflation-gap", 1, "--recycle-gap", 5, "--json", "-q")
_HELP, _IMPORT = "warpvec --help", "import torch"
_FIRST, _END = "cached run, to its first iteration", "cached run, to its end"
_SHARE_MIN = 0.01  # of packages that are printed
_WHOLE = "default run, one thread, to its end"
_COLD = "empty kernel cache, to its end"


def time_help() -> Span:
    """Time `warpvec --help`."""
    run = run_child(["-m", "warpvec", "--help"])
    return Span(run.wall, run.cpu)


def time_import() -> Span:
    """Time a process that only imports torch."""
    run = run_child(["-c", "import torch"])
    return Span(run.wall, run.cpu)


def time_run(image: Path, environment: Mapping[str, str] | None = None) -> tuple[Span, Span]:
    """Time `warpvec run` from its start to its first iteration, and to its end."""
    with tempfile.TemporaryDirectory() as folder:
        command = [_WATCHED, image, Path(folder, "out.svg"), *_SHORT]
        start = time.time()
        run = run_child(command, environment)
    seen = json.loads(run.stdout.splitlines()[-1])
    return Span(seen["first_iteration"] - start, seen["first_cpu"]), Span(run.wall, run.cpu)


def time_whole(image: Path) -> Span:
    """Time `warpvec run` with default settings on one thread."""
    with tempfile.TemporaryDirectory() as folder:
        run = run_child(["-m", "warpvec", "run", image, Path(folder, "out.svg"), "--threads", 1, "-q"])
    return Span(run.wall, run.cpu)


def import_shares(module: str = "warpvec.modes.flat") -> dict[str, float]:
    """Return the seconds that each package takes to load for ``module``, the slowest first.

    Python's own clock of imports makes them slower, but hardly changes their shares.
    """
    found: dict[str, float] = defaultdict(float)
    command = [
        sys.executable,
        "-X",
        "importtime",
        "-c",
        f"import warpvec.cli.postponed as p; p.postpone(); import {module}",
    ]
    run = subprocess.run(command, cwd=CHECKOUT, capture_output=True, text=True, check=True)
    for line in run.stderr.splitlines():
        own, _, name = line.removeprefix("import time:").partition("|")
        if own.strip().isdigit():
            found[name.rpartition("|")[2].strip().partition(".")[0]] += int(own) / 1e6
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def measure(image: Path, repeat: int, cold: bool) -> dict[str, Statistics]:
    """Run everything once in each of ``repeat`` rounds; return the statistics of each row."""
    time_run(image)  # compiles the kernels that are not cached
    spans: dict[str, list[Span]] = defaultdict(list)
    for _ in range(repeat):
        spans[_HELP].append(time_help())
        spans[_IMPORT].append(time_import())
        first, whole = time_run(image)
        spans[_FIRST].append(first)
        spans[_END].append(whole)
        spans[_WHOLE].append(time_whole(image))
    if cold:
        with tempfile.TemporaryDirectory() as folder:
            spans[_COLD].append(time_run(image, {"WARP_CACHE_PATH": folder})[1])
    return {name: summarize(found) for name, found in spans.items()}


def _cells(row: Statistics) -> list[str]:
    return [f"{seconds:.2f}" for seconds in (row.median, row.minimum, row.spread, row.cpu_median)]


@click.command()
@click.argument("image", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--repeat", type=click.IntRange(min=1), default=5, show_default=True, help="Number of rounds.")
@click.option("--cold/--no-cold", default=True, show_default=True, help="Also time a run with an empty kernel cache.")
def main(image: Path, repeat: int, cold: bool) -> None:
    """Measure what `warpvec run IMAGE` costs around its fit."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    facts = machine_facts()
    found = measure(image, repeat, cold)
    rows = [[name, *_cells(row)] for name, row in found.items()]
    click.echo(markdown_table(["seconds", "median", "min", "spread", "CPU"], rows) + "\n")
    times = found[_WHOLE].cpu_median / found[_IMPORT].cpu_median
    click.echo(f"a default run takes {times:.2f} times the CPU seconds of {_IMPORT}")
    if cold:
        click.echo(f"a first run takes {found[_COLD].minimum - found[_END].minimum:.1f} s longer")
    shares = import_shares()
    whole = sum(shares.values())
    largest = [(name, seconds) for name, seconds in shares.items() if seconds >= _SHARE_MIN * whole]
    rows = [[name, f"{seconds:.2f}", f"{100 * seconds / whole:.0f} %"] for name, seconds in largest]
    click.echo(markdown_table(["imports of flat art", "seconds", "share"], rows) + "\n")
    click.echo(machine_line(facts))
    line = {"bench": "startup", **facts, "ms": found, "imports": shares}
    click.echo(json.dumps(line, default=Statistics.milliseconds))


if __name__ == "__main__":
    main()
