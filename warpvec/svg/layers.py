"""Levels of detail of an SVG: its top-level groups, kept or cut out of the text without changing another byte.

A level is a group directly inside the <svg>. In files of warpvec it is a generation, which the ``id`` of the group
states. In other files the groups are numbered from 0 in their order. Anything outside of these groups, such as the
background and the metadata, belongs to every level.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from warpvec.errors import InputError
from warpvec.svg.document import Group, SvgSource, parse_svg

_LINE_END = re.compile(rb"[ \t]*+\r?\n")
_RANGE = re.compile(r"(?P<first>\d{1,9})?(?P<dash>-)?(?P<last>\d{1,9})?", re.ASCII)


def read_layers(svg: SvgSource) -> list[Group]:
    """Return the top-level groups of a file in their order, with whole lines if nothing else is on these.

    Raises:
        InputError: ``svg`` is not an SVG, or is refused as unsafe.
    """
    document = parse_svg(svg)
    data = document.text.encode()
    ranges = [_with_line(data, group.start, group.stop) for group in document.groups]
    return [replace(group, start=a, stop=b) for group, (a, b) in zip(document.groups, ranges, strict=True)]


def parse_levels(text: str, available: Collection[int]) -> set[int]:
    """Return the levels that ``text`` names: "2", "0-3", "-3" (up to 3), "2-" (from 2), or a list of these with commas.

    Raises:
        InputError: ``text`` has another form, or a part of it names no level of ``available`` or ends after the last.
    """
    return {level for part in text.split(",") for level in _levels_of_part(part.strip(), available)}


def select_levels(svg: SvgSource, levels: Collection[int]) -> str:
    """Return the file without the groups of other levels; every other byte stays as it is.

    Raises:
        InputError: ``svg`` is not an SVG, or is refused as unsafe.
    """
    document = parse_svg(svg)
    return _without(document.text.encode(), [layer for layer in read_layers(document) if layer.level not in levels])


def prefixes(svg: SvgSource) -> Iterator[tuple[int, str]]:
    """Yield each level in ascending order, with the file that has this level and the levels before it.

    Raises:
        InputError: ``svg`` is not an SVG, is refused as unsafe, or has no levels.
    """
    document = parse_svg(svg)
    data, layers = document.text.encode(), read_layers(document)
    check_has_levels(layers)
    for level in sorted({layer.level for layer in layers}):
        yield level, _without(data, [layer for layer in layers if layer.level > level])


def check_has_levels(layers: Collection[Group]) -> None:
    """Raise an `InputError` if a file has no levels of detail."""
    if not layers:
        raise InputError("SVG", "must have top-level groups, which are its levels of detail", "none", "group its paths")


def _without(data: bytes, layers: Sequence[Group]) -> str:
    starts, stops = [layer.start for layer in layers], [layer.stop for layer in layers]
    return b"".join(data[a:b] for a, b in zip([0, *stops], [*starts, len(data)], strict=True)).decode()


def _with_line(data: bytes, start: int, stop: int) -> tuple[int, int]:
    """Return ``start`` and ``stop`` moved to the ends of their lines if nothing else is on these lines."""
    line_start = start
    while data[line_start - 1 : line_start] in (b" ", b"\t"):
        line_start -= 1
    line_end = _LINE_END.match(data, stop)
    alone = line_end is not None and data[line_start - 1 : line_start] == b"\n"
    return (line_start, line_end.end()) if line_end is not None and alone else (start, stop)


def _levels_of_part(part: str, available: Collection[int]) -> set[int]:
    match = _RANGE.fullmatch(part)
    if match is None or not (match["first"] or match["last"]):
        raise InputError("levels", "must be like 2, 0-3, -3, 2- or 0,2", repr(part), "count levels from 0")
    most = max(available, default=0)
    first = int(match["first"] or 0)
    last = int(match["last"] or (most if match["dash"] else first))
    found = {level for level in available if first <= level <= last}
    if not found or last > most:
        known = ", ".join(map(str, sorted(available)))
        raise InputError("levels", "must name levels of the file", repr(part), f"choose from {known}")
    return found
