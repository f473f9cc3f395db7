"""Run `warpvec run` with the given arguments, then print one line of JSON with its times, memory and pairs.

Benchmarks run this script in a process of its own. It is the command itself, except that its fit is called through a
wrapper that records the time of every iteration.
"""

from __future__ import annotations

import json
import resource
import statistics
import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any


class TimedFit:
    """Wrapper of `warpvec.fit.loop.fit` that records seconds since the start, and numbers of paths, as it goes."""

    def __init__(self, fit: Callable[..., Any]) -> None:
        self._fit = fit
        self.first_iteration: tuple[float, float] | None = None
        self.laps: list[tuple[float, int]] = []

    def __call__(self, target: Any, config: Any, part: Any, **more: Any) -> Any:
        """Fit as `warpvec.fit.loop.fit` does, and note the time of the first iteration."""
        report = part.report

        def note(progress: Any, **kinds: Any) -> None:
            if self.first_iteration is None:
                self.first_iteration = time.time(), time.process_time()
            self.laps.append((progress.seconds, progress.curve_count))
            report(progress, **kinds)

        part.report = note
        self.fitted = self._fit(target, config, part, **more)
        self.height, self.width, self.threads = *target.shape[:2], config.threads
        return self.fitted

    def describe(self) -> dict[str, Any]:
        """Return size and seconds of the fit, and the median seconds of a step and of a change of the population."""
        gaps = [(after[0] - before[0], before[1] != after[1]) for before, after in pairwise(self.laps)]
        full = [seconds for seconds, _ in gaps[len(gaps) // 2 :]]
        step = statistics.median(full) if full else None
        # In a lap that adds paths, a change of the population precedes the step.
        changes = [seconds for seconds, changed in gaps if changed]
        change = max(0.0, statistics.median(changes) - step) if step is not None and changes else 0.0
        first, first_cpu = self.first_iteration or (None, None)
        return {
            "first_iteration": first,
            "first_cpu": first_cpu,
            "fit_seconds": self.fitted.seconds,
            "step": step,
            "change": change,
            "fitted": [self.width, self.height],
        }


def peak_bytes() -> int:
    """Return the peak resident memory of this process in bytes."""
    try:
        # Not ru_maxrss: on Linux it starts at the memory of the parent when it started this process.
        status = Path("/proc/self/status").read_text()
        return 1024 * int(status.split("VmHWM:")[1].split()[0])
    except (OSError, IndexError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # in bytes on macOS (getrusage(2))


def count_pairs(timed: TimedFit) -> dict[str, int]:
    """Count the (path, tile) pairs of the fitted scene, and those that an edge crosses."""
    from warpvec.rendering.exact import ExactRenderer

    scene = timed.fitted.scene
    renderer = ExactRenderer(timed.height, timed.width, threads=timed.threads)
    renderer.render(scene)
    return {"pairs": renderer._binning.pair_count, "partial_pairs": renderer._binning.slot_count}


def main() -> None:
    """Run the command, then report; exit with the code of the command."""
    from warpvec.cli import main as cli
    from warpvec.modes import photo as photo_mode

    timed = TimedFit(photo_mode.fit)
    photo_mode.fit = timed  # type: ignore[assignment]
    try:
        cli.main(["run", *sys.argv[1:]])
    except SystemExit as stop:
        if stop.code:
            raise
    seen = {**timed.describe(), "peak_bytes": peak_bytes()}
    # The peak is read first, because counting the pairs renders once more.
    print(json.dumps({**seen, **count_pairs(timed)}))


if __name__ == "__main__":
    main()
