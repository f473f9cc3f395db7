"""Show a batch: a table on a terminal, one line per photo in a log, and a summary."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any, TextIO

from rich.console import Console
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from warpvec.batch.jobs import PhotoJob
from warpvec.batch.journal import Record
from warpvec.checks import counted, in_one_line
from warpvec.config.modes import MODES

_SMOOTHING = 0.2
"""Share by which each photo that ends moves the expected end: a long photo among short ones moves it little."""


@dataclass
class Tally:
    """The results of a batch so far.

    Attributes:
        skipped: number of photos that were done before it.
        total: number of the others.
        started: when it began, by the clock `time.monotonic`.
        records: those of the photos that have ended.
        efforts: expected time of the work on photos, by name, in any unit; 1 for those that are not named.
    """

    skipped: int
    total: int
    started: float = field(default_factory=time.monotonic)
    records: list[Record] = field(default_factory=list)
    efforts: Mapping[str, float] = field(default_factory=dict)
    _counted: int = 0
    """Number of records that the fields below know."""
    _tried: int = 0
    _tried_effort: float = 0.0
    _end: float | None = None

    @property
    def failed(self) -> list[Record]:
        """The records of the photos that failed."""
        return [record for record in self.records if record.error is not None]

    def share(self) -> float:
        """Return the share of the work that is done."""
        whole = self._whole()
        return 1.0 - self._left() / whole if whole else 1.0

    def pace(self) -> str:
        """Return the number of finished photos, their pace, and the time that the others will take, as text.

        Photos that were refused before any attempt took no time. The pace leaves them out.
        """
        now, done = time.monotonic(), len(self.records)
        self._count(now)
        parts = [f"{done} of {self.total}"]
        parts += [f"{len(self.failed)} failed"] if self.failed else []
        if self._tried and done < self.total and self._end is not None:
            rate = self._tried / max(now - self.started, 1e-3)
            parts.append(f"{rate:.1f} a second" if rate >= 1.0 else f"{60.0 * rate:.1f} a minute")
            left = max(self._end - now, 0.0)
            parts.append(f"{left:.0f} s left" if left < 120.5 else f"{left / 60.0:.0f} min left")
        return ", ".join(parts)

    def _count(self, now: float) -> None:
        """Take new records into account."""
        new = self.records[self._counted :]
        tried = [self.efforts.get(record.input, 1.0) for record in new if record.attempts > 0]
        self._counted += len(new)
        self._tried, self._tried_effort = self._tried + len(tried), self._tried_effort + sum(tried)
        if tried:
            end = now + (now - self.started) * self._left() / self._tried_effort
            known = end if self._end is None else self._end
            self._end = known + max(_SMOOTHING, 1.0 / self._tried) * (end - known)

    def _whole(self) -> float:
        return sum(self.efforts.values()) + self.total - len(self.efforts)

    def _left(self) -> float:
        return self._whole() - sum(self.efforts.get(record.input, 1.0) for record in self.records)

    def facts(self) -> dict[str, Any]:
        """Return the counts, the seconds, and the modes and the mean PSNR of the new files, as plain values for JSON.

        The most frequent mode comes first.
        """
        done = [record for record in self.records if record.error is None]
        psnrs = [record.psnr for record in done if record.psnr is not None]
        return {
            "images": self.skipped + self.total,
            "done": len(done),
            "failed": len(self.failed),
            "skipped": self.skipped,
            "modes": dict(Counter(record.mode for record in done if record.mode is not None).most_common()),
            "left": self.total - len(self.records),
            "psnr": fmean(psnrs) if psnrs else None,
            "seconds": round(time.monotonic() - self.started, 3),
        }

    def summary(self) -> str:
        """Return the facts as one line of text."""
        facts = self.facts()
        modes = ", ".join(f"{count} as {MODES[mode].plural}" for mode, count in facts["modes"].items())
        parts = [f"{facts['done']} done" + (f" ({modes})" if modes else "")]
        parts += [f"{facts['failed']} failed"] if facts["failed"] else []
        parts += [f"{facts['skipped']} done before"] if facts["skipped"] else []
        parts += [f"{facts['left']} left"] if facts["left"] else []
        mean = f", PSNR {facts['psnr']:.2f} dB on average" if facts["psnr"] is not None else ""
        return f"{counted(facts['images'], 'image')}: {', '.join(parts)}{mean}; {facts['seconds']:.1f} s"


class View:
    """A view that shows nothing; its subclasses show the progress of a batch."""

    def update(self, job: Any, text: str) -> None:
        """Show the news of a job that has not ended."""

    def show(self, record: Record, tally: Tally) -> None:
        """Show a job that has ended."""


@contextmanager
def show_batch(stream: TextIO | None, tally: Tally, *, quiet: bool = False) -> Iterator[View]:
    """Show the batch on ``stream`` until the context ends; None is a stream that is closed."""
    if stream is None or not tally.total:
        yield View()
    elif quiet:
        yield _Failures(stream)
    elif stream.isatty():
        table = _Table(tally)
        with Live(table, console=Console(file=stream), transient=True) as table.live:
            yield table
    else:
        yield _Lines(stream)


def describe(record: Record) -> str:
    """Return one line about a photo that has ended."""
    attempts = f", {record.attempts} attempts" if record.attempts > 1 else ""
    if record.error is not None:
        return in_one_line(f"{record.input}: failed{attempts}: {record.error}")
    quality = "no error" if record.psnr is None else f"{record.psnr:.2f} dB"
    size = f"{counted(record.curves or 0, 'path')}, {record.bytes:,} bytes"
    losses = f"; {record.losses}" if record.losses else ""
    return in_one_line(f"{record.input}: {quality}, {size}, {record.seconds:.1f} s{attempts}{losses}")


class _Failures(View):
    """One line for each photo that fails."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def show(self, record: Record, tally: Tally) -> None:
        if record.error is not None:
            print(f"warpvec: {describe(record)}", file=self._stream, flush=True)


class _Lines(_Failures):
    """One line for each photo that ends, and for each further attempt."""

    def update(self, job: PhotoJob, text: str) -> None:
        if text.startswith("tried again"):
            print(in_one_line(f"{job.input}: {text}"), file=self._stream, flush=True)

    def show(self, record: Record, tally: Tally) -> None:
        print(f"[{tally.pace()}] {describe(record)}", file=self._stream, flush=True)


class _Table(View):
    """A line for each finished photo, and below the lines a table: the photo of each worker, and a progress bar."""

    def __init__(self, tally: Tally) -> None:
        self._tally = tally
        self._states: dict[str, str] = {}
        self.live: Live | None = None

    def update(self, job: PhotoJob, text: str) -> None:
        self._states[job.input] = text

    def show(self, record: Record, tally: Tally) -> None:
        self._states.pop(record.input, None)
        if self.live is not None:
            self.live.console.print(Text(describe(record), "red" if record.error else ""))

    def __rich__(self) -> Table:
        """Return the current table. A thread of rich calls this several times a second."""
        table = Table(box=None, expand=True, show_header=False, padding=(0, 1))
        table.add_column(ratio=1, no_wrap=True)
        table.add_column(ratio=2, no_wrap=True)
        for name, state in list(self._states.items()):
            table.add_row(Text(in_one_line(name)), Text(in_one_line(state)))
        table.add_row(ProgressBar(1.0, self._tally.share()), Text(self._tally.pace()))
        return table
