"""Levels of detail of a file: its groups, kept or cut out of the text, so that what stays is the same to the byte.

A level is a group that stands directly in the <svg>: a generation in a file of warpvec's, which says so in its ``id``,
and in any other file the groups in their order, from 0. What stands there outside of groups, the background and the
metadata, belongs to every level.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from xml.parsers import expat

from warpvec.errors import InputError
from warpvec.svg.scan import SVG_NAMESPACE, read_text, scan

_LAYER_ID = re.compile(r"layer-\d{1,9}-generation-(\d{1,9})", re.ASCII)
_TAG = re.compile(rb"""<(?:[^>"']|"[^"]*"|'[^']*')*+>""")
_LINE_END = re.compile(rb"[ \t]*+\r?\n")
_RANGE = re.compile(r"(?P<first>\d{1,9})?(?P<dash>-)?(?P<last>\d{1,9})?", re.ASCII)


@dataclass(frozen=True)
class Layer:
    """A group at the top of a file.

    Attributes:
        level: its level of detail.
        start, stop: the bytes of UTF-8 that it takes, with the white space that puts it on lines of its own.
        path_count: <path> elements in it.
    """

    level: int
    start: int
    stop: int
    path_count: int


def layer_level(identifier: str | None, index: int) -> int:
    """The level of the group ``identifier``, which is number ``index`` of those at the top of its file."""
    match = _LAYER_ID.fullmatch(identifier or "")
    return int(match[1]) if match else index


def read_layers(svg: str | bytes) -> list[Layer]:
    """The groups at the top of a file, in its order.

    Raises:
        InputError: not an SVG, or refused as unsafe.
    """
    text = read_text(svg)
    scan(text)
    return _LayerFinder(text.encode()).layers


def parse_levels(text: str, available: Collection[int]) -> set[int]:
    """The levels that ``text`` names: "2", "0-3", "-3" (up to 3), "2-" (from 2), or a list of these with commas.

    Raises:
        InputError: it says something else, or a part of it names no level of ``available``.
    """
    return {level for part in text.split(",") for level in _levels_of_part(part.strip(), available)}


def select_levels(svg: str | bytes, levels: Collection[int]) -> str:
    """The file without the groups of other levels; all else is as it was, to the byte.

    Raises:
        InputError: not an SVG, or refused as unsafe.
    """
    text = read_text(svg)
    return _without(text.encode(), [layer for layer in read_layers(text) if layer.level not in levels])


def prefixes(svg: str | bytes) -> Iterator[tuple[int, str]]:
    """Each level in ascending order, and the file with this level and those before it.

    Raises:
        InputError: not an SVG, refused as unsafe, or without levels.
    """
    text = read_text(svg)
    data, layers = text.encode(), read_layers(text)
    check_has_levels(layers)
    for level in sorted({layer.level for layer in layers}):
        yield level, _without(data, [layer for layer in layers if layer.level > level])


def check_has_levels(layers: Collection[Layer]) -> None:
    """Check that a file has any.

    Raises:
        InputError: it has none.
    """
    if not layers:
        raise InputError("SVG must have groups at its top to have levels of detail, this one has none; group its paths")


def _without(data: bytes, layers: Sequence[Layer]) -> str:
    starts, stops = [layer.start for layer in layers], [layer.stop for layer in layers]
    return b"".join(data[a:b] for a, b in zip([0, *stops], [*starts, len(data)], strict=True)).decode()


class _LayerFinder:
    """Where the groups begin and end in the bytes ``data`` of a file that has been found harmless."""

    def __init__(self, data: bytes) -> None:
        self.layers: list[Layer] = []
        self._data = data
        self._depth = self._path_count = 0
        self._group: tuple[int, int] | None = None
        self._parser = expat.ParserCreate("utf-8", namespace_separator=" ")
        self._parser.StartElementHandler = self._start_element
        self._parser.EndElementHandler = self._end_element
        self._parser.Parse(data, True)

    def _start_element(self, name: str, attributes: dict[str, str]) -> None:
        namespace, _, local_name = name.rpartition(" ")
        if self._depth == 1 and local_name == "g" and namespace in ("", SVG_NAMESPACE):
            level = layer_level(attributes.get("id"), len(self.layers))
            self._group, self._path_count = (level, self._parser.CurrentByteIndex), 0
        self._path_count += local_name == "path"
        self._depth += 1

    def _end_element(self, _: str) -> None:
        self._depth -= 1
        if self._depth == 1 and self._group is not None:
            level, start = self._group
            stop = _end_of_element(self._data, start, self._parser.CurrentByteIndex)
            self.layers.append(Layer(level, *_with_line(self._data, start, stop), self._path_count))
            self._group = None


def _end_of_element(data: bytes, start: int, end_tag: int) -> int:
    """Where the element whose tags begin at ``start`` and ``end_tag`` is over; the same tag may be both."""
    opening = _TAG.match(data, start)
    if opening is not None and opening[0].endswith(b"/>"):
        return opening.end()
    return data.index(b">", end_tag) + 1


def _with_line(data: bytes, start: int, stop: int) -> tuple[int, int]:
    """``start`` and ``stop`` moved to the ends of their lines, where nothing else stands on these."""
    line_start = start
    while data[line_start - 1 : line_start] in (b" ", b"\t"):
        line_start -= 1
    line_end = _LINE_END.match(data, stop)
    alone = line_end is not None and data[line_start - 1 : line_start] == b"\n"
    return (line_start, line_end.end()) if line_end is not None and alone else (start, stop)


def _levels_of_part(part: str, available: Collection[int]) -> set[int]:
    match = _RANGE.fullmatch(part)
    if match is None or not (match["first"] or match["last"]):
        raise InputError(f"levels must be like 2, 0-3, -3, 2- or 0,2, got {part!r}; levels count from 0")
    first = int(match["first"] or 0)
    last = int(match["last"] or (max(available, default=0) if match["dash"] else first))
    found = {level for level in available if first <= level <= last}
    if not found:
        known = ", ".join(map(str, sorted(available)))
        raise InputError(f"levels must name levels of the file, got {part!r}; it has {known}")
    return found
