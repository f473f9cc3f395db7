"""Path data of warpvec's own files: written in few characters, and read back exactly.

A path has its loops one after another. The first one has an absolute start, and so has one after a point; the others
are relative to the start of the loop before, or to its end if it is open. Numbers are whole *ticks*, units of the last
decimal: differences of rounded positions and not rounded differences, so that the sums of decimals are exact.

Readers add binary numbers, in which tenths are rounded: a loop may end 1e-14 beside its start, and the line that closes
it may cross the loop. Data that *closes exactly* has the last curve of such a loop, and the start of the next one, in
absolute numbers.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.svg.arcs import ROWS_MAX, Arc, arc_of, arc_rows, runs

Ticks = NDArray[np.int64]

_NUMBER = r"(?>-?(?>\d{1,15}(?>\.\d{1,6})?|\.\d{1,6}))"
_ARGUMENTS = {"c": 6, "s": 4, "l": 2, "h": 1, "v": 1, "a": 7}
_KEPT = {
    "c": (True,) * 6,
    "s": (False, False, True, True, True, True),
    "l": (False, False, False, False, True, True),
    "h": (False, False, False, False, True, False),
    "v": (False, False, False, False, False, True),
    "a": (False, False, False, False, True, True),  # not written: the arc has numbers of its own
}
"""Letter of a command -> which of the segment's six coordinates it states: leaving handle, arriving handle, end."""

_ARC = rf"a(?>[ ]?{_NUMBER}){{2}} 0 [01] [01](?>[ ]?{_NUMBER}){{2}}"
_REPEATED = (rf"{letter}(?>(?>[ ]?{_NUMBER}){{{count}}})+" for letter, count in _ARGUMENTS.items() if letter != "a")
_COMMANDS = "|".join([*_REPEATED, _ARC])
_LINE = rf"(?>[ ]?{_NUMBER}){{2}}(?>{_COMMANDS})*"
_CLOSED = rf"{_LINE}(?>C(?>[ ]?{_NUMBER}){{6}}|A{_ARC[1:]})?z"
_OWN_DATA = re.compile(rf"M{_CLOSED}(?>[Mm]{_CLOSED})*", re.ASCII)
_OWN_STROKE_DATA = re.compile(rf"M(?>{_CLOSED}|{_LINE})(?>[Mm](?>{_CLOSED}|{_LINE}))*", re.ASCII)
_COMMAND = re.compile(rf"([MmCcslhvAaz])((?>[ ]?{_NUMBER})*)", re.ASCII)
_DOTS = "h.01", "h.1"
"""How a point is stated, in files with decimals and in those of whole numbers: some programs draw no line of length 0.
A line that has this length is stated as an "l"."""

_DOT = re.compile(rf"([Mm](?>[ ]?{_NUMBER}){{2}})h\.0?1(?=[Mm]|$)", re.ASCII)

OWN_NUMBER = re.compile(_NUMBER, re.ASCII)
"""A number as warpvec writes it."""


def format_number(ticks: int, decimals: int) -> str:
    """Return ``ticks / 10**decimals`` in the fewest characters that SVG allows: "12.5", "-.25", "0"."""
    whole, fraction = divmod(abs(ticks), 10**decimals)
    digits = f"{fraction:0{decimals}d}".rstrip("0")
    text = (str(whole) if whole or not digits else "") + ("." + digits if digits else "")
    return "-" + text if ticks < 0 else text


def format_curves(
    ticks: Ticks, first: NDArray[np.int64], decimals: int, is_closing: NDArray[np.bool_] | None = None
) -> list[str]:
    """Return the data of paths of one loop of cubics each, which a line may close.

    Cubics of no length are left out.

    Args:
        ticks: control points [R, 3, 2] of the cubics of all paths.
        first: first row of each path [N + 1]; the last entry is R.
        decimals: of the numbers.
        is_closing: rows [R] that are lines to the start of their path, which "z" draws; None for none.
    """
    anchor, start = ticks[:, 0], first[:-1]
    following = np.roll(anchor, -1, axis=0)
    following[first[1:] - 1] = anchor[start]
    relative = (np.stack([ticks[:, 1], ticks[:, 2], following], axis=1) - anchor[:, None]).reshape(-1, 6)
    drawn = (relative != 0).any(axis=1)
    if is_closing is not None:
        drawn &= ~is_closing
    counts = np.add.reduceat(drawn, start, dtype=np.int64)
    # A path that is a single point keeps one cubic, because "c" needs arguments.
    drawn[start[counts == 0]] = True
    heads = _number_lists(anchor[start].ravel(), np.full(len(start), 2), decimals)
    tails = _number_lists(relative[drawn].ravel(), 6 * np.maximum(counts, 1), decimals)
    return [f"M{head}c{tail}z" for head, tail in zip(heads, tails, strict=True)]


