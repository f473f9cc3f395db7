"""Check the form of a saved state before any of it is used: types, shapes, ranges, and which names there are.

A state may come from a stranger, and native code trusts the shapes it is given. Each part of a fit has three methods
next to one another: ``state`` makes its state, ``check`` says what it must look like, and ``restore`` uses it. A state
with a name too few or too many is refused, so whoever adds a field has to describe it here as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

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


class Form(Protocol):
    """A form that a value of a state must have."""

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value``, which is called ``name``, has this form."""


@dataclass(frozen=True)
class Array:
    """A contiguous array with values from ``low`` to ``high``."""

    dtype: torch.dtype
    shape: tuple[int, ...]
    low: float
    high: float

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is such an array."""
        is_array = isinstance(value, Tensor) and value.dtype == self.dtype and value.is_contiguous()
        kind = str(self.dtype).removeprefix("torch.")
        require(is_array and value.shape == self.shape, name, f"is not a {kind} array of shape {list(self.shape)}")
        # A NaN is in no range.
        is_within = ((value >= self.low) & (value <= self.high)).all()
        require(is_within, name, f"has values outside of {self.low:.9g} to {self.high:.9g}")


def floats(*shape: int, low: float = -_FLOAT_MAX, high: float = _FLOAT_MAX) -> Array:
    """Return the form of finite float32 values."""
    return Array(torch.float32, shape, low, high)


def wholes(*shape: int, low: int = 0, high: int = _WHOLE_MAX) -> Array:
    """Return the form of int64 values."""
    return Array(torch.int64, shape, low, min(high, _WHOLE_MAX))


@dataclass(frozen=True)
class Integer:
    """A whole number from ``low`` to ``high``."""

    low: int
    high: int

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is such a number."""
        is_whole = isinstance(value, int) and not isinstance(value, bool)
        require(is_whole and self.low <= value <= self.high, name, "is not a whole number that is possible here")


@dataclass(frozen=True)
class Number:
    """A float from ``low`` to ``high``, which may be infinite."""

    low: float
    high: float

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is such a number."""
        is_within = isinstance(value, float) and self.low <= value <= self.high
        require(is_within, name, f"is not a number from {self.low:g} to {self.high:g}")


@dataclass(frozen=True)
class Text:
    """A text."""

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is a text."""
        require(isinstance(value, str), name, "is not a text")


@dataclass(frozen=True)
class Exactly:
    """The plain value ``expected`` and no other, of the same type."""

    expected: Any

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is the expected one."""
        is_same = type(value) is type(self.expected) and value == self.expected
        require(is_same, name, f"is not {self.expected!r}")


@dataclass(frozen=True)
class Fields:
    """A dictionary with these names and no others."""

    forms: Mapping[str, Form]

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` has all fields in their forms."""
        FieldSet().check(name, value)
        require(value.keys() == self.forms.keys(), name, f"does not have the fields {', '.join(self.forms)}")
        for field, form in self.forms.items():
            form.check(f"{name}.{field}" if name else field, value[field])


@dataclass(frozen=True)
class FieldSet:
    """A dictionary that its own part of the fit checks."""

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is a dictionary."""
        require(isinstance(value, dict), name, "is not a set of fields")


@dataclass(frozen=True)
class Maybe:
    """None, or a value of ``form``."""

    form: Form

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is None or has the form."""
        if value is not None:
            self.form.check(name, value)


@dataclass(frozen=True)
class ListOf:
    """A list of values of ``form``."""

    form: Form

    def check(self, name: str, value: Any) -> None:
        """Raise the error of `damaged` unless ``value`` is such a list."""
        require(isinstance(value, list), name, "is not a list")
        for k, item in enumerate(value):
            self.form.check(f"{name}[{k}]", item)


def check_fields(name: str, value: Any, **forms: Form) -> None:
    """Raise the error of `damaged` unless ``value`` is a dictionary with these fields and no others."""
    Fields(forms).check(name, value)


def row_count(name: str, part: Any, field: str, high: int) -> int:
    """Return the length, at most ``high``, of the array ``field`` of ``part``, which is not checked yet."""
    FieldSet().check(name, part)
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
