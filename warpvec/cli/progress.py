"""Progress of a fit: a bar on a terminal, otherwise a line every few seconds."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from warpvec.watch.progress import OnProgress, Progress, Regularly, Show

BAR_SECONDS = 0.2
"""Time between two updates of the bar. It looks alive and takes less than 1 % of a core."""

LINE_SECONDS = 5.0
"""Time between two lines: short enough to see progress, long enough to keep the log of a long fit readable."""


@contextmanager
def show_progress(stream: TextIO | None, *, quiet: bool = False) -> Iterator[OnProgress]:
    """Yield a callback for a fit that shows its progress on ``stream``, or nothing if ``quiet`` or without a stream."""
    if quiet or stream is None:
        yield lambda progress: None
    elif stream.isatty():
        with _bar(stream) as show:
            yield Regularly(show, BAR_SECONDS)
    else:
        yield Regularly(lambda _, text: print(text, file=stream, flush=True), LINE_SECONDS)


@contextmanager
def _bar(stream: TextIO) -> Iterator[Show]:
    """Yield a function that updates a progress bar."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    def show(progress: Progress, text: str) -> None:
        bar.update(task, completed=progress.iteration, total=progress.iteration_count, description=text)
        bar.refresh()

    # The callback draws the bar. Rich's own thread would compete with the threads of the kernels.
    columns = BarColumn(bar_width=None), TextColumn("{task.description}")
    with Bar(*columns, console=Console(file=stream), auto_refresh=False, expand=True) as bar:
        task = bar.add_task("starting (a first run compiles its kernels)", total=None)
        yield show
