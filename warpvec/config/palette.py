"""Palettes: colours with commas between them, or in a file."""

from __future__ import annotations

import os
import re
from typing import Any

from warpvec.checks import show
from warpvec.config.limits import MAX_PALETTE_BYTES
from warpvec.errors import InputError
from warpvec.inputs import read_file

_HEX_COLOR = re.compile(r"#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{3})\b")

_LIST_WORD = re.compile(r"[a-zA-Z]+|#\w+")

_COMMENT = re.compile(r"#(?!\w).*")
"""A comment: from a # that begins no hex code to the end of the line."""


def check_palette(name: str, value: object) -> str | None:
    """Return the normal form of a palette; None stays None."""
    del name
    if isinstance(value, list | tuple) and all(isinstance(each, str) for each in value):
        value = ",".join(value)
    return None if value is None else parse_palette(value)


def parse_palette_or_file(name: str, text: str) -> str:
    """Return the palette ``text`` in its normal form, or the palette in the file of that name."""
    del name
    try:
        return parse_palette(text)
    except InputError:
        return parse_palette(",".join(_colors_in(text)))


def parse_palette(text: Any) -> str:
    """Return a list of colours ("red, #123") in its normal form "#ff0000,#112233", each colour once.

    Raises:
        InputError: ``text`` is not a list of CSS names, "#rgb" or "#rrggbb" with commas between them.
    """
    try:
        colors = [_hex_color(name) for name in text.split(",")]
    except (AttributeError, InputError):
        rule = "must be colours such as 'red,#123,#a0b1c2'"
        raise InputError("palette", rule, show(text), "give one or more, with commas between them") from None
    return ",".join(dict.fromkeys(colors))


def _hex_color(name: str) -> str:
    from warpvec.image.colors import parse_color  # not above: it loads NumPy and Pillow, which the help does without

    return "#" + "".join(f"{round(255 * float(channel)):02x}" for channel in parse_color(name.strip()))


def _colors_in(path: str) -> list[str]:
    """Return the colours in a text file: those of a list of colours, otherwise every "#123" and "#a0b1c2".

    Raises:
        InputError: the file cannot be read, has no colours, or is a list with a word that is not a colour.
    """
    kind = "colours such as red,#a0b1c2, or a file of them"
    if not os.path.lexists(path):
        raise InputError("palette", f"must be {kind}", f"{show(path)}, which is neither", "check the word or the path")
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
