"""The search for a drawing that meets a goal, by the knob of a mode.

A mode has one knob: photos the number of paths, drawings of flat art the detail of their outlines. The knob makes
drawings one after another and sees the figures of those before; the search keeps the best drawing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

from torch import Tensor

from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.errors import InputError
from warpvec.files import text_bytes
from warpvec.goals.goal import Goal
from warpvec.goals.registry import QUANTITIES

FULL_SHARE = 0.95
"""Share of the largest size from which on a file uses it up: files use 97.5 to 100 % of it."""


class Trial(NamedTuple):
    """Figures of a drawing of a search.

    Attributes:
        asked: number of paths that the fit was asked for.
        curves: number of paths in the file, without invisible ones.
        bytes: bytes of the file, after gzip if the goal counts these.
        psnr: PSNR of the file in dB.
        figures: figure by the name of each quantity of the goal.
        size: figure of the quantity with a largest value; the bytes if there is none.
        level: figure of the quantity with a smallest value in decibels; the PSNR if there is none.
        eligible: whether the fit was long enough to be the result.
    """

    asked: int
    curves: int
    bytes: int
    psnr: float
    figures: dict[str, float]
    size: float
    level: float
    eligible: bool = True


class Attempt(NamedTuple):
    """A drawing that a knob has made; see `Trial.eligible`."""

    drawing: Drawing
    eligible: bool = True


class Knob(Protocol):
    """The knob of a mode.

    Attributes:
        cuts_smallest: if no drawing is within the largest value, whether to remove paths from the smallest one. The
            other choice is the best one.
        refusal: why paths must not be removed, as rule and remedy of an error; None if they may.
    """

    cuts_smallest: bool
    refusal: tuple[str, str] | None

    def attempts(self, trials: Sequence[Trial]) -> Iterator[Attempt]:
        """Make drawings until one meets the goal or no other would. ``trials`` has the figures of those so far."""


def meet(goal: Goal, knob: Knob) -> Drawing:
    """Return the drawing of ``knob`` that meets ``goal`` or comes nearest, with the facts about the search.

    It never exceeds the largest value of the goal.

    Raises:
        InputError: not even one path fits into the largest value.
    """
    drawings: list[Drawing] = []
    trials: list[Trial] = []
    for drawing, eligible in knob.attempts(trials):
        drawings.append(drawing)
        trials.append(trial_of(drawing, goal)._replace(eligible=eligible))
    best = _chosen(goal, knob, trials)
    drawing, trial = _cut(drawings[best], trials[best], goal, knob, trials)
    return replace(drawing, goal_facts=make_facts(goal, trials, trial))


def with_path_limit(drawing: Drawing, most: int) -> Drawing:
    """Return the ``drawing`` of a search; its facts have ``most`` if more paths would have come closer to the goal."""
    facts = drawing.goal_facts
    assert facts is not None
    has_room = facts["max_bytes"] is None or facts["bytes"] < FULL_SHARE * facts["max_bytes"]
    is_wanted = bool(facts["max_bytes"]) if facts["met"] else True
    is_limit = drawing.encoding.settings.curves >= most and has_room and is_wanted
    return replace(drawing, goal_facts={**facts, "curves_max": most if is_limit else None})


def check_possible(goal: Goal, encoding: Encoding) -> None:
    """Check, before the work, that a file of one path fits into the largest value of ``goal``.

    Raises:
        InputError: it does not.
    """
    if goal.limit is None or not goal.limit[0].is_of_text:
        return
    quantity, most = goal.limit
    least = text_bytes(encoding.least_text(), gzip=goal.gzip)
    if least > most:
        raise InputError(quantity.name, "is too small for one path", f"{most:g}", f"give more than {least}")


def within_limit(drawing: Drawing, goal: Goal, kept: Tensor | None = None) -> Drawing:
    """Return ``drawing`` without the paths of lowest removal cost, so many that it is within the largest value.

    If one path, or the paths that stay, are larger, only these are left.

    Args:
        drawing: a fitted drawing.
        goal: what its file must keep to.
        kept: paths of the fitted scene [N] (bool) that stay; None for none.
    """
    free = len(drawing.fitted) - (0 if kept is None else int(kept.sum()))
    trial = trial_of(drawing, goal)
    while goal.limit is not None and not fits(goal, trial) and min(free, trial.curves - 1) > 0:
        count = min(_excess(trial, goal.limit[1]), free)
        rows = drawing.costly_rows(count, kept)
        drawing = drawing.with_fitted(drawing.fitted.select(rows))
        kept, free, trial = None if kept is None else kept[rows], free - count, trial_of(drawing, goal)
    return drawing


def trial_of(drawing: Drawing, goal: Goal) -> Trial:
    """Return the figures of ``drawing``."""
    figures = {name: QUANTITIES[name].measure(drawing, goal.gzip) for name in goal.bounds}
    size, psnr = text_bytes(drawing.text, gzip=goal.gzip), drawing.psnr
    asked, count = drawing.encoding.settings.curves, len(drawing.scene)
    limited = size if goal.limit is None else figures[goal.limit[0].name]
    level = psnr if goal.quality is None else goal.quality[0].decibels(figures[goal.quality[0].name])
    return Trial(asked, count, size, psnr, figures, limited, level)


def fits(goal: Goal, trial: Trial) -> bool:
    """Return whether ``trial`` is within the largest value of ``goal``."""
    return goal.limit is None or trial.size <= goal.limit[1]


def reaches(goal: Goal, trial: Trial) -> bool:
    """Return whether ``trial`` has the smallest value of ``goal``; False without one."""
    return goal.level is not None and trial.level >= goal.level


def best_trial(goal: Goal, trials: Sequence[Trial]) -> int:
    """Return the index of the trial to keep.

    Eligible trials come before others, trials within the largest value before larger ones, and trials that reach the
    smallest value before worse ones. Of trials that reach it, the smallest file wins; of others, the highest quality.
    """

    def rank(index: int) -> tuple[bool, bool, bool, float, float]:
        trial = trials[index]
        has_reached = reaches(goal, trial)
        level = 0.0 if has_reached else round(trial.level, 2)
        return trial.eligible, fits(goal, trial), has_reached, level, -trial.size

    return max(range(len(trials)), key=rank)


def make_facts(goal: Goal, trials: Sequence[Trial], result: Trial) -> dict[str, Any]:
    """Return the goal, whether the file meets it, and the trials, as plain values for JSON."""
    always = {"bytes", "psnr"}  # facts of every trial
    others = [each for name, each in QUANTITIES.items() if name in goal.bounds and each.figure not in always]
    return {
        **{name: goal.bounds.get(name) for name in QUANTITIES},
        "gzip": goal.gzip,
        "auto": goal.auto,
        "met": goal.level is None or reaches(goal, result),
        "bytes": result.bytes,
        **{each.figure: result.figures[each.name] for each in others},
        "trials": [
            {
                "curves": trial.curves,
                "bytes": trial.bytes,
                "psnr": trial.psnr,
                **{each.figure: trial.figures[each.name] for each in others},
            }
            for trial in trials
        ],
    }


def _chosen(goal: Goal, knob: Knob, trials: Sequence[Trial]) -> int:
    """Return the index of the drawing to keep, or to remove paths from."""
    if knob.cuts_smallest and not any(fits(goal, trial) for trial in trials):
        return min(range(len(trials)), key=lambda index: trials[index].size)
    return best_trial(goal, trials)


def _cut(drawing: Drawing, trial: Trial, goal: Goal, knob: Knob, trials: list[Trial]) -> tuple[Drawing, Trial]:
    """Remove paths from ``drawing`` until it is within the largest value; return it with its trial.

    The figures of every drawing on the way are added to ``trials``.
    """
    if goal.limit is None:
        return drawing, trial
    quantity, most = goal.limit
    if not fits(goal, trial) and knob.refusal is not None:
        rule, remedy = knob.refusal
        raise InputError(quantity.name, rule, str(most), f"give at least {trial.size}, {remedy}")
    while not fits(goal, trial):
        if trial.curves <= 1:
            raise InputError(quantity.name, "is too small for one path", str(most), f"give at least {trial.size}")
        drawing = drawing.without(_excess(trial, most))
        trial = trial_of(drawing, goal)
        trials.append(trial)
    return drawing, trial


def _excess(trial: Trial, most: float) -> int:
    """Return the number of paths to remove, at least one, so that the size is about ``most``; one path stays."""
    return min(max(1, round(trial.curves * (trial.size - most) / trial.size)), trial.curves - 1)
