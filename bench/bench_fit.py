"""Measure whole fits as a user sees them: `warpvec run` in a process of its own.

It measures the wall time from the start of Python to its end, the CPU time of all threads, the peak resident memory
and the metrics of the written file. All kernels are compiled before the first run, so the times hold for a filled
kernel cache. With ``--cold`` the first case runs again with an empty cache; the difference is the extra cost of a
first run.

VTracer is the comparison because it is the common tracer that needs no training. It has no setting for the number of
paths, so its ``filter_speckle`` is searched for the smallest value that gives at most as many paths as the fit has.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Any

import click
from harness import (
    CHECKOUT,
    comma_separated,
    comma_separated_counts,
    machine_facts,
    machine_line,
    markdown_table,
    parse_settings,
    settings_option,
)

HEADER = (
    "image", "how", "curves", "PSNR", "SSIM", "internal", "gap", "opacity", "KB", "wall s", "spread", "CPU s", "peak MB"
)  # fmt: skip

# A short fit that still runs every kernel: it adds paths, and recycles some by their removal cost.
_WARMUP = {"curves": 32, "iterations": 40, "inflation_gap": 1, "recycle_gap": 5}

_TRACE = """
import sys, vtracer
source, target, speckle = *sys.argv[1:3], int(sys.argv[3])
if hasattr(vtracer, "convert_file"):  # since version 1.0
    vtracer.convert_file(source, target, vtracer.Config(filter_speckle=speckle))
else:
    vtracer.convert_image_to_svg_py(source, target, filter_speckle=speckle)
"""
# This filter leaves only a handful of paths in any photo.
_SPECKLE_MAX = 128

# ru_maxrss is in kilobytes on Linux, in bytes on macOS (getrusage(2) of each).
_RSS_UNIT = 1 if sys.platform == "darwin" else 1024


@dataclass(frozen=True)
class Run:
    """Resources that a child process used, and its output."""

    wall: float
    cpu: float
    peak_bytes: int
    stdout: str


def run_child(arguments: Sequence[object], environment: Mapping[str, str] | None = None) -> Run:
    """Run Python with ``arguments`` and this copy of warpvec.

    Raises:
        click.ClickException: the process failed; the message has its last line of output.
    """
    paths = [str(CHECKOUT), *filter(None, [os.environ.get("PYTHONPATH")])]
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **(environment or {})}
    command = [sys.executable, *map(str, arguments)]
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        start = time.perf_counter()
        process = subprocess.Popen(command, stdout=out, stderr=err, env=variables)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        if process.returncode:
            last_line = (err.read().strip().splitlines() or [f"exit code {process.returncode}"])[-1]
            raise click.ClickException(f"{' '.join(command[1:])}: {last_line}")
        return Run(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * _RSS_UNIT, out.read())


@dataclass(frozen=True)
class Case:
    """A row of the table: the image, the program and its settings, its runs, and the metrics of its file."""

    image: Path
    how: str
    runs: list[Run]
    metrics: dict[str, Any]

    @property
    def wall(self) -> float:
        """Median wall time in seconds."""
        return statistics.median(run.wall for run in self.runs)

    def cells(self) -> list[str]:
        """Return the cells of the row, in the order of ``HEADER``; a dash is a value that only warpvec's files have."""
        metrics, internal = self.metrics, self.metrics.get("internal_psnr")
        gap = "-" if internal is None else f"{internal - metrics['psnr']:.3f}"
        sums = [_number(internal, ".2f"), gap, _number(metrics.get("mean_opacity"), ".3f")]
        walls = [run.wall for run in self.runs]
        cpu = statistics.median(run.cpu for run in self.runs)
        quality = [str(metrics["curves"]), _number(metrics["psnr"], ".2f"), f"{metrics['ssim']:.4f}", *sums]
        times = [f"{self.wall:.1f}", f"{max(walls) - min(walls):.1f}", f"{cpu:.1f}"]
        return [self.image.name, self.how, *quality, f"{metrics['bytes'] / 1e3:.1f}", *times, self._peak()]

    def to_dict(self) -> dict[str, Any]:
        """Return the row for JSON."""
        runs = [{"wall": run.wall, "cpu": run.cpu, "peak_bytes": run.peak_bytes} for run in self.runs]
        figures = {name: value for name, value in self.metrics.items() if name != "history"}
        return {"image": self.image.name, "how": self.how, "runs": runs, "metrics": figures}

    def _peak(self) -> str:
        return f"{max(run.peak_bytes for run in self.runs) / 1e6:.0f}"


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def fit_case(image: Path, preset: str, settings: dict[str, Any], repeat: int, cache: Path | None = None) -> Case:
    """Run `warpvec run` on ``image`` ``repeat`` times, with ``cache`` as the kernel cache if it is given."""
    environment = {"WARP_CACHE_PATH": str(cache)} if cache else None
    with tempfile.TemporaryDirectory() as folder:
        command = ["-m", "warpvec", "run", image, Path(folder, "out.svg"), "--json", "-q", "--preset", preset]
        runs = [run_child([*command, *cli_options(settings)], environment) for _ in range(repeat)]
    return Case(image, preset, runs, json.loads(runs[-1].stdout))


