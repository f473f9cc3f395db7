"""Goals for a file (bytes, PSNR), and the facts about the fits that were made for one."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from warpvec.checks import as_float, check_count, check_flag, show
from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError

PROBE_CURVES = 64
"""Paths of the probe, a first short fit from which the search guesses the number of paths. It takes a second."""

SHORT_SHARE = 0.25
"""Iterations of a short fit (the probe or a correction) as a share of those of a whole fit."""

CORRECTION_RATE = 0.4
"""Factor for the learning rates of a correction, so that it keeps the paths near their places. 288 paths grown to 320
in 500 iterations (kodim07) reach 28.04 dB with 0.3 and 27.77 with 1; from nothing in 2000 iterations: 27.95."""

CURVES_MAX = 16_384
"""Largest number of paths that a search tries. Beyond it a file is larger than the photo as a JPEG of equal quality."""

MAX_FILE_BYTES = 10**12
"""Largest size that a file may be asked to have, above any file; larger numbers would overflow in the search."""

_SIZE = re.compile(r"([0-9]+(?:\.[0-9]*)?)\s*(k|m)?b?", re.IGNORECASE)
_UNITS = {"": 1, "k": 1_000, "m": 1_000_000}


@dataclass(frozen=True, kw_only=True)
class Goal:
    """Requirements on the file, from which the number of paths follows. A goal without any is false.

    Raises:
        InputError: a field is of the wrong type or out of its range.
    """

    max_bytes: int | None = None
    """Largest size of the file; the search uses nearly all of it."""
    gzip: bool = False
    """Count the bytes after gzip, as web servers send them."""
    target_psnr: float | None = None
    """PSNR in dB that the file must reach, as resvg draws it."""
    auto: bool = False
    """Use as many paths as the photo rewards."""
    keeps_segments: bool = False
    """The cubics per path of a minified file are given; else they follow from the bytes, unless they are not the usual
    ones."""

    def __post_init__(self) -> None:
        check_flag("gzip", self.gzip)
        if self.max_bytes is not None:
            object.__setattr__(self, "max_bytes", check_count("max_bytes", self.max_bytes, 1, MAX_FILE_BYTES))
        if self.target_psnr is not None:
            object.__setattr__(self, "target_psnr", _check_psnr(self.target_psnr))

    def __bool__(self) -> bool:
        return self.auto or self.max_bytes is not None or self.target_psnr is not None


def with_given_segments(goal: Goal, settings: dict[str, Any], config: FitConfig) -> Goal:
    """Return ``goal``, which keeps the cubics per path if ``settings`` give them and they would follow from the bytes.

    Args:
        goal: requirements on the file.
        settings: those that were asked for.
        config: all settings that follow from them.
    """
    return replace(goal, keeps_segments=goal.max_bytes is not None and config.minify and "segments" in settings)


def is_auto(curves: Any) -> bool:
    """Return whether ``curves`` asks for as many paths as pay; arrays compare by element and do not."""
    return isinstance(curves, str) and curves == "auto"


def with_curves(settings: dict[str, Any], curves: int | str | None, goal: Goal) -> dict[str, Any]:
    """Return ``settings`` with the number of paths: ``curves`` itself, or the most that the search may use.

    A file whose bytes count is minified, unless ``settings`` say otherwise or ask for levels of detail.
    """
    if goal.max_bytes is not None and not settings.get("lod"):
        settings = {"minify": True, **settings}
    if isinstance(curves, str) and not is_auto(curves):
        raise InputError("curves", "must be a whole number or auto", repr(curves), "give one of these")
    if curves is None or is_auto(curves):
        return {**settings, "curves": CURVES_MAX} if goal else settings
    return {**settings, "curves": curves}


class Trial(NamedTuple):
    """Figures of one fit of a search: the bytes of its file as the goal counts them, and its PSNR in dB by resvg."""

    asked: int
    """Number of paths that the fit was asked for."""
    curves: int
    """Number of paths in the file, without invisible ones."""
    bytes: int
    psnr: float
    eligible: bool = True
    """True if the fit was long enough to be the result."""


def parse_size(text: str) -> int:
    """Return the bytes of a size such as "50000", "50k" or "1.5M". A k is 1000, as in size budgets of web pages.

    Raises:
        InputError: the text is not such a size.
    """
    match = _SIZE.fullmatch(text.strip())
    count = 0.0 if match is None else float(match[1]) * _UNITS[(match[2] or "").lower()]
    if not 1.0 <= count < math.inf:
        raise InputError("max_bytes", "must be a size such as 50000, 80k or 1.5M", repr(text), "give at least 1")
    return round(count)


def make_facts(goal: Goal, trials: Sequence[Trial], result: Trial) -> dict[str, Any]:
    """Return the goal, whether the file meets it, and the trials, as plain values for JSON."""
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
    """Return the facts of `make_facts` as one line of text."""
    parts = []
    if facts["max_bytes"] is not None:
        kind = "gzipped bytes" if facts["gzip"] else "bytes"
        parts.append(f"{facts['bytes']:,} of {facts['max_bytes']:,} {kind}")
    if facts["target_psnr"] is not None:
        parts.append(f"{facts['target_psnr']:g} dB {'reached' if facts['met'] else 'not reached'}")
    counts = ", ".join(str(trial["curves"]) for trial in facts["trials"])
    return f"goal: {'; '.join(parts) or 'as many curves as pay'}; fits made with {counts} curves"


def _check_psnr(value: Any) -> float:
    number = as_float(value)
    if not 0 < number <= 100:
        raise InputError("target_psnr", "must be above 0 and at most 100", show(value), "give 25 to 35 for a photo")
    return number