def format_closed_curves(
    ticks: Ticks, first: NDArray[np.int64], decimals: int, is_closing: NDArray[np.bool_]
) -> list[str]:
    """Return the data of paths of one loop each, whose rows ``is_closing`` [R] are lines to the start that "z" draws.

    It is that of `format_path`, but found for all paths at once, which takes a tenth of the time. Only paths with
    implied handles ("s") are written one by one. A path without these that a line closes goes round the shorter way;
    of two equally short texts, the first in the alphabet is taken.

    Args:
        ticks, first, decimals: as `format_curves`.
        is_closing: rows that are lines; only the last row of a path may be one.
    """
    data = format_curves(ticks, first, decimals, is_closing)
    if is_closing.any():
        other = format_curves(_reversed_paths(ticks, first), first, decimals, is_closing)
        for path in is_closing[first[1:] - 1].nonzero()[0].tolist():
            data[path] = min(data[path], other[path], key=lambda text: (len(text), text))
    for path in _with_implied_handles(ticks, first, is_closing):
        rows = slice(first[path], first[path + 1])
        data[path] = format_path([Loop(ticks[rows], is_closing[rows])], decimals)
    return data


def _reversed_paths(ticks: Ticks, first: NDArray[np.int64]) -> Ticks:
    """Return the control points [R, 3, 2] of paths that a line closes, with their cubics in the opposite order.

    Args:
        ticks: control points; the last row of each path is the line, of which only the anchor counts.
        first: first row of each path [N + 1]; the last entry is R.
    """
    start, last = 3 * first[:-1], 3 * (first[1:] - 1)
    owner = np.repeat(np.arange(len(start)), 3 * np.diff(first))
    place = np.arange(3 * len(ticks))
    source = start[owner] + last[owner] - place
    source = np.where(place > last[owner], last[owner], source)  # handles of lines
    return ticks.reshape(-1, 2)[source].reshape(ticks.shape)


def _with_implied_handles(ticks: Ticks, first: NDArray[np.int64], is_closing: NDArray[np.bool_]) -> list[int]:
    """Return the paths in which the leaving handle of a cubic mirrors the arriving one of the row before."""
    mirrored = 2 * ticks[1:, 0] - ticks[:-1, 2]
    is_implied = (ticks[1:, 1] == mirrored).all(1) & ~is_closing[1:]
    is_implied[first[1:-1] - 1] = False  # the row before is of another path
    found = np.searchsorted(first, is_implied.nonzero()[0] + 1, side="right") - 1
    return np.unique(found).tolist()


class Loop(NamedTuple):
    """A loop of path data.

    Attributes:
        ticks: control points [S, 3, 2] of its rows, in ticks.
        is_line: which rows are lines [S].
        is_open: whether it is an open line, of which the last row is only the end.
    """

    ticks: Ticks
    is_line: NDArray[np.bool_]
    is_open: bool = False


def format_path(loops: Sequence[Loop], decimals: int, has_arcs: bool = True, closes_exactly: bool = False) -> str:
    """Return the data of one path from its loops.

    Cubics of no length are left out, and so is a line that closing the loop draws. Handles that mirror the one before
    are implied ("s"). Cubics that are those of an arc are stated as that if the data may have arcs. Paths of closed
    loops close exactly if asked.
    """
    text, at = [], None
    closes_exactly = closes_exactly and not any(loop.is_open for loop in loops)
    for loop in loops:
        start = loop.ticks[0, 0]
        if at is None or (closes_exactly and _misses(at, (start - at)[None], start, decimals)):
            text.append("M" + _numbers(start, decimals))
        else:
            text.append("m" + _numbers(start - at, decimals))
        if loop.is_open:
            text.append(_line_commands(loop, decimals, has_arcs))
        else:
            text.append(_loop_commands(loop, decimals, has_arcs, closes_exactly))
        at = loop.ticks[-1, 0] if loop.is_open else start
        if text[-1] in _DOTS:
            at = None  # the pen is beside the point
    return "".join(text)


