"""Types of option values that click does not have."""

from __future__ import annotations

import re
from typing import Any

import click

from warpvec.config.rules import parse_palette
from warpvec.errors import InputError
from warpvec.inputs import read_file
from warpvec.vectorization.goal import parse_size

MAX_PALETTE_BYTES = 2**24
"""Largest file of colours. It may be a style sheet or a drawing, of which the colours are taken."""

_HEX_COLOR = re.compile(r"#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{3})\b")

_LIST_WORD = re.compile(r"[a-zA-Z]+|#\w+")

_COMMENT = re.compile(r"#(?!\w).*")
"""A comment to the end of its line, which begins with a # that is not that of a hex code."""


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


class GradientCount(click.ParamType):
    """A number of paths or their share, or "auto"."""

    name = "float|auto"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "auto":
            return value
        try:
            return float(value)
        except ValueError:
            raise InputError(_option(param), "must be a number or auto", repr(value)) from None


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
    """Return the colours in a text file: those of a list of colours, otherwise every "#123" and "#a0b1c2".

    Raises:
        InputError: the file cannot be read, has no colours, or is a list with a word that is not a colour.
    """
    kind = "colours such as red,#a0b1c2, or a file of them"
    text = read_file(path, MAX_PALETTE_BYTES, "palette", kind).decode("utf-8-sig", errors="replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    entries = [entry.split() for entry in re.split(r"[,;\n]", _COMMENT.sub("", text)) if entry.strip()]
    if entries and _is_color_list(entries):
        words = [word for entry in entries for word in entry]
        wrong = next((word for word in words if not _is_color(word)), None)
        if wrong is None:
            return words
        rule = "must be a file of colours such as red and #a0b1c2"
        raise InputError("palette", rule, f"{wrong!r} in {path!r}", "correct the word")
    found = _HEX_COLOR.findall(text)
    if not found:
        rule = "must be a file with colours such as #a0b1c2"
        raise InputError("palette", rule, f"{path!r} without any", "add some")
    return found


def _is_color_list(entries: list[list[str]]) -> bool:
    """Return whether the words between the commas and line ends of a file are meant as colours, not as other text.

    Other text has numbers or punctuation, words beside each other without a colour name among them, or names before or
    after the one hex code of every entry.
    """
    if not all(_LIST_WORD.fullmatch(word) for entry in entries for word in entry):
        return False
    if not all(any(_is_color(word) for word in entry if word[0] != "#") for entry in _mixed(entries)):
        return False
    labelled = [entry for entry in _mixed(entries) if sum(word[0] == "#" for word in entry) == 1]
    return len(entries) == 1 or len(labelled) < len(entries)


def _mixed(entries: list[list[str]]) -> list[list[str]]:
    """Return the entries of several words that are not all hex codes."""
    return [entry for entry in entries if len(entry) > 1 and not all(word[0] == "#" for word in entry)]


def _is_color(word: str) -> bool:
    try:
        parse_palette(word)
    except InputError:
        return False
    return True