def cli_options(settings: dict[str, Any]) -> list[str]:
    """Return the settings as options of `warpvec run`."""
    options = []
    for name, value in settings.items():
        flag = name.replace("_", "-")
        options += [f"--{'' if value else 'no-'}{flag}"] if isinstance(value, bool) else [f"--{flag}", str(value)]
    return options


def vtracer_case(image: Path, curves: int, repeat: int) -> Case:
    """Run VTracer with the smallest ``filter_speckle`` that gives at most ``curves`` paths, and its other defaults."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "out.svg")
        low, high = 1, _SPECKLE_MAX
        while low < high:
            middle = (low + high) // 2
            run_child(["-c", _TRACE, image, out, middle])
            low, high = (low, middle) if out.read_text().count("<path") <= curves else (middle + 1, high)
        runs = [run_child(["-c", _TRACE, image, out, low]) for _ in range(repeat)]
        metrics = json.loads(run_child(["-m", "warpvec", "eval", image, out, "--json"]).stdout)
    return Case(image, f"vtracer, speckle {low}", runs, metrics)


def cold_cases(image: Path, preset: str, settings: dict[str, Any]) -> list[Case]:
    """Run the same fit with an empty kernel cache, and again with the cache that the first run filled."""
    with tempfile.TemporaryDirectory() as folder:
        cases = [fit_case(image, preset, settings, 1, Path(folder)) for _ in range(2)]
    labels = (f"{preset}, empty cache", f"{preset}, filled cache")
    return [Case(case.image, label, case.runs, case.metrics) for case, label in zip(cases, labels, strict=True)]


def vtracer_ratios(cases: Sequence[Case]) -> list[str]:
    """Return a line for each fit: the ratio of its median wall time to that of VTracer on the same image."""
    lines, fits = [], []
    for case in cases:
        if not case.how.startswith("vtracer"):
            fits.append(case)
            continue
        for fit in fits:
            ratio = fit.wall / case.wall
            lines.append(f"{fit.image.name}, {fit.metrics['curves']} curves, {fit.how}: {ratio:.2f} of VTracer's time")
        fits = []
    return lines


@click.command()
@click.argument("images", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--curves", callback=comma_separated_counts, default="512", show_default=True)
@click.option("--preset", "presets", callback=comma_separated, default="default", show_default=True)
@click.option("--repeat", type=click.IntRange(min=1), default=1, show_default=True, help="Number of runs of each case.")
@click.option("--cold", is_flag=True, help="Also run the first case with an empty kernel cache.")
@click.option("--vtracer/--no-vtracer", default=True, show_default=True, help="Also run VTracer, if it is installed.")
@settings_option
def main(
    images: tuple[Path, ...],
    curves: list[int],
    presets: list[str],
    repeat: int,
    cold: bool,
    vtracer: bool,
    assignments: tuple[str, ...],
) -> None:
    """Measure whole fits of IMAGES: time, memory and PSNR of the file."""
    given, facts = parse_settings(assignments), machine_facts()
    cases = []
    facts["device"] = fit_case(images[0], presets[0], {**given, **_WARMUP}, 1).metrics["device"]
    if cold:
        cases += cold_cases(images[0], presets[0], {**given, "curves": curves[0]})
    for image, count in product(images, curves):
        cases += [fit_case(image, preset, {**given, "curves": count}, repeat) for preset in presets]
        if vtracer and find_spec("vtracer"):
            cases.append(vtracer_case(image, count, repeat))
    click.echo(markdown_table(HEADER, [case.cells() for case in cases]) + "\n")
    if cold:
        click.echo(f"empty kernel cache: {cases[0].runs[0].wall - cases[1].runs[0].wall:.1f} s more")
    for line in vtracer_ratios(cases[2:] if cold else cases):
        click.echo(line)
    if vtracer and not find_spec("vtracer"):
        click.echo("VTracer was left out because it is not installed; pip install vtracer")
    click.echo(machine_line(facts))
    click.echo(json.dumps({"bench": "fit", **facts, "settings": given, "cases": [case.to_dict() for case in cases]}))


if __name__ == "__main__":
    main()