def _misses(start: Ticks, steps: Ticks, end: Ticks, decimals: int) -> bool:
    """Return whether the sum of binary numbers of ``steps`` [K, 2] from ``start`` on is beside ``end``, in ticks."""
    summed = np.cumsum(np.concatenate([start[None], steps]) / 10.0**decimals, axis=0)[-1]
    return bool((summed != end / 10.0**decimals).any())


def with_points(data: str) -> str:
    """Return ``data`` of a stroke with points as lines of no length, so that they have no decimals."""
    return _DOT.sub(r"\1h0", data)


def is_own_data(data: str, is_stroke: bool = False) -> bool:
    """Return whether ``data`` has only what this module writes; that of a stroke may have open lines."""
    return (_OWN_STROKE_DATA if is_stroke else _OWN_DATA).fullmatch(data) is not None


def decimals_of(data: str) -> int:
    """Return the largest number of decimals in own ``data``."""
    return max((len(word.rpartition(".")[2]) for word in OWN_NUMBER.findall(data) if "." in word), default=0)


def read_loops(data: str, decimals: int) -> list[Loop]:
    """Return the loops of own ``data``.

    The handles of lines are at thirds, but rounded down to ticks; only the anchors of a line count.
    """
    loops: list[Loop] = []
    at, reader = np.zeros(2, np.int64), None
    for letter, numbers in _COMMAND.findall(data):
        values = _ticks_of(numbers, decimals)
        if letter in "Mm":
            if reader is not None:
                at = reader.at
                loops.append(reader.opened())
            at = at + values if letter == "m" else values
            reader = _LoopReader(at)
        elif letter == "z":
            assert reader is not None
            loops.append(reader.closed())
            at, reader = reader.at, None
        else:
            assert reader is not None
            reader.draw(letter, values.reshape(-1, _ARGUMENTS[letter.lower()]))
    return loops if reader is None else [*loops, reader.opened()]


