"""Checks of what users give. Every error is one line: the name, the rule, the value and the remedy."""

from __future__ import annotations

import math
import operator
from numbers import Real
from typing import Any

from warpvec.errors import InputError


def check_count(name: str, value: Any, least: int, most: int | None = None) -> int:
    """``value``, Python's or NumPy's, as an int.

    Raises:
        InputError: not a whole number from ``least`` to ``most``.
    """
    rule = f"of at least {least}" if most is None else f"from {least} to {most}"
    remedy = f"{least} or more" if most is None else "a number in that range"
    try:
        count = operator.index(value)
    except TypeError:
        count = least - 1
    if isinstance(value, bool) or count < least or (most is not None and count > most):
        raise InputError(f"{name} must be a whole number {rule}, got {show(value)}; give {remedy}")
    return count


def check_number(name: str, value: Any, low: float, high: float) -> float:
    """``value``, Python's or NumPy's, as a float.

    Raises:
        InputError: not a finite number from ``low`` to ``high``, which may be infinite.
    """
    number = as_float(value)
    if not low <= number <= high:
        rule = f"be finite and at least {low:g}" if high == math.inf else f"lie between {low:g} and {high:g}"
        raise InputError(f"{name} must {rule}, got {show(value)}; give a number in that range")
    return number


def check_choice(name: str, value: Any, allowed: tuple[str, ...]) -> None:
    """Raises InputError unless ``value`` is one of the ``allowed`` names."""
    if not isinstance(value, str) or value not in allowed:
        raise InputError(f"{name} must be one of {', '.join(allowed)}, got {show(value)}; give one of these")


def check_flag(name: str, value: Any) -> None:
    """Raises InputError unless ``value`` is True or False."""
    if not isinstance(value, bool):
        raise InputError(f"{name} must be True or False, got {show(value)}; give one of these")


def as_float(value: Any) -> float:
    """``value``, Python's or NumPy's, as a float; NaN, which lies in no range, if it is not a finite number."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return math.nan
    try:
        number = float(value)
    except OverflowError:
        return math.nan
    return number if math.isfinite(number) else math.nan


def show(value: Any) -> str:
    """``value`` in one line; arrays print in several."""
    return " ".join(repr(value).split())
