"""Types of option values that click does not have."""

from __future__ import annotations

from typing import Any

import click

from warpvec.config.kinds import Kind
from warpvec.errors import InputError


class ValueOf(click.ParamType):
    """A value of the option ``option``, of a `Kind`."""

    def __init__(self, option: str, kind: Kind) -> None:
        self.name, self._option, self._kind = kind.metavar, option, kind

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the value that a text stands for."""
        return self._kind.parse(self._option, value) if isinstance(value, str) else value


class WholeNumber(click.ParamType):
    """A whole number, of at least ``minimum`` if that is given."""

    name = "integer"

    def __init__(self, minimum: int | None = None) -> None:
        self._minimum = minimum

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number that a text stands for."""
        try:
            number = int(value)
        except ValueError:
            number = None
        if number is None or (self._minimum is not None and number < self._minimum):
            limit = "" if self._minimum is None else f" of at least {self._minimum}"
            raise InputError(_option(param), f"must be a whole number{limit}", repr(value))
        return number


def _option(param: click.Parameter | None) -> str:
    return "value" if param is None else param.opts[0]
