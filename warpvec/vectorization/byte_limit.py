"""Remove paths of a result until its file has no more bytes than its goal allows."""

from __future__ import annotations

from warpvec.errors import InputError
from warpvec.vectorization.goal import Goal, Trial
from warpvec.vectorization.result import Result


def cut_to_bytes(result: Result, goal: Goal, trials: list[Trial], trial: Trial) -> tuple[Result, Trial]:
    """Remove paths from ``result``, whose file is ``trial``, until it is within the bytes of ``goal``; return both.

    Every file on the way is added to ``trials``.

    Raises:
        InputError: not even one path fits into the bytes.
    """
    limit = goal.max_bytes
    while limit is not None and trial.bytes > limit:
        if trial.curves <= 1:
            remedy = f"give at least {trial.bytes}, the size of this file with one path"
            raise InputError("max_bytes", "must be enough for a path", str(limit), remedy)
        excess = max(1, round(trial.curves * (trial.bytes - limit) / trial.bytes))
        result = result.without(min(excess, trial.curves - 1))
        trial = result.trial(goal)
        trials.append(trial)
    return result, trial
