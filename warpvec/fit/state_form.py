"""Check the form of a saved state before any of it is used: types, shapes, ranges, and which names there are.

A state may come from a stranger, and native code trusts the shapes it is given. Each part of a fit has three methods
next to one another: ``state`` makes its state, ``check`` says what it must look like, and ``restore`` uses it. A state
with a name too few or too many is refused, so whoever adds a field has to describe it here as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import torch
from torch import Tensor

from warpvec.errors import InputError

_FLOAT_MAX, _WHOLE_MAX = torch.finfo(torch.float32).max, torch.iinfo(torch.int64).max


def damaged(name: str, problem: str) -> InputError:
    """Return the error for a state of which the part ``name`` cannot be right: it "``problem``"."""
    value = f"one whose {name or 'state'} {problem} (it is damaged)"
    return InputError("checkpoint", "must hold a whole fit", value, "start again without it")


def require(is_right: bool | Tensor, name: str, problem: str) -> None:
    """Raise the error of `damaged` unless ``is_right``."""
    if not is_right:
        raise damaged(name, problem)


Form = Callable[[str, Any], None]
"""A form that a value of a state must have: raises the error of `damaged` unless the value, which is called by the
name, has it."""


def array(dtype: torch.dtype, shape: tuple[int, ...], low: float, high: float) -> Form:
    """Return the form of a contiguous array with values from ``low`` to ``high``."""

    def check(name: str, value: Any) -> None:
        is_array = isinstance(value, Tensor) and value.dtype == dtype and value.is_contiguous()
        kind = str(dtype).removeprefix("torch.")
        require(is_array and value.shape == shape, name, f"is not a {kind} array of shape {list(shape)}")
        # A NaN is in no range.
        is_within = ((value >= low) & (value <= high)).all()
        require(is_within, name, f"has values outside of {low:.9g} to {high:.9g}")

    return check


def floats(*shape: int, low: float = -_FLOAT_MAX, high: float = _FLOAT_MAX) -> Form:
    """Return the form of finite float32 values."""
    return array(torch.float32, shape, low, high)


def wholes(*shape: int, low: int = 0, high: int = _WHOLE_MAX) -> Form:
    """Return the form of int64 values."""
    return array(torch.int64, shape, low, min(high, _WHOLE_MAX))


def integer(low: int, high: int) -> Form:
    """Return the form of a whole number from ``low`` to ``high``."""

    def check(name: str, value: Any) -> None:
        is_whole = isinstance(value, int) and not isinstance(value, bool)
        require(is_whole and low <= value <= high, name, "is not a whole number that is possible here")

    return check


def number(low: float, high: float) -> Form:
    """Return the form of a float from ``low`` to ``high``, which may be infinite."""

    def check(name: str, value: Any) -> None:
        is_within = isinstance(value, float) and low <= value <= high
        require(is_within, name, f"is not a number from {low:g} to {high:g}")

    return check


def text(name: str, value: Any) -> None:
    """Refuse what is no text."""
    require(isinstance(value, str), name, "is not a text")


def field_set(name: str, value: Any) -> None:
    """Refuse what is no dictionary; its own part of the fit checks the fields."""
    require(isinstance(value, dict), name, "is not a set of fields")


def exactly(expected: Any) -> Form:
    """Return the form of the plain value ``expected`` and no other, of the same type."""

    def check(name: str, value: Any) -> None:
        require(type(value) is type(expected) and value == expected, name, f"is not {expected!r}")

    return check


def fields(**forms: Form) -> Form:
    """Return the form of a dictionary with these names and no others."""

    def check(name: str, value: Any) -> None:
        field_set(name, value)
        require(value.keys() == forms.keys(), name, f"does not have the fields {', '.join(forms)}")
        for field, form in forms.items():
            form(f"{name}.{field}" if name else field, value[field])

    return check


def maybe(form: Form) -> Form:
    """Return the form of None, or a value of ``form``."""

    def check(name: str, value: Any) -> None:
        if value is not None:
            form(name, value)

    return check


def list_of(form: Form) -> Form:
    """Return the form of a list of values of ``form``."""

    def check(name: str, value: Any) -> None:
        require(isinstance(value, list), name, "is not a list")
        for k, item in enumerate(value):
            form(f"{name}[{k}]", item)

    return check


def check_fields(name: str, value: Any, **forms: Form) -> None:
    """Raise the error of `damaged` unless ``value`` is a dictionary with these fields and no others."""
    fields(**forms)(name, value)


def row_count(name: str, part: Any, field: str, high: int) -> int:
    """Return the length, at most ``high``, of the array ``field`` of ``part``, which is not checked yet."""
    field_set(name, part)
    rows = part.get(field)
    is_array = isinstance(rows, Tensor) and rows.dim() > 0
    require(is_array and len(rows) <= high, f"{name}.{field}", f"is not an array of at most {high} rows")
    return len(rows)


def same_settings(saved: Mapping[str, Any], expected: Mapping[str, Any]) -> bool:
    """Return whether two sets of settings agree. Numbers may differ in their last digit, as machines do."""
    return all(_same(saved[name], value) for name, value in expected.items())


def _same(saved: Any, expected: Any) -> bool:
    if isinstance(saved, float) and isinstance(expected, float):
        return math.isclose(saved, expected, rel_tol=1e-12)
    return type(saved) is type(expected) and saved == expected
