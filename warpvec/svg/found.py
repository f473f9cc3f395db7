"""Say in words what an SVG consists of: "3 circles, 12 strokes (2.0 px, round), 4 paths; 148 parameters"."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from warpvec.checks import counted
from warpvec.svg.looks import Look
from warpvec.svg.units import parse_length

SHAPE_KINDS = {"circle": "circle", "ellipse": "ellipse", "rect": "rectangle", "stroke": "stroke", "path": "path"}
"""Kind of a shape -> its name. A stroke is a centre line without a fill; a form is one, filled or stroked."""

_SAME_WIDTH = 0.05
"""Widths in pixels that differ by less are written alike."""


def shape_kind(element: str, look: Look) -> str:
    """Return the kind of a shape, a key of ``SHAPE_KINDS``."""
    if element in ("circle", "ellipse", "rect"):
        return element
    return "stroke" if look.is_stroked and look.fill == "none" else "path"


def shape_counts(shapes: Mapping[tuple[str, Look], int]) -> dict[str, int]:
    """Return how many shapes of each kind there are, by ``SHAPE_KINDS``; ``shapes`` counts those alike."""
    counts = dict.fromkeys(SHAPE_KINDS, 0)
    for (kind, _), count in shapes.items():
        counts[kind] += count
    return counts


def stroke_looks(shapes: Mapping[tuple[str, Look], int], scale: float) -> list[dict[str, Any]]:
    """Return the looks of strokes, those with the most first: ``width`` in pixels, ``cap``, ``join``, ``count``.

    Args:
        shapes: counts of shapes that are alike.
        scale: pixels of a user unit.
    """
    counts: Counter[tuple[float, str, str]] = Counter()
    for (_, look), count in shapes.items():
        if look.is_stroked:
            counts[round(scale * parse_length(look.width, 0.0), 3), look.cap, look.join] += count
    return [{"width": width, "cap": cap, "join": join, "count": n} for (width, cap, join), n in counts.most_common()]


def found_words(shapes: Mapping[tuple[str, Look], int], scale: float, parameters: int) -> str:
    """Return what there is in words; the width of strokes stands in brackets, and their ends if they are alike.

    Args:
        shapes: counts of shapes that are alike.
        scale: pixels of a user unit.
        parameters: the numbers that shape them.
    """
    parts = kind_words(shapes, scale).values()
    return f"{', '.join(parts) or counted(0, 'path')}; {counted(parameters, 'parameter')}"


def kind_words(shapes: Mapping[tuple[str, Look], int], scale: float) -> dict[str, str]:
    """Return what there is of each kind of ``SHAPE_KINDS`` in words, without kinds of which there is none."""
    parts = {}
    for kind, count in shape_counts(shapes).items():
        own = {key: n for key, n in shapes.items() if key[0] == kind and key[1].is_stroked}
        if count:
            parts[kind] = counted(count, SHAPE_KINDS[kind]) + _brackets(kind, count, sum(own.values()), own, scale)
    return parts


def _brackets(kind: str, count: int, stroked: int, own: Mapping[tuple[str, Look], int], scale: float) -> str:
    looks = stroke_looks(own, scale)
    if not looks:
        return ""
    widths, caps = [look["width"] for look in looks], {look["cap"] for look in looks}
    low, high = min(widths), max(widths)
    text = f"{low:.1f} px" if high - low < _SAME_WIDTH else f"{low:.1f} to {high:.1f} px"
    if kind == "stroke":
        return f" ({text}, {caps.pop()})" if len(caps) == 1 and caps != {"butt"} else f" ({text})"
    return f" (stroked, {text})" if stroked == count else f" ({stroked} stroked, {text})"
