"""Measure where people wait with icons: a warm drawing, the first one, its memory, and a folder.

All times are CPU seconds (user and system) on one thread, and all that is compared is run in turns, so that other work
on the machine changes both. Warm drawings may be compared with those of another commit, of which a copy is made, and
their files with its files. A folder is drawn by `warpvec batch`, and by VTracer in one process if it is installed.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from statistics import median
from typing import Any

import click
from bench_fit import run_child
from harness import CHECKOUT, machine_facts, machine_line, markdown_table

_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

_WARM = """
import hashlib, json, resource, sys, warpvec
from warpvec.cli.loading import quick_loading
with quick_loading():
    from warpvec.api import vectorize

def cpu():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime

vectorize(sys.argv[1], threads=1)
found = {}
for path in sys.argv[1:]:
    start = cpu()
    text = vectorize(path, threads=1).svg()
    found[path] = cpu() - start, hashlib.sha256(text.encode()).hexdigest(), text
import resvg_py
start = cpu()
for _, _, text in found.values():
    for _ in range(10):
        resvg_py.svg_to_bytes(text)
drawn = (cpu() - start) / 10
figures = {path: each[:2] for path, each in found.items()}
print(json.dumps({"pictures": figures, "resvg": drawn, "of": warpvec.__file__}))
"""
"""Draws pictures in a warm process; prints the seconds and the digest of each, and resvg's seconds for all files."""

_VTRACER = """
import os, sys, vtracer
for path in sys.argv[2:]:
    vtracer.convert_image_to_svg_py(path, os.path.join(sys.argv[1], os.path.basename(path) + ".svg"))
"""


def warm(checkout: Path, pictures: Sequence[Path]) -> dict[str, Any]:
    """Return what the process of `_WARM` prints, with the warpvec of ``checkout``."""
    # -P: the current folder must not come before that checkout.
    run = run_child(["-P", "-c", _WARM, *pictures], {**_ONE_THREAD, "PYTHONPATH": str(checkout)})
    found: dict[str, Any] = json.loads(run.stdout)
    assert Path(found["of"]).is_relative_to(checkout), found["of"]
    return found


def copy_of(commit: str, folder: Path) -> Path:
    """Write the files of a ``commit`` to ``folder``; return it."""
    archive = subprocess.run(["git", "archive", commit], cwd=CHECKOUT, check=True, capture_output=True)
    with tarfile.open(fileobj=BytesIO(archive.stdout)) as files:
        files.extractall(folder, filter="data")
    return folder


def compare_warm(pictures: Sequence[Path], checkout: Path | None, pairs: int) -> list[tuple[str, str]]:
    """Return rows: seconds of a warm drawing, in drawings by resvg, and over those of another ``checkout``."""
    ours, ratios, units, same = list[float](), list[float](), list[float](), 0
    for _ in range(pairs):
        here = warm(CHECKOUT, pictures)
        seconds = {path: each[0] for path, each in here["pictures"].items()}
        ours += seconds.values()
        units.append(sum(seconds.values()) / here["resvg"])
        if checkout is not None:
            there = warm(checkout, pictures)["pictures"]
            ratios += [seconds[path] / there[path][0] for path in seconds]
            same = sum(here["pictures"][path][1] == there[path][1] for path in seconds)
    rows = [("warm drawing, s", f"{median(ours):.2f}"), ("in drawings of its file by resvg", f"{median(units):.0f}")]
    if checkout is not None:
        rows.append(("over the other commit", f"{median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"))
        rows.append(("files of the same bytes", f"{same} of {len(pictures)}"))
    return rows


def compare_whole(picture: Path, pairs: int) -> list[tuple[str, str]]:
    """Return rows: the whole process of `warpvec run` over that of "import torch", and its peak memory."""
    ratios, peaks = [], []
    with tempfile.TemporaryDirectory() as folder:
        command = ["-m", "warpvec", "run", picture, Path(folder, "out.svg"), "--threads", 1, "-q"]
        run_child(command, _ONE_THREAD)  # compiles the kernels that are not cached
        for _ in range(pairs):
            least = run_child(["-c", "import torch"], _ONE_THREAD)
            whole = run_child(command, _ONE_THREAD)
            ratios.append(whole.cpu / least.cpu)
            peaks.append(whole.peak_bytes / 1e6)
    return [
        (f"whole process, {picture.stem}, over import torch", f"{median(ratios):.2f}"),
        ("its peak memory, MB", f"{max(peaks):.0f}"),
    ]


def compare_folder(pictures: Sequence[Path]) -> list[tuple[str, str]]:
    """Return rows: `warpvec batch --jobs 2` of all pictures, and VTracer."""
    count = len(pictures)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "pictures")
        source.mkdir()
        for picture in pictures:
            (source / picture.name).symlink_to(picture.resolve())
        run = run_child(["-m", "warpvec", "batch", source, Path(folder, "out"), "-q", "--jobs", 2], _ONE_THREAD)
        rows = [
            ("batch --jobs 2, pictures a second", f"{count / run.wall:.2f}"),
            ("s a picture", f"{run.cpu / count:.2f}"),
        ]
        try:
            rival = run_child(["-c", _VTRACER, folder, *pictures], _ONE_THREAD)
        except click.ClickException:  # it is not installed
            return rows
        return [*rows, ("over vtracer in one process", f"{run.cpu / rival.cpu:.0f}")]


@click.command()
@click.argument("pictures", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--against", metavar="COMMIT", help="Compare warm drawings with those of this commit.")
@click.option("--pairs", type=click.IntRange(min=1), default=3, show_default=True, help="Runs of each.")
@click.option("--batch/--no-batch", "with_batch", default=True, show_default=True, help="Also draw them as a folder.")
def main(pictures: Sequence[Path], against: str | None, pairs: int, with_batch: bool) -> None:
    """Measure where people wait with PICTURES, which are icons of 512 px. The first one is run as a whole process."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    facts, pictures = machine_facts(), [each.resolve() for each in pictures]
    with tempfile.TemporaryDirectory() as folder:
        other = None if against is None else copy_of(against, Path(folder))
        rows = compare_warm(pictures, other, pairs)
    rows += compare_whole(pictures[0], pairs)
    rows += compare_folder(pictures) if with_batch else []
    click.echo(markdown_table([f"{len(pictures)} pictures", "CPU, one thread"], rows) + "\n")
    click.echo(machine_line(facts))
    click.echo(json.dumps({"bench": "waiting", **facts, "against": against, "rows": rows}))


if __name__ == "__main__":
    sys.exit(main())
