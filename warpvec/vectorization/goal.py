"""What is asked of a file (bytes, decibels) and how many paths that will take: pure functions of the fits so far."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from warpvec.checks import as_float, check_count, check_flag, show
from warpvec.errors import InputError

SKETCH_CURVES = 64
"""Paths of the first, short fit, from which the number of paths is guessed: it takes a second."""

SHORT_SHARE = 0.25
"""Iterations of a sketch or a correction over those of a fit."""

CORRECTION_RATE = 0.4
"""Learning rates of a correction over those of a fit: paths that stand well must not be thrown. 288 paths grown to 320
in 500 iterations (kodim07): 28.04 dB with 0.3, 27.77 with 1; from nothing in 2000: 27.95."""

CURVES_MAX = 16_384
"""Most paths that a goal is followed to: beyond, a file is larger than the photo as a JPEG of equal quality."""

USED_MIN, USED_AIM = 0.95, 0.98
"""A budget of bytes counts as used from the first share on; the second is aimed at. What a path takes varies by 1 %."""

PSNR_EXCESS, PSNR_AIM = 0.25, 0.1
"""Decibels above the target that are as good as it, and that are aimed at."""

SLOPE, SLOPE_MIN, SLOPE_MAX = 2.3, 0.8, 4.0
"""Decibels that a doubling of the paths gains: to begin with (photos of the Kodak set: 1.7 to 2.6), and the bounds of
what two fits that differ by little may claim."""

LEAP_MAX = 16.0
"""Most by which one guess multiplies the paths: a short fit of few paths says little of many."""

AUTO_GAIN, AUTO_CURVES_MAX = 1.0, 2048
"""With the curves left to us, they are doubled until that gains less than these decibels, or to this many, where the
file of a photo has some 350 KB."""

VAIN_GAIN = 0.2
"""Where more paths gain less than these decibels for each doubling, no number of them reaches the target."""

_SIZE = re.compile(r"([0-9]+(?:\.[0-9]*)?)\s*(k|m)?b?", re.IGNORECASE)
_UNITS = {"": 1, "k": 1_000, "m": 1_000_000}


@dataclass(frozen=True, kw_only=True)
class Goal:
    """What the file must be; the number of paths follows from it.

    Raises:
        InputError: a field is of the wrong type or out of its range.
    """

    max_bytes: int | None = None
    """The file has at most these bytes, and as good as uses them."""
    gzip: bool = False
    """Bytes are counted after gzip, as web servers send them."""
    target_psnr: float | None = None
    """Decibels of the file as resvg draws it."""
    auto: bool = False
    """As many paths as the photo rewards."""

    def __post_init__(self) -> None:
        check_flag("gzip", self.gzip)
        if self.max_bytes is not None:
            object.__setattr__(self, "max_bytes", check_count("max_bytes", self.max_bytes, 1))
        if self.target_psnr is not None:
            object.__setattr__(self, "target_psnr", _decibels(self.target_psnr))

    def __bool__(self) -> bool:
        return self.auto or self.max_bytes is not None or self.target_psnr is not None


def with_curves(settings: dict[str, Any], curves: int | str | None, goal: Goal) -> dict[str, Any]:
    """``settings`` with the number of paths that ``curves`` says: itself, or the most that a goal may take."""
    if isinstance(curves, str) and curves != "auto":
        raise InputError(f"curves must be a whole number or auto, got {curves!r}; give one of these")
    if curves is None or curves == "auto":
        return {**settings, "curves": CURVES_MAX} if goal else settings
    return {**settings, "curves": curves}


class Trial(NamedTuple):
    """One fit on the way: the bytes of its file as the goal counts them, and its PSNR in dB by resvg."""

    asked: int
    """Paths that were asked for."""
    curves: int
    """Paths in the file; invisible ones are gone."""
    bytes: int
    psnr: float
    settled: bool = True
    """Whether the fit was long enough to be the result."""


def parse_size(text: str) -> int:
    """Bytes of "50000", "50k", "1.5M": k is 1000, as in the sizes that a web page is budgeted in.

    Raises:
        InputError: not such a size.
    """
    match = _SIZE.fullmatch(text.strip())
    count = 0.0 if match is None else float(match[1]) * _UNITS[(match[2] or "").lower()]
    if not 1.0 <= count < math.inf:
        raise InputError(f"max_bytes must be a size such as 50000, 80k or 1.5M, got {text!r}; give one of at least 1")
    return round(count)


def is_met(goal: Goal, trial: Trial, curves_max: int) -> bool:
    """Whether a trial is a result: within the bytes, and no better one is to be had by more or fewer paths."""
    if not trial.settled or not _fits(goal, trial):
        return False
    if goal.target_psnr is not None and trial.psnr >= goal.target_psnr:
        return trial.psnr <= goal.target_psnr + PSNR_EXCESS or trial.curves <= 1
    if trial.asked >= curves_max:
        return True
    return goal.max_bytes is not None and trial.bytes >= USED_MIN * goal.max_bytes


def is_in_vain(goal: Goal, trials: Sequence[Trial]) -> bool:
    """Whether the target is missed, and the last trial, with more paths than the one before, was no step towards it."""
    if goal.target_psnr is None or len(trials) < 2 or trials[-1].psnr >= goal.target_psnr:
        return False
    octaves = math.log2(trials[-1].asked / trials[-2].asked)
    return octaves >= 1.0 and trials[-1].psnr - trials[-2].psnr < VAIN_GAIN * octaves


def best_trial(goal: Goal, trials: Sequence[Trial]) -> int:
    """Which of the trials is the result: among settled ones, if there are any, and among those within the bytes, the
    smallest file that reaches the target, or else the best."""

    def rank(index: int) -> tuple[bool, bool, bool, float, float]:
        trial = trials[index]
        reached = goal.target_psnr is not None and trial.psnr >= goal.target_psnr
        return trial.settled, _fits(goal, trial), reached, 0.0 if reached else round(trial.psnr, 2), -trial.bytes

    return max(range(len(trials)), key=rank)


def next_count(goal: Goal, trials: Sequence[Trial], curves_max: int) -> int:
    """The number of paths that should meet ``goal``, from the ``trials`` so far, at least one."""
    wanted = [_count_for_bytes(goal, trials), _count_for_psnr(goal, trials)]
    count = min((n for n in wanted if n is not None), default=_base(trials[-1]))
    leap = _base(trials[-1]) * LEAP_MAX
    return max(1, min(math.floor(min(count, leap)), curves_max))


def is_worth_doubling(trials: Sequence[Trial], curves_max: int) -> bool:
    """Whether, with the number of paths left to us, twice as many should be tried."""
    return 2 * trials[-1].asked <= min(curves_max, AUTO_CURVES_MAX) and _has_paid(trials)


def worthwhile_count(trials: Sequence[Trial]) -> int:
    """The last number of paths whose doubling paid, after the doublings `is_worth_doubling` asked for."""
    return trials[-1 if _has_paid(trials) else -2].asked


def facts_of(goal: Goal, trials: Sequence[Trial], result: Trial) -> dict[str, Any]:
    """What was asked, and what became of it, as plain values."""
    missed = goal.target_psnr is not None and result.psnr < goal.target_psnr
    return {
        "max_bytes": goal.max_bytes,
        "gzip": goal.gzip,
        "target_psnr": goal.target_psnr,
        "auto": goal.auto,
        "met": not missed,
        "bytes": result.bytes,
        "trials": [{"curves": trial.curves, "bytes": trial.bytes, "psnr": trial.psnr} for trial in trials],
    }


def describe(facts: dict[str, Any]) -> str:
    """`facts_of` a goal in a line."""
    parts = []
    if facts["max_bytes"] is not None:
        kind = "gzipped bytes" if facts["gzip"] else "bytes"
        parts.append(f"{facts['bytes']:,} of {facts['max_bytes']:,} {kind}")
    if facts["target_psnr"] is not None:
        parts.append(f"{facts['target_psnr']:g} dB {'reached' if facts['met'] else 'not reached'}")
    counts = ", ".join(str(trial["curves"]) for trial in facts["trials"])
    return f"asked for: {'; '.join(parts) or 'as many curves as pay'}; fitted with {counts} curves"


def _decibels(value: Any) -> float:
    number = as_float(value)
    if not 0 < number <= 100:
        raise InputError(f"target_psnr must lie above 0 and not above 100, got {show(value)}; photos reach 25 to 35")
    return number


def _fits(goal: Goal, trial: Trial) -> bool:
    return goal.max_bytes is None or trial.bytes <= goal.max_bytes


def _base(trial: Trial) -> int:
    """The paths that were asked for, as the next count is of such: a share of them will be invisible again.

    Where more than half are, as in a photo of one colour, it is not for lack of paths that the goal is missed.
    """
    return min(trial.asked, 2 * max(trial.curves, 1))


def _has_paid(trials: Sequence[Trial]) -> bool:
    """Whether the last doubling gained enough; the first trial is none, and pays."""
    return len(trials) < 2 or trials[-1].psnr - trials[-2].psnr >= AUTO_GAIN


def _count_for_bytes(goal: Goal, trials: Sequence[Trial]) -> float | None:
    """A file's bytes are as good as proportional to its paths."""
    if goal.max_bytes is None:
        return None
    last = trials[-1]
    return _base(last) * USED_AIM * goal.max_bytes / last.bytes


def _count_for_psnr(goal: Goal, trials: Sequence[Trial]) -> float | None:
    """Decibels are as good as linear in the logarithm of the paths."""
    if goal.target_psnr is None:
        return None
    last = trials[-1]
    octaves = (goal.target_psnr + PSNR_AIM - last.psnr) / _slope([trial for trial in trials if trial.settled])
    base = _base(last)
    count = base * 2.0 ** max(-20.0, min(octaves, 20.0))
    # A step of less than a path is still a step.
    return min(count, base - 1) if octaves < 0 else max(count, base + 1)


def _slope(trials: Sequence[Trial]) -> float:
    """Decibels a doubling, from the last two trials that differ enough to tell."""
    if len(trials) < 2:
        return SLOPE
    octaves = math.log2(trials[-1].asked / trials[-2].asked)
    gain = trials[-1].psnr - trials[-2].psnr
    if abs(octaves) < 0.05 or math.isnan(gain):  # both without any error
        return SLOPE
    return min(max(gain / octaves, SLOPE_MIN), SLOPE_MAX)
