"""A goal for a file: bounds of its quantities, from which the number of paths or the detail follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from warpvec.checks import check_flag, suggest_name
from warpvec.config.fit_config import SETTINGS, FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.goals.quantity import Quantity
from warpvec.goals.registry import QUANTITIES

SEARCHED_CURVES_MAX = 16_384
"""Largest number of paths that a search tries. Beyond it a file is larger than the photo as a JPEG of equal quality."""


@dataclass(frozen=True, kw_only=True)
class Goal:
    """Requirements on the file. A goal without any is false.

    Attributes:
        bounds: bound by the name of its quantity in `QUANTITIES`: at most one largest and one smallest value.
        gzip: count bytes after gzip, as web servers send them.
        auto: use as many paths as the photo rewards.
        keeps_segments: keep the given cubics per path of a minified file, which otherwise follow from the bytes.
    """

    bounds: Mapping[str, float] = field(default_factory=dict)
    gzip: bool = False
    auto: bool = False
    keeps_segments: bool = False

    def __bool__(self) -> bool:
        return self.auto or bool(self.bounds)

    @property
    def limit(self) -> tuple[Quantity, float] | None:
        """The quantity with a largest value, and this value."""
        return self._bound("largest")

    @property
    def quality(self) -> tuple[Quantity, float] | None:
        """The quantity with a smallest value, and this value."""
        return self._bound("smallest")

    @property
    def level(self) -> float | None:
        """The smallest value in decibels; see `Quantity.decibels`."""
        return None if self.quality is None else self.quality[0].decibels(self.quality[1])

    def without_quality(self) -> Goal:
        """Return the goal without its smallest value."""
        kept = {name: bound for name, bound in self.bounds.items() if QUANTITIES[name].bound == "largest"}
        return replace(self, bounds=kept)

    def to_dict(self) -> dict[str, Any]:
        """Return the goal as plain values, for records."""
        return {
            **{name: self.bounds.get(name) for name in QUANTITIES},
            "gzip": self.gzip,
            "auto": self.auto,
            "keeps_segments": self.keeps_segments,
        }

    def _bound(self, kind: str) -> tuple[Quantity, float] | None:
        found = [(QUANTITIES[name], bound) for name, bound in self.bounds.items() if QUANTITIES[name].bound == kind]
        return found[0] if found else None


NO_GOAL = Goal()
"""Nothing is asked of the file."""


def make_goal(*, gzip: bool = False, auto: bool = False, **bounds: Any) -> Goal:
    """Return the goal with these ``bounds`` by the names of their quantities; None stands for no bound.

    Raises:
        InputError: a bound is of the wrong type or out of its range, or two bounds do not go together.
    """
    check_flag("gzip", gzip)
    given = {name: QUANTITIES[name].kind.check(name, value) for name, value in bounds.items() if value is not None}
    for kind in ("largest", "smallest"):
        names = [name for name in given if QUANTITIES[name].bound == kind]
        if len(names) > 1:
            raise InputError(names[1], f"must not be given with {names[0]}", remedy="leave one of them out")
    return Goal(bounds=given, gzip=gzip, auto=auto)


def refuse_states(goal: Goal, states: Mapping[str, object]) -> None:
    """Raise InputError if the state of a fit that follows a goal is to be saved or resumed: it has none of the goal.

    Args:
        goal: the requirement on the file.
        states: what is saved or resumed, by its name in messages; None for nothing.
    """
    for name in [name for name, given in states.items() if goal and given is not None]:
        rule = f"cannot be combined with {', '.join(QUANTITIES)} or curves auto"
        raise InputError(name, rule, remedy="leave one of them out")


def settings_and_goal(preset: str, options: Mapping[str, Any]) -> tuple[FitConfig, Goal]:
    """Return the settings and the goal of a run.

    A file whose bytes count is minified, unless the options say otherwise or ask for levels of detail.

    Args:
        preset: name of a preset.
        options: settings, bounds of `QUANTITIES` and "gzip" by name. "curves" may be "auto"; with a goal it is the most
            paths that may be used.

    Raises:
        InputError: a value is out of range, or two values do not go together.
    """
    bounds = {name: options[name] for name in QUANTITIES if name in options}
    settings = {name: value for name, value in options.items() if name not in (*bounds, "gzip")}
    for name in settings:
        if name not in SETTINGS and (remedy := suggest_name(name, (*QUANTITIES, "gzip"))):
            raise InputError(name, "is not a setting", remedy=remedy)
    curves = settings.pop("curves", None)
    goal = make_goal(gzip=options.get("gzip", False), auto=is_auto(curves), **bounds)
    config = make_config(preset, **with_curves(settings, curves, goal))
    keeps_segments = goal.limit is not None and config.minify and "segments" in settings
    return config, replace(goal, keeps_segments=keeps_segments)


def is_auto(curves: Any) -> bool:
    """Return whether ``curves`` asks for as many paths as pay; arrays compare by element and do not."""
    return isinstance(curves, str) and curves == "auto"


def with_curves(settings: dict[str, Any], curves: int | str | None, goal: Goal) -> dict[str, Any]:
    """Return ``settings`` with the number of paths: ``curves`` itself, or the most that the search may use."""
    if goal.limit is not None and goal.limit[0].is_of_text and not settings.get("lod"):
        settings = {"minify": True, **settings}
    if isinstance(curves, str) and not is_auto(curves):
        raise InputError("curves", "must be a whole number or auto", repr(curves), "give one of these")
    if curves is None or is_auto(curves):
        return {**settings, "curves": SEARCHED_CURVES_MAX} if goal else settings
    return {**settings, "curves": curves}


def describe(facts: Mapping[str, Any]) -> str:
    """Return the facts of `warpvec.goals.search.make_facts` as one line of text."""
    parts = [quantity.describe(facts) for name, quantity in QUANTITIES.items() if facts[name] is not None]
    if facts.get("curves_max") is not None:
        parts.append(f"all {facts['curves_max']:,} paths of --curves are used, and more would come closer")
    return f"goal: {'; '.join(parts) or 'as many paths as pay'}"
