"""Count the segments of path data of any writer, as editors show them, and the numbers that shape them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

from warpvec.svg.units import NUMBER

LETTERS = "MLHVCSQTAmlhvcsqta"
"""Commands that draw, or move."""

CLOSED = 1e-6
"""Longest line in user units that closes a path without being a segment: Inkscape joins its ends."""

_GAP = r"[\s,]*+"

_NUMBERS = re.compile(NUMBER)

# The two flags of an arc are single digits that need no separator: "a1 1 0 01.5.5". Where there is no arc, a whole
# number is skipped and not a digit, so that the time stays linear.
_ARC = re.compile(f"{_GAP.join([NUMBER] * 3 + ['[01]'] * 2)}{_GAP}({NUMBER}){_GAP}({NUMBER})|{NUMBER}")

# A command without numbers draws nothing, unless it closes a path.
_COMMAND = re.compile(r"([MLHVCSQTA])([^MLHVCSQTAZ\d]*+\d[^MLHVCSQTAZ]*+)|Z", re.IGNORECASE)

# Of an arc, the two that `_ARC` keeps.
_NUMBERS_PER_SEGMENT = {"A": 2, "M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2}

_PARAMETERS_PER_SEGMENT = {"A": 7, "M": 2, "L": 2, "H": 2, "V": 2, "C": 6, "S": 6, "Q": 4, "T": 4}

_NUMBERS_AT_A_TIME = 3072
"""Numbers of a command that are in memory together: there may be millions. All counts of a segment divide this."""


class PathCounts(NamedTuple):
    """Counts of path data.

    Attributes:
        segments: lines, curves and arcs, and the lines of more than ``CLOSED`` that close a subpath.
        parameters: 2 for each line, 4 for a quadratic, 6 for a cubic, 7 for an arc; moves and closes are free.
    """

    segments: int
    parameters: int


def count_path(path_data: str) -> PathCounts:
    """Count the segments of any SVG path data, and their parameters."""
    pen = _Pen()
    segments = sum(pen.draw(match[1], match[2]) for match in _COMMAND.finditer(path_data))
    return PathCounts(segments, pen.parameters)


def count_segments(path_data: str) -> int:
    """Count the lines, curves and arcs of any SVG path data, and the lines of more than ``CLOSED`` that close them."""
    return count_path(path_data).segments


@dataclass
class _Pen:
    """The place that path data have reached, the place where their subpath began, and the parameters so far."""

    x: float = 0.0
    y: float = 0.0
    start_x: float = 0.0
    start_y: float = 0.0
    parameters: int = 0

    def draw(self, letter: str | None, numbers: str) -> int:
        """Follow a command, None to close the subpath, and return how many segments it has."""
        if letter is None:
            is_far = max(abs(self.x - self.start_x), abs(self.y - self.start_y)) > CLOSED
            self.x, self.y = self.start_x, self.start_y
            return int(is_far)
        kind, is_relative, is_move, count = letter.upper(), letter.islower(), letter in "Mm", 0
        for across, down in _ends(kind, numbers):
            if is_move:
                self._go(across[:1], down[:1], is_relative)
                self.start_x, self.start_y, is_move = self.x, self.y, False
                across, down = across[1:], down[1:]  # the pairs after the first one are lines
            self._go(across, down, is_relative)
            count += len(across or down)
        self.parameters += _PARAMETERS_PER_SEGMENT[kind] * count
        return count

    def _go(self, across: list[float], down: list[float], is_relative: bool) -> None:
        """Follow steps, which are distances or places."""
        if is_relative:
            self.x, self.y = self.x + sum(across), self.y + sum(down)
        else:
            self.x, self.y = (across or [self.x])[-1], (down or [self.y])[-1]


def _ends(kind: str, numbers: str) -> Iterator[tuple[list[float], list[float]]]:
    """Yield x and y of the ends of a command's segments, some at a time; none where the command keeps x or y."""
    size = _NUMBERS_PER_SEGMENT[kind]
    if len(numbers) <= _NUMBERS_AT_A_TIME and kind != "A":
        yield _columns(kind, size, [float(text) for text in _NUMBERS.findall(numbers)])
        return
    texts = _arc_ends(numbers) if kind == "A" else (match[0] for match in _NUMBERS.finditer(numbers))
    while values := [float(text) for text in islice(texts, _NUMBERS_AT_A_TIME)]:
        yield _columns(kind, size, values)


def _arc_ends(numbers: str) -> Iterator[str]:
    for match in _ARC.finditer(numbers):
        if match[1] is not None:
            yield from match.groups()


def _columns(kind: str, size: int, values: list[float]) -> tuple[list[float], list[float]]:
    if kind == "H":
        return values, []
    if kind == "V":
        return [], values
    down = values[size - 1 :: size]
    return values[size - 2 :: size][: len(down)], down
