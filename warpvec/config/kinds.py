"""Kinds of values of settings: how a value is checked, and how it is read from a text."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from warpvec.checks import as_float, check_choice, check_count, check_flag, check_number, show
from warpvec.errors import InputError

Number = TypeVar("Number", int, float)


class Kind(Protocol):
    """A kind of values."""

    @property
    def metavar(self) -> str:
        """Placeholder of a value on the command line."""

    @property
    def limits(self) -> str:
        """Values that are allowed, for the table of settings."""

    @property
    def annotation(self) -> str:
        """The type of the values that Python may give, as text."""

    def check(self, name: str, value: object) -> Any:
        """Return ``value`` in its normal form.

        Raises:
            InputError: the setting ``name`` cannot have it.
        """

    def parse(self, name: str, text: str) -> Any:
        """Return the value that ``text`` stands for, on the command line or in a file.

        Raises:
            InputError: it stands for no value of this kind; messages call the setting ``name``.
        """


def parse_whole(name: str, text: str) -> int:
    """Return the whole number in ``text``.

    Raises:
        InputError: there is none; messages call the setting ``name``.
    """
    return _parsed(int, name, text, "must be a whole number")


def parse_real(name: str, text: str) -> float:
    """Return the number in ``text``.

    Raises:
        InputError: there is none; messages call the setting ``name``.
    """
    return _parsed(float, name, text, "must be a number")


def _parsed(convert: Callable[[str], Number], name: str, text: str, rule: str) -> Number:
    try:
        return convert(text)
    except ValueError:
        raise InputError(name, rule, repr(text)) from None


def parse_text(name: str, text: str) -> str:
    """Return ``text``."""
    del name
    return text


@dataclass(frozen=True)
class Whole:
    """Whole numbers from ``low`` to ``high``; also None if it is ``optional``."""

    low: int
    high: int
    optional: bool = False
    metavar = "N"
    annotation = "int"

    @property
    def limits(self) -> str:
        """Values that are allowed."""
        return f"{self.low} to {self.high}"

    def check(self, name: str, value: object) -> int | None:
        """Return ``value`` as a Python integer."""
        return None if value is None and self.optional else check_count(name, value, self.low, self.high)

    parse = staticmethod(parse_whole)


@dataclass(frozen=True)
class Real:
    """Numbers from ``low`` to ``high``, which may be infinite."""

    low: float
    high: float
    metavar = "X"
    annotation = "float"

    @property
    def limits(self) -> str:
        """Values that are allowed."""
        return f"{self.low:g} or more" if self.high == math.inf else f"{self.low:g} to {self.high:g}"

    def check(self, name: str, value: object) -> float:
        """Return ``value`` as a Python float."""
        return check_number(name, value, self.low, self.high)

    parse = staticmethod(parse_real)


@dataclass(frozen=True)
class Positive:
    """Numbers above 0 up to ``high``; also None if it is ``optional``.

    Attributes:
        rule: what is allowed, for messages.
        remedy: what to do instead, for messages.
    """

    high: float
    rule: str
    remedy: str
    optional: bool = False
    metavar = "X"
    annotation = "float"

    @property
    def limits(self) -> str:
        """Values that are allowed."""
        return f"above 0, to {self.high:g}"

    def check(self, name: str, value: object) -> float | None:
        """Return ``value`` as a Python float."""
        if value is None and self.optional:
            return None
        number = as_float(value)
        if not 0.0 < number <= self.high:
            raise InputError(name, self.rule, show(value), self.remedy)
        return number

    parse = staticmethod(parse_real)


@dataclass(frozen=True)
class Flag:
    """True and False."""

    metavar = ""
    annotation = "bool"
    limits = "on or off"

    def check(self, name: str, value: object) -> bool:
        """Return ``value``."""
        check_flag(name, value)
        return bool(value)

    def parse(self, name: str, text: str) -> bool:
        """Return whether ``text`` is "true"."""
        return text.lower() == "true"


@dataclass(frozen=True)
class Choice:
    """One of some names."""

    names: tuple[str, ...]
    metavar = "NAME"

    @property
    def limits(self) -> str:
        """Values that are allowed."""
        return ", ".join(self.names)

    @property
    def annotation(self) -> str:
        """The type of the values, as text."""
        return f"Literal[{', '.join(f'{chr(34)}{name}{chr(34)}' for name in self.names)}]"

    def check(self, name: str, value: object) -> str:
        """Return ``value``."""
        check_choice(name, value, self.names)
        return str(value)

    parse = staticmethod(parse_text)


@dataclass(frozen=True)
class Custom:
    """Values with rules of their own.

    Attributes:
        check: as in `Kind`.
        parse: as in `Kind`.
        metavar: placeholder of a value on the command line.
        limits: values that are allowed, for the table of settings.
        annotation: the type of the values that Python may give, as text.
    """

    check: Callable[[str, Any], Any]
    parse: Callable[[str, str], Any]
    metavar: str
    limits: str
    annotation: str


def or_auto(parse: Callable[[str, str], Any], rule: str) -> Callable[[str, str], Any]:
    """Return a function that reads "auto" or what ``parse`` reads; ``rule`` is for messages about other texts."""

    def parse_or_auto(name: str, text: str) -> Any:
        if text == "auto":
            return text
        try:
            return parse(name, text)
        except InputError:
            raise InputError(name, rule, repr(text)) from None

    return parse_or_auto
