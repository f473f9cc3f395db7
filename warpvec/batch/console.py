"""What a user sees of a batch: a table on a terminal, a line for each photo in a log, and what came of it all."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any, TextIO

from rich.console import Console
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from warpvec.batch.jobs import Job
from warpvec.batch.journal import Record


@dataclass
class Tally:
    """What has come of a batch so far; ``skipped`` are the photos that were done before it."""

    skipped: int
    total: int
    started: float = field(default_factory=time.monotonic)
    records: list[Record] = field(default_factory=list)

    @property
    def failed(self) -> list[Record]:
        """The records of the photos that it made no file of."""
        return [record for record in self.records if record.error is not None]

    def pace(self) -> str:
        """How many are done, and how long the others will take."""
        done, seconds = len(self.records), time.monotonic() - self.started
        left = f", {seconds / done * (self.total - done):.0f} s left" if 0 < done < self.total else ""
        failures = f", {len(self.failed)} failed" if self.failed else ""
        return f"{done} of {self.total}{failures}{left}"

    def facts(self) -> dict[str, Any]:
        """Plain values for JSON; ``psnr`` is the mean over this run's files."""
        psnrs = [record.psnr for record in self.records if record.error is None and record.psnr is not None]
        return {
            "images": self.skipped + self.total,
            "done": len(self.records) - len(self.failed),
            "failed": len(self.failed),
            "skipped": self.skipped,
            "left": self.total - len(self.records),
            "psnr": fmean(psnrs) if psnrs else None,
            "seconds": round(time.monotonic() - self.started, 3),
        }

    def summary(self) -> str:
        """The same for people."""
        facts = self.facts()
        parts = [f"{facts['done']} done"]
        parts += [f"{facts['failed']} failed"] if facts["failed"] else []
        parts += [f"{facts['skipped']} done before"] if facts["skipped"] else []
        parts += [f"{facts['left']} left"] if facts["left"] else []
        mean = f", PSNR {facts['psnr']:.2f} dB on average" if facts["psnr"] is not None else ""
        return f"{facts['images']} images: {', '.join(parts)}{mean}; {facts['seconds']:.1f} s"


class View:
    """Shows nothing; the others show what happens in a batch."""

    def watch(self, job: Any, text: str) -> None:
        """What becomes of a job that has not ended."""

    def show(self, record: Record, tally: Tally) -> None:
        """A job that has ended."""


@contextmanager
def show_batch(stream: TextIO, tally: Tally, *, quiet: bool = False) -> Iterator[View]:
    """A view of the batch on ``stream`` until the context ends."""
    if quiet or not tally.total:
        yield View()
    elif stream.isatty():
        table = _Table(tally)
        with Live(table, console=Console(file=stream), transient=True) as table.live:
            yield table
    else:
        yield _Lines(stream)


def describe(record: Record) -> str:
    """One line on a photo that has ended."""
    attempts = f", {record.attempts} attempts" if record.attempts > 1 else ""
    if record.error is not None:
        return f"{record.input}: failed{attempts}: {record.error}"
    quality = "no error" if record.psnr is None else f"{record.psnr:.2f} dB"
    return (
        f"{record.input}: {quality}, {record.curves} curves, {record.bytes:,} bytes, {record.seconds:.1f} s{attempts}"
    )


class _Lines(View):
    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def watch(self, job: Job, text: str) -> None:
        if text.startswith("tried again"):
            print(f"{job.input}: {text}", file=self._stream, flush=True)

    def show(self, record: Record, tally: Tally) -> None:
        print(f"[{tally.pace()}] {describe(record)}", file=self._stream, flush=True)


class _Table(View):
    """A line for each photo that ends, and below them a table: what each worker is at, and a bar for all."""

    def __init__(self, tally: Tally) -> None:
        self._tally = tally
        self._states: dict[str, str] = {}
        self.live: Live | None = None

    def watch(self, job: Job, text: str) -> None:
        self._states[job.input] = text

    def show(self, record: Record, tally: Tally) -> None:
        self._states.pop(record.input, None)
        if self.live is not None:
            self.live.console.print(Text(describe(record), "red" if record.error else ""))

    def __rich__(self) -> Table:
        """The table as it stands; drawn again several times a second, by a thread."""
        table = Table(box=None, expand=True, show_header=False, padding=(0, 1))
        table.add_column(ratio=1, no_wrap=True)
        table.add_column(ratio=2, no_wrap=True)
        for name, state in list(self._states.items()):
            table.add_row(Text(name), Text(state))
        table.add_row(ProgressBar(self._tally.total, len(self._tally.records)), Text(self._tally.pace()))
        return table
