"""The watch over a run: progress, stop, clock and history.

A run makes one `Watch`. Each fit of the run takes a `Part` of it, which counts the iterations of the fit.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from warpvec.geometry.scene import Scene
from warpvec.watch.interrupt import CtrlC, Listener
from warpvec.watch.progress import HistoryEntry, OnProgress, Progress, history_entry

SECONDS_LEAST = 1e-3
"""Shortest time budget of a part in seconds. A part without any time left still takes one iteration."""


class RunFacts(NamedTuple):
    """Figures of a whole run.

    Attributes:
        history: records along the run: iteration, curves, psnr (dB) and seconds since its start.
        iterations: number of iterations of all parts.
        seconds: time since the start.
        interrupted: whether the user has asked for the end of the run, even if the fit was over by then.
    """

    history: list[HistoryEntry]
    iterations: int
    seconds: float
    interrupted: bool


@dataclass(frozen=True)
class FitResult:
    """The result of one fit: the scene in pixels of the fitted image, on the CPU, and the figures of its part."""

    scene: Scene
    history: list[HistoryEntry]
    iterations: int
    seconds: float
    interrupted: bool
    device: str


class Watch:
    """The watch over one run. While it is open as a context, it defers Ctrl-C.

    Args:
        time_budget: longest time of the run in seconds; None for any time.

    Attributes:
        on_progress: called after every iteration; None for nothing.
        listener: receives the wish to end the run; by default Ctrl-C, if the main thread opens the watch.
        on_stage: called with words for what is done now, such as "looking for shadows"; None for nothing.
    """

    def __init__(
        self,
        on_progress: OnProgress | None = None,
        time_budget: float | None = None,
        listener: Listener | None = None,
    ) -> None:
        self.on_progress, self._time_budget = on_progress, time_budget
        self.on_stage: Callable[[str], None] | None = None
        self.listener: Listener = CtrlC() if listener is None else listener
        self._open_count = 0
        self._start = time.perf_counter()
        self._parts: list[Part] = []

    def __enter__(self) -> Watch:
        self._open_count += 1
        if isinstance(self.listener, CtrlC) and self._open_count == 1:
            self.listener.open()
        return self

    def __exit__(self, *error: object) -> None:
        self._open_count -= 1
        if isinstance(self.listener, CtrlC) and self._open_count == 0:
            self.listener.close()

    # Stop and clock

    def is_stopped(self) -> bool:
        """Return whether the user has asked for the best result so far."""
        return self.listener.has_signal()

    def is_over(self) -> bool:
        """Return whether the run is to end: the user asks for it, or the time is up."""
        return self.is_stopped() or self.seconds_left() <= 0.0

    def has_time_for(self, share: float) -> bool:
        """Return whether this share of the time budget is left. There is always time without a budget."""
        return self._time_budget is None or self.seconds_left() >= share * self._time_budget

    def ahead(self, share: float) -> Watch:
        """Return a watch whose time is up when this share of the time budget is left for what comes later."""
        if self._time_budget is None:
            return self
        earlier = Watch(time_budget=(1.0 - share) * self._time_budget, listener=self.listener)
        earlier._start = self._start
        return earlier

    def seconds(self) -> float:
        """Return the seconds since the run began."""
        return time.perf_counter() - self._start

    def seconds_left(self) -> float:
        """Return the seconds until the time is up; infinity without a time budget."""
        return math.inf if self._time_budget is None else self._time_budget - self.seconds()

    def tell(self, words: str) -> None:
        """Say what is done from now on, which may take a while without progress."""
        if self.on_stage is not None:
            self.on_stage(words)

    # Parts and history

    @property
    def iterations(self) -> int:
        """Number of iterations of all parts so far."""
        return sum(part.iterations for part in self._parts)

    def part(self, *, planned: int | None = None, share: float = 1.0, left: float = 0.0) -> Part:
        """Begin a part of the run.

        Args:
            planned: number of iterations of the run as far as it is planned. The part then shows its iterations as a
                continuation of the parts before. None: it shows its own numbers.
            share: largest share of the whole time budget that the part may take.
            left: share of it that must be left for what comes later.
        """
        part = Part(self, self._part_budget(share, left), self.iterations, planned)
        self._parts.append(part)
        return part

    def side_part(self) -> Part:
        """Begin a fit that only prepares a choice: it shows no progress, and leaves the history as it is."""
        return Part(self, self._part_budget(1.0), 0, None, is_shown=False)

    def resume(self, seconds: float) -> None:
        """Continue as if the run had already taken ``seconds``."""
        self._start = time.perf_counter() - seconds

    def facts(self) -> RunFacts:
        """Return the figures of the run so far."""
        history = [entry for part in self._parts for entry in part.history_in_run()]
        interrupted = self.is_stopped() or any(part.interrupted for part in self._parts)
        return RunFacts(history, self.iterations, self.seconds(), interrupted)

    def _part_budget(self, share: float, left: float = 0.0) -> float | None:
        if self._time_budget is None:
            return None
        return max(min(self.seconds_left() - left * self._time_budget, share * self._time_budget), SECONDS_LEAST)


class Part:
    """One fit of a run. Iterations count from 1, and seconds from the start of the fit.

    Attributes:
        time_budget: longest time of the part in seconds; None for any time.
        iterations: number of the last iteration.
        history: records along the part.
        interrupted: whether the user ended the part early.
    """

    def __init__(
        self,
        watch: Watch,
        time_budget: float | None,
        iterations_before: int,
        planned: int | None,
        is_shown: bool = True,
    ) -> None:
        self._watch, self._is_shown = watch, is_shown
        self._iterations_before, self._planned = iterations_before, planned
        self._begin = watch.seconds()
        self.time_budget = time_budget
        self.iterations = 0
        self.history: list[HistoryEntry] = []
        self.interrupted = False

    def __enter__(self) -> Part:
        self._watch.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._watch.__exit__(*error)

    def is_stopped(self) -> bool:
        """Return whether the user has asked for the best result so far."""
        return self._watch.is_stopped()

    def is_late(self) -> bool:
        """Return whether the time of the part is up."""
        return self.time_budget is not None and self.seconds() > self.time_budget

    def seconds(self) -> float:
        """Return the seconds since the part began."""
        return self._watch.seconds() - self._begin

    def resume(self, seconds: float, iterations: int, history: list[HistoryEntry]) -> None:
        """Continue a saved fit, which had taken ``seconds`` and ``iterations``."""
        self._watch.resume(self._begin + seconds)
        self.iterations, self.history = iterations, list(history)

    def report(self, progress: Progress, *, is_entry: bool = False) -> None:
        """Show an iteration, and add it to the history if it ``is_entry``. The iteration has a result worth saving."""
        self.iterations = progress.iteration
        self._watch.listener.hold()
        if is_entry:
            self.history.append(history_entry(progress))
        if not self._is_shown or self._watch.on_progress is None:
            return
        if self._planned is not None:
            number, seconds = self._iterations_before + progress.iteration, self._begin + progress.seconds
            progress = replace(progress, iteration=number, iteration_count=self._planned, seconds=seconds)
        self._watch.on_progress(progress)

    def result(self, scene: Scene, device: str) -> FitResult:
        """Return ``scene`` as the result of the part, whose fit ran on ``device``."""
        return FitResult(scene.cpu(), self.history, self.iterations, self.seconds(), self.interrupted, device)

    def history_in_run(self) -> list[HistoryEntry]:
        """Return the history with the iterations and seconds of the whole run."""
        before = self._iterations_before
        return [
            {**entry, "iteration": before + entry["iteration"], "seconds": self._begin + entry["seconds"]}
            for entry in self.history
        ]


UNWATCHED = Watch()
"""The watch over work without progress, limit of time or listener. Never open it: each run makes its own."""
