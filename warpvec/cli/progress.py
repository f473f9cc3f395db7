"""Progress of a fit: a bar on a terminal, otherwise a line every few seconds."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

from warpvec.watch.progress import OnProgress, Pace, Progress

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

BAR_SECONDS = 0.2
"""Time between two updates of the bar. It looks alive and takes less than 1 % of a core."""

LINE_SECONDS = 5.0
"""Time between two lines: short enough to see progress, long enough to keep the log of a long fit readable."""


@contextmanager
def show_progress(stream: TextIO | None, *, quiet: bool = False) -> Iterator[OnProgress]:
    """Yield a callback for a fit that shows its progress on ``stream``, or nothing if ``quiet`` or without a stream."""
    if quiet or stream is None:
        yield _show_nothing
    elif stream.isatty():
        with _bar(stream) as show:
            yield show
    else:
        yield _Lines(stream)


def _show_nothing(progress: Progress) -> None:
    del progress


@contextmanager
def _bar(stream: TextIO) -> Iterator[OnProgress]:
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    # The callback draws the bar. Rich's own thread would compete with the threads of the kernels.
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
    """A timer that is due at once and then every ``interval`` seconds."""

    def __init__(self, interval: float) -> None:
        self._interval = interval
        self._due = -float("inf")

    def is_due(self) -> bool:
        """Return whether the time has come, and if so start the next interval."""
        now = time.monotonic()
        if now < self._due:
            return False
        self._due = now + self._interval
        return True


class _BarUpdate:
    """Callback that updates a progress bar."""

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
    """Callback that prints lines."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._ticker = _Ticker(LINE_SECONDS)
        self._pace = Pace()

    def __call__(self, progress: Progress) -> None:
        self._pace.see(progress)
        if self._ticker.is_due() or progress.iteration == progress.iteration_count:
            print(self._pace.describe(progress), file=self._stream, flush=True)
