"""Controls on the page of `warpvec app`. A setting or a goal with a control is on the page; without one it is not."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True)
class Step:
    """A value that a control offers, its text on the page, and a tooltip if it needs one."""

    value: object
    text: str = ""
    tooltip: str = ""


@dataclass(frozen=True)
class Control:
    """How the page offers a setting.

    Attributes:
        form: "choice" of a few names, "slider" or "tick" (off and on).
        label: its label.
        tooltip: what it does.
        steps: the values that it offers, in order. The page starts with the default, or with the first.
        modes: modes in which the page sends the setting; None for all that use it.
        moved_by: name of the setting whose slider moves this one too; it has as many steps.
        overrides: name of the setting whose control has no effect unless this one is at its first step.
    """

    form: Literal["choice", "slider", "tick"]
    label: str
    tooltip: str
    steps: tuple[Step, ...]
    modes: tuple[str, ...] | None = None
    moved_by: str | None = None
    overrides: str | None = None


def slider(label: str, tooltip: str, values: Iterable[Any], text: Callable[[Any], str], **more: Any) -> Control:
    """Return a slider; ``text`` shows a value, and ``more`` are attributes of `Control`."""
    return Control("slider", label, tooltip, tuple(Step(value, text(value)) for value in values), **more)


def tick(label: str, tooltip: str, off: Any = False, on: Any = True) -> Control:
    """Return a box to tick for the values ``off`` and ``on``."""
    return Control("tick", label, tooltip, (Step(off), Step(on)))


def doublings(first: float, count: int, steps_per_doubling: int = 4) -> list[float]:
    """Return ``count`` values from ``first`` on, of which each is the same factor times the one before.

    A negative ``steps_per_doubling`` makes them fall.
    """
    return [first * 2.0 ** (index / steps_per_doubling) for index in range(count)]
