"""Compare `warpvec batch` with single runs of the same photos, and with a batch that is killed and run again.

Three things are timed: single runs, each a process of its own, on all cores and on one job's share of them; as many
of these processes at once as the batch has jobs, which gives their speed-up; and the batch itself. The bar for the
batch is the sum of the single runs on one job's share, divided by that speed-up. Time beyond the bar is overhead of
the batch. A batch can also be faster, because it loads the kernels once per job and not once per photo. All files
are compared byte by byte.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
from bench_fit import cli_options, run_child
from fits import find_images
from harness import CHECKOUT, machine_facts, machine_line, markdown_table, parse_settings, settings_option

from warpvec.batch.journal import JSON_NAME
from warpvec.rendering.thread_pool import core_count

BAR = 1.15
"""Largest acceptable ratio of the batch's wall time to the sum of the single runs divided by the speed-up."""

# Time between two checks of the progress of the batch that will be killed.
_POLL_SECONDS = 0.05


@dataclass(frozen=True)
class Bench:
    """The photos and the options of their fits; every file is written to ``folder``."""

    photos: Sequence[Path]
    options: Sequence[str]
    jobs: int
    folder: Path

    @property
    def share(self) -> int:
        """Number of threads of each job of the batch."""
        return max(1, core_count() // self.jobs)

    def single(self, photo: Path, threads: int) -> float:
        """Return the wall seconds of `warpvec run` on ``photo``."""
        out = self.folder / f"single-{threads}"
        out.mkdir(exist_ok=True)
        target = out / f"{photo.stem}.svg"
        return run_child(["-m", "warpvec", "run", photo, target, "-q", *self.options, "--threads", threads]).wall

    def at_once(self) -> float:
        """Return the wall seconds of as many single runs at once as the batch has jobs."""
        photos = self.photos[: self.jobs]
        start = time.perf_counter()
        with ThreadPoolExecutor(len(photos)) as pool:
            list(pool.map(lambda photo: self.single(photo, self.share), photos))
        return time.perf_counter() - start

    def command(self, name: str) -> list[str]:
        """Return the arguments of Python for a batch that writes to the folder ``name``."""
        source = self.folder / "photos"
        if not source.exists():
            source.mkdir()
            for photo in self.photos:
                (source / photo.name).symlink_to(photo.resolve())
        target = str(self.folder / name)
        return ["-m", "warpvec", "batch", str(source), target, "-q", "--jobs", str(self.jobs), *self.options]

    def batch(self, name: str) -> float:
        """Run a batch that writes to the folder ``name``; return its wall seconds."""
        return run_child(self.command(name)).wall

    def killed_batch(self, name: str) -> tuple[float, int]:
        """Kill a batch when half of its photos are done; return its wall seconds and the number of photos done."""
        start = time.perf_counter()
        environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
        with subprocess.Popen([sys.executable, *self.command(name)], env=environment) as process:
            while len(self.records(name)) < len(self.photos) // 2 and process.poll() is None:
                time.sleep(_POLL_SECONDS)
            process.kill()
        return time.perf_counter() - start, len(self.records(name))

    def records(self, name: str) -> dict[str, Any]:
        """Return the batch's record of each photo."""
        path = self.folder / name / JSON_NAME
        lines = path.read_text().split("\n")[:-1] if path.exists() else []
        return {record["input"]: record for record in map(json.loads, lines)}

    def files(self, name: str) -> dict[str, bytes]:
        """Return the SVG files in the folder ``name``."""
        return {path.name: path.read_bytes() for path in (self.folder / name).glob("*.svg")}


def compare(bench: Bench) -> list[list[object]]:
    """Time single runs and the batch; return the rows of the table.

    Raises:
        click.ClickException: the batch writes other files than the single runs.
    """
    alone = [bench.single(photo, bench.share) for photo in bench.photos]
    whole = sum(bench.single(photo, core_count()) for photo in bench.photos)
    speed_up = sum(alone[: bench.jobs]) / bench.at_once()
    seconds = bench.batch("batch")
    if bench.files("batch") != bench.files(f"single-{bench.share}"):
        raise click.ClickException("the files of the batch differ from those of the single runs")
    expected = sum(alone) / speed_up
    return [
        [f"single runs, {core_count()} threads, sum", f"{whole:.1f} s"],
        [f"single runs, {bench.share} thread(s), sum", f"{sum(alone):.1f} s"],
        [f"speed-up of {bench.jobs} such runs at once", f"{speed_up:.2f}"],
        ["that sum divided by the speed-up", f"{expected:.1f} s"],
        [f"batch, {bench.jobs} jobs", f"{seconds:.1f} s"],
        [f"batch / that time (at most {BAR})", f"{seconds / expected:.2f}"],
        ["batch / single runs on all cores", f"{seconds / whole:.2f}"],
    ]


def kill_and_resume(bench: Bench) -> list[list[object]]:
    """Kill a batch and run it again; return the rows of the table.

    Raises:
        click.ClickException: a photo was fitted twice, or is missing.
    """
    first, done = bench.killed_batch("killed")
    before, times = bench.records("killed"), _written_at(bench.folder / "killed")
    second = bench.batch("killed")
    after, later = bench.records("killed"), _written_at(bench.folder / "killed")
    again = [name for name, record in before.items() if later[record["output"]] != times[record["output"]]]
    missing = [photo.name for photo in bench.photos if after.get(photo.name, {}).get("error", "none") is not None]
    if again or missing or bench.files("killed") != bench.files("batch"):
        raise click.ClickException(f"fitted twice: {again}, missing: {missing}")
    return [
        [f"killed after {done} of {len(bench.photos)} photos", f"{first:.1f} s"],
        [f"run again: none of the {done} fitted twice, none missing", f"{second:.1f} s"],
    ]


def _written_at(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.svg")}


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--preset", default="default", show_default=True)
@click.option("--jobs", type=click.IntRange(min=1), default=2, show_default=True)
@click.option("--limit", type=click.IntRange(min=2), help="Use only the first N images.")
@settings_option
def main(folder: Path, preset: str, jobs: int, limit: int | None, assignments: tuple[str, ...]) -> None:
    """Compare a batch of the photos of FOLDER with single runs of them."""
    settings = parse_settings(assignments)
    facts = machine_facts()
    photos = find_images(folder, limit)
    with tempfile.TemporaryDirectory() as work:
        bench = Bench(photos, ["--preset", preset, "--device", "cpu", *cli_options(settings)], jobs, Path(work))
        bench.single(photos[0], bench.share)  # compiles the kernels that are not cached
        rows = [*compare(bench), *kill_and_resume(bench)]
    click.echo(markdown_table((f"{len(photos)} photos, preset {preset} {json.dumps(settings)}", ""), rows) + "\n")
    click.echo(machine_line(facts))


if __name__ == "__main__":
    main()