class _LoopReader:
    """Adds up the commands of one loop, and knows where it is ``at``."""

    def __init__(self, start: Ticks) -> None:
        self._start = self.at = start
        self._mirrored = start  # where the leaving handle of an "s" lies
        self._rows: list[tuple[Ticks, Ticks, Ticks]] = []
        self._is_line: list[bool] = []

    def draw(self, letter: str, values: Ticks) -> None:
        """Add the segments of a command with ``values`` [K, its number of arguments]."""
        for row in values:
            if letter == "A":
                self._draw_arc(np.concatenate([row[:5], row[5:] - self.at]))
            elif letter == "a":
                self._draw_arc(row)
            elif letter == "C":
                self.draw("c", (row - np.tile(self.at, 3))[None])
            elif letter in "cs":
                leaving = self.at + row[:2] if letter == "c" else self._mirrored
                self._add(leaving, self.at + row[-4:-2], self.at + row[-2:], False)
            else:
                step = {"l": row, "h": np.array([*row, 0]), "v": np.array([0, *row])}[letter]
                self._add(self.at + step // 3, self.at + 2 * step // 3, self.at + step, True)

    def _draw_arc(self, row: Ticks) -> None:
        """Add the cubics of an arc; one without a radius or a length is a line."""
        radius, step = int(row[0]), row[5:]
        if radius <= 0 or not step.any():
            self.draw("l", step[None])
            return
        start = self.at
        rows = start + arc_rows(step, Arc(radius, bool(row[3]), bool(row[4])))
        for leaving, arriving, end in zip(rows[:, 1], rows[:, 2], [*rows[1:, 0], start + step], strict=True):
            self._add(leaving, arriving, end, False)
        self._mirrored = self.at

    def closed(self) -> Loop:
        """Return the loop, with a line to its start if it does not end there."""
        if (self.at != self._start).any() or not self._rows:
            self.draw("l", (self._start - self.at)[None])
        return Loop(np.stack([np.stack(row) for row in self._rows]), np.array(self._is_line))

    def opened(self) -> Loop:
        """Return the open line; a line back to its start is the row of its end."""
        self.draw("l", (self._start - self.at)[None])
        return Loop(np.stack([np.stack(row) for row in self._rows]), np.array(self._is_line), is_open=True)

    def _add(self, leaving: Ticks, arriving: Ticks, end: Ticks, is_line: bool) -> None:
        self._rows.append((self.at, leaving, arriving))
        self._is_line.append(is_line)
        self._mirrored = end if is_line else 2 * end - arriving
        self.at = end


def _relative(ticks: Ticks) -> Ticks:
    """Return the handles and the end of each row of a loop, relative to its anchor [S, 3, 2]."""
    ends = np.roll(ticks[:, 0], -1, axis=0)
    return np.concatenate([ticks[:, 1:] - ticks[:, :1], (ends - ticks[:, 0])[:, None]], 1)


def _drawn_rows(relative: Ticks, is_line: NDArray[np.bool_]) -> list[int]:
    has_end, has_length = relative[:, 2].any(1), relative.any((1, 2))
    return np.flatnonzero(np.where(is_line, has_end, has_length)).tolist()


def _loop_commands(loop: Loop, decimals: int, has_arcs: bool, closes_exactly: bool) -> str:
    relative, is_line = _relative(loop.ticks), loop.is_line
    rows = _drawn_rows(relative, is_line)
    is_closed_by_line = bool(rows) and bool(is_line[rows[-1]])
    if is_closed_by_line:
        rows.pop()  # "z" draws it
    if not rows:  # a single point, or a line there and back
        return ("c" + _numbers(relative[0].ravel(), decimals) if not is_line[0] else "") + "z"
    arcs = _arcs(relative, is_line) if has_arcs else {}
    rows = _without_rest_of(arcs, rows)
    commands = _commands(relative, is_line, rows, arcs, decimals)
    if closes_exactly and not is_closed_by_line:
        start, last = loop.ticks[0, 0], rows[-1]
        steps = np.stack([arcs[row][1] if row in arcs else relative[row, 2] for row in rows])
        if _misses(start, steps, start, decimals):
            absolute = (loop.ticks[last, 0] + relative[last]).ravel()
            of_arc = last in arcs and _arc_command(start, arcs[last][2], decimals, "A")
            commands[-1] = of_arc or "C" + _numbers(absolute, decimals)
    return "".join(commands) + "z"


def _line_commands(loop: Loop, decimals: int, has_arcs: bool) -> str:
    """Return the commands of an open line. A point is one of ``_DOTS``, so that renderers draw its caps."""
    relative, is_line = _relative(loop.ticks)[:-1], loop.is_line[:-1]
    arcs = _arcs(relative, is_line) if has_arcs else {}
    rows = _without_rest_of(arcs, _drawn_rows(relative, is_line))
    found = "".join(_commands(relative, is_line, rows, arcs, decimals)) if rows else ""
    if not found:
        return _DOTS[0] if decimals else _DOTS[1]
    return f"l{found[1:]} 0" if found in _DOTS else found


def _without_rest_of(arcs: dict[int, tuple[int, Ticks, Arc]], rows: list[int]) -> list[int]:
    """Return the ``rows`` that have a command: of an arc only its first."""
    of_arcs = {row for first, (stop, *_) in arcs.items() for row in range(first + 1, stop)}
    return [row for row in rows if row not in of_arcs]


def _commands(
    relative: Ticks,
    is_line: NDArray[np.bool_],
    rows: list[int],
    arcs: dict[int, tuple[int, Ticks, Arc]],
    decimals: int,
) -> list[str]:
    """Return the command of each of ``rows``, which are all of ``relative`` [S, 3, 2] that have one."""
    is_arc = np.array([row in arcs for row in rows])
    letters, words = _segments(relative[rows], is_line[rows], is_arc, decimals)
    text, last = [], ""
    for row, letter, numbers in zip(rows, letters, words, strict=True):
        # A repeated letter is left out; the number after it then needs something that separates it.
        if letter == "a":
            text.append(_arc_command(*arcs[row][1:], decimals))
        else:
            text.append(letter + numbers if letter != last else numbers if numbers[0] == "-" else " " + numbers)
        last = letter
    return text


def _segments(
    relative: Ticks, is_line: NDArray[np.bool_], is_arc: NDArray[np.bool_], decimals: int
) -> tuple[list[str], list[str]]:
    """Return the letter and the numbers of each segment that follows the one before, which may be an arc.

    The leaving handle of a curve after a curve is implied if it mirrors the arriving one.
    """
    mirrored = np.zeros((len(relative), 2), np.int64)
    mirrored[1:] = np.where((is_line | is_arc)[:-1, None], 0, relative[:-1, 2] - relative[:-1, 1])
    is_implied = (relative[:, 0] == mirrored).all(1)
    x, y = relative[:, 2].T
    on_line = np.where(y == 0, "h", np.where(x == 0, "v", "l"))
    letters = np.where(is_arc, "a", np.where(is_line, on_line, np.where(is_implied, "s", "c"))).tolist()
    kept = np.array([_KEPT[letter] for letter in letters])
    values = relative.reshape(-1, 6)[kept]
    return letters, _number_lists(values, kept.sum(1), decimals)


def arcs_of(loop: Loop) -> dict[int, tuple[int, Ticks, Arc]]:
    """Return by their first row the arcs that a file states for rows of ``loop``.

    Of each: the row after the last, the place of its end from its start, and the arc. A whole circle is two halves.
    """
    rows = len(loop.ticks) - loop.is_open
    return _arcs(_relative(loop.ticks)[:rows], loop.is_line[:rows])


def _arcs(relative: Ticks, is_line: NDArray[np.bool_]) -> dict[int, tuple[int, Ticks, Arc]]:
    """Return by their first row the arcs of a line: the row after the last, the place of the end, and the arc.

    A whole circle is two halves.
    """
    found: dict[int, tuple[int, Ticks, Arc]] = {}
    ends = relative[:, 2].cumsum(0)
    starts = ends - relative[:, 2]
    rows = np.concatenate([starts[:, None], starts[:, None] + relative[:, :2]], 1)
    for first, stop in runs(rows.astype(np.float64), is_line, ends.astype(np.float64)):
        row = first
        while row < stop:
            for last in _stops(row, stop, is_whole=bool((starts[row] == ends[stop - 1]).all())):
                step = ends[last - 1] - starts[row]
                arc = arc_of(rows[row:last] - starts[row], step) if step.any() else None
                if arc is not None:
                    found[row] = last, step, arc
                    break
            row = found[row][0] if row in found else row + 1
    return found


def _stops(row: int, stop: int, is_whole: bool) -> list[int]:
    """Return the rows before which an arc from ``row`` on may end, the one to be tried first at the beginning."""
    longest = list(range(min(stop, row + ROWS_MAX), row, -1))
    return [row + (stop - row) // 2, *longest] if is_whole and stop - row >= 4 else longest


def _arc_command(step: Ticks, arc: Arc, decimals: int, letter: str = "a") -> str:
    radius, end = format_number(arc.radius, decimals), _numbers(step, decimals)
    space = "" if end[0] == "-" else " "
    return f"{letter}{radius} {radius} 0 {int(arc.is_large)} {int(arc.is_clockwise)}{space}{end}"


def _ticks_of(numbers: str, decimals: int) -> Ticks:
    values = np.array(OWN_NUMBER.findall(numbers), np.float64) * 10**decimals
    return values.round().astype(np.int64)


def _numbers(ticks: Ticks, decimals: int) -> str:
    """Format a few ``ticks`` [N] as an SVG number list; `_number_lists` takes longer to begin."""
    text, had_point = "", False
    for value in np.asarray(ticks).tolist():
        word = format_number(value, decimals)
        needs_space = text and word[0] != "-" and not (word[0] == "." and had_point)
        text += " " + word if needs_space else word
        had_point = "." in word
    return text


def _number_lists(ticks: Ticks, counts: NDArray[np.int64], decimals: int) -> list[str]:
    """Format ``ticks`` [sum of ``counts``] as SVG number lists of ``counts`` [N] numbers each, none of them empty.

    Two numbers need no space between them if the second starts with a minus sign, or with a point while the first
    already contains one.
    """
    per_unit = 10**decimals
    distinct, index = np.unique(ticks, return_inverse=True)
    words = [format_number(value, decimals) for value in distinct.tolist()]
    vocabulary = np.array([*words, *(" " + word for word in words)], dtype=object)
    has_point = ticks % per_unit != 0
    separates = ticks < 0
    separates[1:] |= (ticks[1:] < per_unit) & has_point[1:] & has_point[:-1]
    stops = counts.cumsum()
    starts = stops - counts
    separates[starts] = True
    chosen = vocabulary[index + np.where(separates, 0, len(words))].tolist()
    return ["".join(chosen[start:stop]) for start, stop in zip(starts.tolist(), stops.tolist(), strict=True)]
