"""What a user sees while a fit runs: a bar on a terminal, a line now and then in a log."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar

from warpvec.fit.progress import Pace, Progress

Show = Callable[[Progress], None]

BAR_SECONDS = 0.2
"""Between two drawings of the bar: it looks alive, and costs under 1 % of a core."""

LINE_SECONDS = 5.0
"""Between two lines: a log of the longest fits stays readable, a watcher is not left in doubt."""


@contextmanager
def show_progress(stream: TextIO, *, quiet: bool = False) -> Iterator[Show]:
    """A callback for a fit that keeps the user of ``stream`` informed until the context ends."""
    if quiet:
        yield _show_nothing
    elif stream.isatty():
        with _bar(stream) as show:
            yield show
    else:
        yield _Lines(stream)


def _show_nothing(progress: Progress) -> None:
    del progress


@contextmanager
def _bar(stream: TextIO) -> Iterator[Show]:
    # Drawn by the callback, not by rich's own thread: a second thread would take turns with the kernels' threads.
    bar = Bar(
        BarColumn(bar_width=None),
        TextColumn("{task.description}"),
        console=Console(file=stream),
        auto_refresh=False,
        expand=True,
    )
    with bar:
        yield _BarUpdate(bar)


class _Ticker:
    """Tells at most once in ``interval`` seconds that it is time; the first time at once."""

    def __init__(self, interval: float) -> None:
        self._interval = interval
        self._due = -float("inf")

    def is_due(self) -> bool:
        now = time.monotonic()
        if now < self._due:
            return False
        self._due = now + self._interval
        return True


class _BarUpdate:
    def __init__(self, bar: Bar) -> None:
        self._bar = bar
        self._task = bar.add_task("starting (a first run compiles its kernels)", total=None)
        self._ticker = _Ticker(BAR_SECONDS)
        self._pace = Pace()

    def __call__(self, progress: Progress) -> None:
        self._pace.see(progress)
        if not self._ticker.is_due() and progress.iteration < progress.iteration_count:
            return
        self._bar.update(
            self._task,
            completed=progress.iteration,
            total=progress.iteration_count,
            description=self._pace.describe(progress),
        )
        self._bar.refresh()


class _Lines:
    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._ticker = _Ticker(LINE_SECONDS)
        self._pace = Pace()

    def __call__(self, progress: Progress) -> None:
        self._pace.see(progress)
        if self._ticker.is_due() or progress.iteration == progress.iteration_count:
            print(self._pace.describe(progress), file=self._stream, flush=True)
