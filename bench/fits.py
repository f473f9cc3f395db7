"""Shared parts of the benchmarks that make many fits: photos of a folder, engines, a CSV of results, a warm-up.

The key of a result depends on the bytes of the image, the settings and the sources of warpvec. A run that was
interrupted continues where it ended; after a change to any of the three, the fits are made again.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np
from harness import source_digest

from warpvec import vectorize
from warpvec.batch.engines.base import Engine, Notify, Outcome, Work, WorkerShare
from warpvec.batch.engines.local import LocalEngine
from warpvec.config.fit_config import FitConfig
from warpvec.image.formats import SUFFIXES
from warpvec.rendering.thread_pool import core_count

J = TypeVar("J")
R = TypeVar("R")

Row = dict[str, str]

# A short fit that adds and recycles paths, so that every kernel of a fit runs.
_WARMUP = {"curves": 32, "iterations": 40, "inflation_gap": 1, "recycle_gap": 5}


def find_images(folder: Path, limit: int | None = None) -> list[Path]:
    """Return the images of ``folder``, or the first ``limit`` of them, sorted by name.

    Raises:
        click.UsageError: the folder holds no images.
    """
    images = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)[:limit]
    if not images:
        raise click.UsageError(f"FOLDER must hold images ({', '.join(SUFFIXES)}), but {folder} holds none")
    return images


def fit_key(image: bytes, config: FitConfig, *more: object) -> str:
    """Return a digest of the image, all settings, time budget and device included, the sources, and ``more``."""
    settings = json.dumps([config.to_dict(), *more], sort_keys=True)
    return hashlib.sha256(image + settings.encode() + source_digest().encode()).hexdigest()[:16]


# Engines


jobs_option = click.option(
    "--jobs", type=click.IntRange(min=1), default=1, show_default=True,
    help="Fits at a time, each in a process with its share of the cores; each fit then takes longer.",
)  # fmt: skip


def engine_for(jobs: int, settings: dict[str, Any]) -> tuple[Engine, dict[str, Any]]:
    """Return an engine that runs ``jobs`` fits at a time, and ``settings`` with the threads of each fit."""
    if jobs == 1:
        return InProcess(), settings
    settings = {"threads": max(1, core_count() // jobs), **settings}
    return LocalEngine(["cpu"], settings["threads"], jobs, retries=1), settings


class InProcess:
    """Engine that does one job after the other in this process, and lets their exceptions pass."""

    def run(self, jobs: Sequence[J], work: Work[J, R], notify: Notify) -> Generator[Outcome[J, R], None, None]:
        """Yield the outcome of every job, in order."""
        for job in jobs:
            yield Outcome(job, work(job, WorkerShare("cpu", 1), lambda text: None), None, 1)


def results_of(engine: Engine, jobs: Sequence[J], work: Work[J, R]) -> Iterator[R]:
    """Yield the result of every job as it ends.

    The work takes device and threads from its own settings, not from its worker share.

    Raises:
        click.ClickException: a job failed.
    """
    with closing(engine.run(jobs, work, lambda job, text: None)) as outcomes:
        for outcome in outcomes:
            if outcome.value is None:
                raise click.ClickException(f"{outcome.job}: {outcome.error}")
            yield outcome.value


def warm_up(preset: str, settings: Mapping[str, Any]) -> None:
    """Compile and load every kernel of a fit with these settings, once per process."""
    _warm_up_once(preset, json.dumps(dict(settings), sort_keys=True))


@cache
def _warm_up_once(preset: str, settings: str) -> None:
    noise = np.random.default_rng(0).random((32, 32, 3), dtype=np.float32)
    _ = vectorize(noise, preset=preset, **{**json.loads(settings), **_WARMUP}).metrics


@dataclass(frozen=True)
class ResultFile:
    """CSV file of results with the columns ``fields``, of which the first is the key."""

    path: Path
    fields: tuple[str, ...]

    def read(self) -> dict[str, Row]:
        """Return the last row of each key; empty if there is no file. Cut off the half line that a killed run left.

        Raises:
            click.UsageError: the file has other columns.
        """
        if not self.path.exists():
            return {}
        text = self.path.read_text()
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            self.path.write_text(whole)
        reader = csv.DictReader(io.StringIO(whole))
        if reader.fieldnames is not None and tuple(reader.fieldnames) != self.fields:
            raise click.UsageError(
                f"--out must be a file with the columns of this version, but {self.path} has others; name a new file"
            )
        return {row[self.fields[0]]: row for row in reader}

    def append(self, row: Mapping[str, Any]) -> None:
        """Add one row, and the header if the file is new, in one write that has reached the disk on return."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        text = io.StringIO()
        writer = csv.DictWriter(text, self.fields, lineterminator="\n")
        with self.path.open("a", newline="") as file:
            if file.tell() == 0:
                writer.writeheader()
            writer.writerow(row)
            file.write(text.getvalue())
            file.flush()
            os.fsync(file.fileno())
