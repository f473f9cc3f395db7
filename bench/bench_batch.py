"""Measures a folder done by `warpvec batch` beside its photos done one by one, and a batch that is killed and goes on.

What: the wall time of single runs, a process each, with all cores and with the share of the cores that a job of the
batch has; the speed-up of so many processes at once, measured with the same photos; the batch. Its bar is the
sum of the single runs on such a share, over that speed-up: what a batch takes beyond it is its own doing. It may take
less, as it starts and loads kernels once for each job, and not for each photo. Files are compared byte by byte.
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
"""Wall time of the batch over the sum of single runs by the speed-up, at most."""

# Between looks at how far the batch is that is to be killed.
_LOOK_SECONDS = 0.05


@dataclass(frozen=True)
class Bench:
    """The photos and how they are fitted; everything is written to ``folder``."""

    photos: Sequence[Path]
    options: Sequence[str]
    jobs: int
    folder: Path

    @property
    def share(self) -> int:
        """Threads of each job of the batch."""
        return max(1, core_count() // self.jobs)

    def single(self, photo: Path, threads: int) -> float:
        """Wall seconds of a run of its own."""
        out = self.folder / f"single-{threads}"
        out.mkdir(exist_ok=True)
        target = out / f"{photo.stem}.svg"
        return run_child(["-m", "warpvec", "run", photo, target, "-q", *self.options, "--threads", threads]).wall

    def at_once(self) -> float:
        """Wall seconds of the first photos, as many as there are jobs, run at once."""
        photos = self.photos[: self.jobs]
        start = time.perf_counter()
        with ThreadPoolExecutor(len(photos)) as pool:
            list(pool.map(lambda photo: self.single(photo, self.share), photos))
        return time.perf_counter() - start

    def command(self, name: str) -> list[str]:
        """A batch into the folder ``name``."""
        source = self.folder / "photos"
        if not source.exists():
            source.mkdir()
            for photo in self.photos:
                (source / photo.name).symlink_to(photo.resolve())
        target = str(self.folder / name)
        return ["-m", "warpvec", "batch", str(source), target, "-q", "--jobs", str(self.jobs), *self.options]

    def batch(self, name: str) -> float:
        """Wall seconds of a batch into the folder ``name``."""
        return run_child(self.command(name)).wall

    def killed_batch(self, name: str) -> tuple[float, int]:
        """Wall seconds of a batch that is killed with half of the photos done, and how many were."""
        start = time.perf_counter()
        environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
        with subprocess.Popen([sys.executable, *self.command(name)], env=environment) as process:
            while len(self.records(name)) < len(self.photos) // 2 and process.poll() is None:
                time.sleep(_LOOK_SECONDS)
            process.kill()
        return time.perf_counter() - start, len(self.records(name))

    def records(self, name: str) -> dict[str, Any]:
        """Photo -> its record."""
        path = self.folder / name / JSON_NAME
        lines = path.read_text().split("\n")[:-1] if path.exists() else []
        return {record["input"]: record for record in map(json.loads, lines)}

    def files(self, name: str) -> dict[str, bytes]:
        """The SVGs in the folder ``name``."""
        return {path.name: path.read_bytes() for path in (self.folder / name).glob("*.svg")}


def compare(bench: Bench) -> list[list[object]]:
    """The rows on time."""
    alone = [bench.single(photo, bench.share) for photo in bench.photos]
    whole = sum(bench.single(photo, core_count()) for photo in bench.photos)
    speed_up = sum(alone[: bench.jobs]) / bench.at_once()
    seconds = bench.batch("batch")
    if bench.files("batch") != bench.files(f"single-{bench.share}"):
        raise click.ClickException("the batch's files differ from those of single runs")
    expected = sum(alone) / speed_up
    return [
        [f"single runs, {core_count()} threads, sum", f"{whole:.1f} s"],
        [f"single runs, {bench.share} thread(s), sum", f"{sum(alone):.1f} s"],
        [f"speed-up of {bench.jobs} such runs at once", f"{speed_up:.2f}"],
        ["the sum over the speed-up", f"{expected:.1f} s"],
        [f"batch, {bench.jobs} jobs", f"{seconds:.1f} s"],
        [f"batch over that sum (bar: {BAR})", f"{seconds / expected:.2f}"],
        ["batch over single runs on all cores", f"{seconds / whole:.2f}"],
    ]


def kill_and_go_on(bench: Bench) -> list[list[object]]:
    """The rows on a batch that is killed.

    Raises:
        click.ClickException: a photo was done again, or is missing.
    """
    first, done = bench.killed_batch("killed")
    before, times = bench.records("killed"), _times(bench.folder / "killed")
    second = bench.batch("killed")
    after, later = bench.records("killed"), _times(bench.folder / "killed")
    again = [name for name, record in before.items() if later[record["output"]] != times[record["output"]]]
    missing = [photo.name for photo in bench.photos if after.get(photo.name, {}).get("error", "none") is not None]
    if again or missing or bench.files("killed") != bench.files("batch"):
        raise click.ClickException(f"done again: {again}, missing: {missing}")
    return [
        [f"killed with {done} of {len(bench.photos)} done", f"{first:.1f} s"],
        [f"run again: none of the {done} again, none missing", f"{second:.1f} s"],
    ]


def _times(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.svg")}


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--preset", default="default", show_default=True)
@click.option("--jobs", type=click.IntRange(min=1), default=2, show_default=True)
@click.option("--limit", type=click.IntRange(min=2), help="Only the first so many images.")
@settings_option
def main(folder: Path, preset: str, jobs: int, limit: int | None, assignments: tuple[str, ...]) -> None:
    """The photos of FOLDER, one by one and as a batch."""
    settings = parse_settings(assignments)
    facts = machine_facts()
    photos = find_images(folder, limit)
    with tempfile.TemporaryDirectory() as work:
        bench = Bench(photos, ["--preset", preset, "--device", "cpu", *cli_options(settings)], jobs, Path(work))
        bench.single(photos[0], bench.share)  # compiles what is not cached
        rows = [*compare(bench), *kill_and_go_on(bench)]
    click.echo(markdown_table((f"{len(photos)} photos, preset {preset} {json.dumps(settings)}", ""), rows) + "\n")
    click.echo(machine_line(facts))


if __name__ == "__main__":
    main()
