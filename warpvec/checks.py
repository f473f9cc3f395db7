"""Check values that users give. Each failed check raises an InputError of one line."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from difflib import get_close_matches
from numbers import Real
from typing import Any

from warpvec.errors import InputError


def counted(count: int, noun: str) -> str:
    """Return "1 path", "2 paths": ``noun`` with its number."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def check_count(name: str, value: Any, minimum: int, maximum: int | None = None) -> int:
    """Return ``value``, of a Python or NumPy type, as an int.

    Raises:
        InputError: ``value`` is not a whole number from ``minimum`` to ``maximum``.
    """
    rule = f"of at least {minimum}" if maximum is None else f"from {minimum} to {maximum}"
    remedy = f"give {minimum} or more" if maximum is None else "give a number in that range"
    try:
        count = operator.index(value)
    except TypeError:
        count = minimum - 1
    if isinstance(value, bool) or count < minimum or (maximum is not None and count > maximum):
        raise InputError(name, f"must be a whole number {rule}", show(value), remedy)
    return count


def check_number(name: str, value: object, low: float, high: float) -> float:
    """Return ``value``, of a Python or NumPy type, as a float.

    Raises:
        InputError: ``value`` is not a finite number from ``low`` to ``high``; ``high`` may be infinite.
    """
    number = as_float(value)
    if not low <= number <= high:
        rule = f"be finite and at least {low:g}" if high == math.inf else f"be from {low:g} to {high:g}"
        raise InputError(name, f"must {rule}", show(value), "give a number in that range")
    return number


def check_choice(name: str, value: object, allowed: tuple[str, ...]) -> None:
    """Raise InputError, which suggests the name that is most like ``value``, unless it is one of the ``allowed``."""
    if not isinstance(value, str) or value not in allowed:
        remedy = suggest_name(value, allowed) if isinstance(value, str) else ""
        raise InputError(name, f"must be one of {', '.join(allowed)}", show(value), remedy)


def suggest_name(name: str, allowed: Iterable[str]) -> str:
    """Return a remedy with the one of the ``allowed`` names that is most like ``name``; "" if none is like it."""
    similar = get_close_matches(name, list(allowed), n=1, cutoff=0.7)
    return f"did you mean {similar[0]}?" if similar else ""


def check_flag(name: str, value: object) -> None:
    """Raise InputError unless ``value`` is True or False."""
    if not isinstance(value, bool):
        raise InputError(name, "must be True or False", show(value))


def as_float(value: object) -> float:
    """Return ``value``, of a Python or NumPy type, as a float; NaN, which is in no range, if it is not finite."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return math.nan
    try:
        number = float(value)
    except OverflowError:
        return math.nan
    return number if math.isfinite(number) else math.nan


def in_one_line(text: str) -> str:
    r"""Return ``text`` with escapes such as \n for what would break a line, or move or colour the text of a terminal.

    File names can hold any of these.
    """
    escapes = {ord(letter): ascii(letter)[1:-1] for letter in set(text) if not letter.isprintable()}
    return text.translate(escapes)


def show(value: object) -> str:
    """Return the repr of ``value`` in one line; arrays print in several."""
    try:
        return " ".join(repr(value).split())
    except ValueError:  # Python writes no number of more than 4300 digits
        return "a number of thousands of digits"
