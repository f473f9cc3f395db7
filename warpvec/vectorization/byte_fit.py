"""One fit for a file of a given size: its number of paths follows the bytes while it runs."""

from __future__ import annotations

from dataclasses import replace

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import MINIFIED
from warpvec.config.rules import MAX_COUNT
from warpvec.fit.byte_budget import ByteBudget
from warpvec.vectorization.byte_limit import cut_to_bytes
from warpvec.vectorization.goal import Goal, Trial, make_facts
from warpvec.vectorization.result import Result

HEAD_BYTES, LONG_HEAD_BYTES = 170, 1300
"""Bytes of a file besides its paths, minified and with its settings."""

PATH_BYTES, NUMBER_BYTES = 40.0, 2.8
"""Bytes of a minified path besides the numbers of its cubics, and of each number."""

LONG_PATH_BYTES, LONG_NUMBER_BYTES = 66.0, 3.8
"""The same for paths in the long form with two decimals."""

GZIP_SHARE = 0.42
"""Bytes of the paths after gzip over those before."""

RICH_BYTES = 0.2
"""Bytes per pixel of the fitted image from which paths of `RICH_SEGMENTS` cubics are better than those of `MINIFIED`:
at 0.13 these gain 0.1 dB, at 0.25 they lose 0.03 (kodim07)."""

LONGER = 1.25
"""Iterations of the one fit over those of a fit without a goal. The search by several fits took 1.5 times as many and
more; 1.25 times gain 0.05 dB."""

RICH_SEGMENTS = 2
"""Mean number of cubics per path in files of many bytes, and in those that gzip makes small: it takes more off the text
around the numbers than off the numbers."""


def can_fit_once(goal: Goal, config: FitConfig) -> bool:
    """Return whether one fit meets ``goal``: a number of bytes alone, and paths of cubics that are recycled."""
    is_bytes = goal.max_bytes is not None and goal.target_psnr is None and not goal.auto
    return is_bytes and config.path_model == "segments" and config.policy == "scaffolding" and not config.lod


def settings_for_bytes(goal: Goal, config: FitConfig, pixel_count: int) -> FitConfig:
    """Return ``config`` with the iterations of the fit and, unless ``goal`` keeps them, the cubics per path.

    Args:
        goal: the bytes of the file.
        config: settings of the fit.
        pixel_count: number of pixels of the fitted image.
    """
    assert goal.max_bytes is not None
    config = replace(config, iterations=min(round(LONGER * config.iterations), MAX_COUNT))
    is_rich = goal.gzip or goal.max_bytes > RICH_BYTES * pixel_count
    is_free = not goal.keeps_segments and config.segments == MINIFIED["segments"]
    if config.minify and is_rich and is_free:
        return replace(config, segments=RICH_SEGMENTS)
    return config


def first_count(goal: Goal, config: FitConfig) -> int:
    """Return a guess at the number of paths, which the fit corrects."""
    assert goal.max_bytes is not None
    head, path, number = (
        (HEAD_BYTES, PATH_BYTES, NUMBER_BYTES)
        if config.minify
        else (LONG_HEAD_BYTES, LONG_PATH_BYTES, LONG_NUMBER_BYTES)
    )
    share = GZIP_SHARE if goal.gzip else 1.0
    count = (goal.max_bytes / share - head) / (path + 6 * config.segments * number)
    return max(1, min(round(count), config.curves))


def budget_of(goal: Goal, config: FitConfig, blank: Result) -> ByteBudget | None:
    """Return the bytes that the fit must keep to, counted in files like that of ``blank``; None if it need not.

    Args:
        goal: requirements on the file.
        config: settings whose ``curves`` are the most that may be used.
        blank: a result without paths, of the same photo, settings and file options.
    """
    if goal.max_bytes is None or not can_fit_once(goal, config):
        return None
    return ByteBudget(goal.max_bytes, lambda scene: blank.count_bytes(scene, gzip=goal.gzip), config.curves)


def within_bytes(goal: Goal, result: Result, iterations: int) -> Result:
    """Return the ``result`` of one fit, cut to the bytes of ``goal`` if need be, with the facts about it.

    Args:
        goal: the bytes.
        result: what the fit found.
        iterations: what was asked for, which the file states.

    Raises:
        InputError: not even one path fits into the bytes.
    """
    count = len(result.fitted.scene)
    result = replace(result, config=replace(result.config, curves=max(count, 1), iterations=iterations))
    trials: list[Trial] = [result.trial(goal)]
    found, trial = cut_to_bytes(result, goal, trials, trials[0])
    return replace(found, goal_facts=make_facts(goal, trials, trial))
