"""Types of option values that click does not have."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from warpvec.config.rules import parse_palette
from warpvec.errors import InputError
from warpvec.vectorization.goal import parse_size

_HEX_COLOR = re.compile(r"#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{3})\b")


class WholeNumber(click.ParamType):
    """A whole number, of at least ``minimum`` if that is given."""

    name = "integer"

    def __init__(self, minimum: int | None = None) -> None:
        self._minimum = minimum

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        try:
            number = int(value)
        except ValueError:
            number = None
        if number is None or (self._minimum is not None and number < self._minimum):
            limit = "" if self._minimum is None else f" of at least {self._minimum}"
            raise InputError(_option(param), f"must be a whole number{limit}", repr(value))
        return number


class Number(click.ParamType):
    """A number."""

    name = "float"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            return float(value)
        except ValueError:
            raise InputError(_option(param), "must be a number", repr(value)) from None


class CurveCount(click.ParamType):
    """A number of paths, or "auto"."""

    name = "integer|auto"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "auto":
            return value
        try:
            return int(value)
        except ValueError:
            raise InputError("curves", "must be a whole number or auto", repr(value)) from None


class ByteCount(click.ParamType):
    """A size such as 50000, 80k or 1.5M."""

    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return parse_size(value) if isinstance(value, str) else value


class PaletteColors(click.ParamType):
    """A list of colours, or a file of them if the value is not such a list."""

    name = "colors|file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return parse_palette(value)
        except InputError:
            return parse_palette(",".join(_colors_in(value)))


def _option(param: click.Parameter | None) -> str:
    return "value" if param is None else param.opts[0]


def _colors_in(path: str) -> list[str]:
    """Return every "#123" and "#a0b1c2" in a text file."""
    try:
        found = _HEX_COLOR.findall(Path(path).read_text(encoding="utf-8", errors="replace"))
    except (OSError, ValueError) as error:
        rule = "must be colours such as red,#a0b1c2, or a file of them"
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError("palette", rule, f"{path!r} (as a file: {reason})") from error
    if not found:
        rule = "must be a file with colours such as #a0b1c2"
        raise InputError("palette", rule, f"{path!r} without any", "add some")
    return found
