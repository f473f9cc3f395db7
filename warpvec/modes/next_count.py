"""The number of paths to try next for a goal: pure functions of the fits so far."""

from __future__ import annotations

import math
from collections.abc import Sequence

from warpvec.goals.goal import Goal
from warpvec.goals.search import Trial, fits, reaches

USED_MIN = 0.95
"""Smallest share of the allowed size that a file must use."""

USED_AIM = 0.98
"""Share of the allowed size that the search aims at. Bytes per path vary by 1 %."""

LEVEL_EXCESS = 0.25
"""Decibels above the wanted quality that are close enough."""

LEVEL_AIM = 0.1
"""Decibels above the wanted quality that the search aims at."""

BRACKET_RATIO = 1.04
"""The search stops when a hit has at most this many times the paths of a miss."""

BRACKET_SHARES = (0.3, 0.7)
"""Bounds of an interpolated try inside a bracket, as shares of its (logarithmic) width. If the tries so far have not
halved the bracket each, the PSNR has a step, as in flat art, and the next try is in the middle."""

SLOPE = 2.3
"""First guess of the decibels gained by doubling the paths. The Kodak photos gain 1.7 to 2.6."""

SLOPE_MIN, SLOPE_MAX = 0.8, 4.0
"""Bounds of an estimate of these from two fits, which may differ by little."""

STEP_UP_MAX, STEP_DOWN_MAX = 16.0, 4.0
"""Largest factors by which one step raises or, outside a bracket, lowers the number of paths: a fit of few paths says
little about many, and in flat art a quarter of the paths may lose 20 dB."""

PROBE_STEP_UP_MAX = 8.0
"""Largest factor by which the step from a probe to a target PSNR raises the number of paths. A whole fit may gain far
more than the probe's slope promises: an emoji with 64 paths has 34 dB after 100 iterations and 42 dB after 400. With 4,
kodim07 took a whole fit more to 28 dB, at 330 paths."""

AUTO_GAIN = 1.0
"""Without a number of paths, the search doubles them while that gains at least these decibels."""

AUTO_CURVES_MAX = 2048
"""Most paths of such a search; the file of a photo then has some 350 KB."""

AUTO_PSNR_MAX = 40.0
"""Decibels above this do not count as a gain of a doubling: no difference is visible any more. Flat art gains 1 to 2 dB
a doubling up to thousands of paths (a Noto emoji: 42 dB with 64 paths, 50 dB with 1,000)."""

AUTO_USED_MIN = 0.5
"""Share of the added paths that must be visible in the file for a doubling to pay."""

HOPELESS_GAIN = 0.2
"""If more paths gain less than these decibels per doubling, no number of paths reaches the target."""


def is_met(goal: Goal, trials: Sequence[Trial], curves_max: int) -> bool:
    """Return whether the last trial ends the search: it is within the bytes and no other count would be better."""
    last = trials[-1]
    if goal.level is not None and _is_bracket_tight(goal, trials):
        return True
    if not last.eligible or not fits(goal, last):
        return False
    if reaches(goal, last):
        return last.level <= (goal.level or 0.0) + LEVEL_EXCESS or last.curves <= 1
    if last.asked >= curves_max:
        return True
    return goal.limit is not None and last.size >= USED_MIN * goal.limit[1]


def is_hopeless(goal: Goal, trials: Sequence[Trial]) -> bool:
    """Return whether no trial reaches the target and the last one, with at least twice the paths, hardly helped."""
    if goal.level is None or len(trials) < 2 or any(reaches(goal, trial) for trial in trials):
        return False
    octaves = math.log2(trials[-1].asked / trials[-2].asked)
    return octaves >= 1.0 and trials[-1].level - trials[-2].level < HOPELESS_GAIN * octaves


def next_count(goal: Goal, trials: Sequence[Trial], curves_max: int) -> int:
    """Return the number of paths, at least one, that should meet ``goal`` after the ``trials`` so far."""
    wanted = [_count_for_size(goal, trials), _count_for_level(goal, trials)]
    count = min((n for n in wanted if n is not None), default=_base(trials[-1]))
    step = _base(trials[-1]) * STEP_UP_MAX
    return max(1, min(math.floor(min(count, step)), curves_max))


def narrows_bracket(goal: Goal, trials: Sequence[Trial], count: int) -> bool:
    """Return whether a fit with ``count`` paths lies between a miss of the target PSNR and a hit."""
    if goal.level is None:
        return False
    low, high = _bracket(goal.level, trials)
    return low is not None and high is not None and low.asked < count < high.asked


def is_worth_doubling(goal: Goal, trials: Sequence[Trial], curves_max: int) -> bool:
    """Return whether a search without a number of paths should try twice as many; not beyond the bytes of ``goal``."""
    last = trials[-1]
    has_room = 2 * last.asked <= min(curves_max, AUTO_CURVES_MAX) and last.psnr + AUTO_GAIN <= AUTO_PSNR_MAX
    return has_room and fits(goal, last) and _has_paid(trials)


