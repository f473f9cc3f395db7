"""How long the stages of drawings take here, so that the page can say how long a silent one may."""

from __future__ import annotations

import time
from collections import defaultdict, deque
from collections.abc import Callable
from typing import Any

MEASURED = {"looking for shadows": 21.0, "joining curves": 11.0, "simplifying outlines": 4.0}
"""Stage -> the longest that it took of ten drawings of 96 to 800 px, in seconds on two cores (2026-11-28)."""

_KEPT = 8
"""Times of a stage that are kept."""


class StageTimes:
    """The times of the last drawings.

    Args:
        clock: returns the present second.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._running = clock, ("", 0.0)
        self._times: dict[str, deque[float]] = defaultdict(lambda: deque(maxlen=_KEPT))

    def begin(self, words: str) -> dict[str, Any]:
        """End the stage before, begin one, and return its facts: "words" and "seconds".

        The seconds are the longest of its last times, or what was measured elsewhere. They are None for a stage that is
        not known.
        """
        self.end()
        self._running = (words, self._clock())
        return {"words": words, "seconds": max(self._times[words], default=MEASURED.get(words))}

    def end(self) -> None:
        """Note that the drawing is done."""
        words, start = self._running
        if words:
            self._times[words].append(self._clock() - start)
        self._running = ("", 0.0)