def worthwhile_count(trials: Sequence[Trial]) -> int:
    """Return the last number of paths whose doubling paid, after the doublings that `is_worth_doubling` asked for."""
    return trials[-1 if _has_paid(trials) else -2].asked


def _base(trial: Trial) -> int:
    """Return the number of paths that the next step starts from: those asked for, as some will be invisible again.

    If more than half of them are invisible, as in a photo of one colour, more paths are not what the file lacks.
    """
    return min(trial.asked, 2 * max(trial.curves, 1))


def _has_paid(trials: Sequence[Trial]) -> bool:
    """Return whether the last doubling gained enough and used its paths. The first trial is no doubling; it pays."""
    if len(trials) < 2:
        return True
    before, after = trials[-2:]
    gain = min(after.psnr, AUTO_PSNR_MAX) - min(before.psnr, AUTO_PSNR_MAX)
    return gain >= AUTO_GAIN and after.curves - before.curves >= AUTO_USED_MIN * (after.asked - before.asked)


def _count_for_size(goal: Goal, trials: Sequence[Trial]) -> float | None:
    """Return the count for the allowed size; a file's size is nearly proportional to its paths."""
    if goal.limit is None:
        return None
    last = trials[-1]
    return _base(last) * USED_AIM * goal.limit[1] / last.size


def _count_for_level(goal: Goal, trials: Sequence[Trial]) -> float | None:
    """Return the count for the target: between a miss and a hit if there are both, else by the slope of the PSNR."""
    if goal.level is None:
        return None
    low, high = _bracket(goal.level, trials)
    if low is not None and high is not None:
        return _count_between(low, high, goal.level, bisect=_is_halving_late(goal.level, trials))
    last = high or trials[-1]
    octaves = (goal.level + LEVEL_AIM - last.level) / _slope([trial for trial in trials if trial.eligible])
    base = _base(last)
    step_up_max = STEP_UP_MAX if last.eligible else PROBE_STEP_UP_MAX
    count = base * 2.0 ** max(-math.log2(STEP_DOWN_MAX), min(octaves, math.log2(step_up_max)))
    # Take a step of at least one path: down if there is a hit and the last fit had more paths.
    return min(count, base - 1) if octaves < 0 or trials[-1].asked > last.asked else max(count, base + 1)


def _bracket(target: float, trials: Sequence[Trial]) -> tuple[Trial | None, Trial | None]:
    """Return the miss with the most paths and the hit with the fewest paths. A hit reaches the target.

    Misses with more paths than a hit are noise. The miss of a probe proves nothing, as a longer fit may reach the
    target. The hit of a probe counts, unless a longer fit with as many paths misses the target.
    """
    eligible_misses = [trial for trial in trials if trial.eligible and trial.level < target]
    refuted = {trial.asked for trial in eligible_misses}
    hits = (trial for trial in trials if trial.level >= target and (trial.eligible or trial.asked not in refuted))
    high = min(hits, key=lambda trial: (trial.asked, not trial.eligible), default=None)
    below = math.inf if high is None else high.asked
    misses = (trial for trial in eligible_misses if trial.asked < below)
    return max(misses, key=lambda trial: trial.asked, default=None), high


def _is_bracket_tight(goal: Goal, trials: Sequence[Trial]) -> bool:
    assert goal.level is not None
    low, high = _bracket(goal.level, trials)
    is_result = high is not None and high.eligible and fits(goal, high)
    return low is not None and high is not None and is_result and _is_tight(low, high)


def _is_tight(low: Trial, high: Trial) -> bool:
    return high.asked <= max(low.asked + 1, BRACKET_RATIO * low.asked)


def _is_halving_late(target: float, trials: Sequence[Trial]) -> bool:
    """Return whether the bracket is wider than if every try inside it had halved it, on a logarithmic scale."""
    brackets = (_bracket(target, trials[:count]) for count in range(1, len(trials) + 1))
    widths = [math.log(high.asked / low.asked) for low, high in brackets if low is not None and high is not None]
    return widths[-1] > widths[0] * 0.5 ** (len(widths) - 1)


def _count_between(low: Trial, high: Trial, target: float, *, bisect: bool) -> int:
    """Return a count between two trials, on a logarithmic scale: the middle, or by interpolation of the PSNR."""
    if _is_tight(low, high):  # `high` is a probe, or has too many bytes
        return high.asked
    lower, upper = BRACKET_SHARES
    interpolated = (target + LEVEL_AIM - low.level) / (high.level - low.level)
    share = 0.5 if bisect else max(lower, min(interpolated, upper))
    count = low.asked * (high.asked / low.asked) ** share
    return max(low.asked + 1, min(round(count), high.asked - 1))


def _slope(trials: Sequence[Trial]) -> float:
    """Return the decibels gained by a doubling, from the last two trials that differ enough to tell."""
    if len(trials) < 2:
        return SLOPE
    octaves = math.log2(trials[-1].asked / trials[-2].asked)
    gain = trials[-1].level - trials[-2].level
    if abs(octaves) < 0.05 or math.isnan(gain):  # NaN: neither has any error
        return SLOPE
    return min(max(gain / octaves, SLOPE_MIN), SLOPE_MAX)
