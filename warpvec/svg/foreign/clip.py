"""Find clip paths that cut nothing, such as the frame that drawing programs put around everything."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.loops import Outline
from warpvec.svg.document import local_name
from warpvec.svg.foreign.budget import WorkBudget
from warpvec.svg.foreign.polygons import polygon_of, winding
from warpvec.svg.foreign.shapes import (
    SHAPES,
    Loop,
    bounding_box,
    closed_loops,
    compose,
    curves_of,
    moved,
    read_matrix,
    read_subpaths,
    shape_data,
)
from warpvec.svg.foreign.state import State

_URL = re.compile(r"url\(\s*[\"']?#([^\"')\s]*)[\"']?\s*\)")

_SHAPES_MAX = 64
"""Most shapes of a clip path that are looked at."""

_CURVES_MAX = 256
"""Most curves of such a shape. Frames have four; a file may ask for them at each of its elements."""

CLIP_EFFORT = 2**22
"""Most curves that are compared for a file, some 6 s of work; other work counts as curves. This is enough for a frame
around each of `reader.MAX_ELEMENTS` elements."""

_SHAPE_EFFORT, _LOOP_EFFORT, _OUTLINE_EFFORT = 80, 32, 8
"""Curves that take as long as placing a shape of a clip path, as one of its loops, and as measuring a drawn outline:
120, 50 and 12 microseconds."""

_MARGIN = 1e-4
"""By how much of the longer side a box may reach beyond a clip path: rounded frames, a tenth of a pixel of 1000."""


class Clips:
    """The clip paths of a document, whose elements are ``by_id``, on a canvas of ``size`` pixels."""

    def __init__(self, by_id: Mapping[str, Element], size: tuple[float, float]) -> None:
        self._by_id = by_id
        self._size = size
        self._read: dict[str, list[Loop]] = {}
        self._budget = WorkBudget(CLIP_EFFORT)

    def cut(self, clip_path: str, state: State, outlines: Sequence[Outline], covers_canvas: bool) -> bool:
        """Return whether a clip path may hide a part of what is on the canvas, or ``CLIP_EFFORT`` is used up.

        Args:
            clip_path: the property of an element.
            state: that of the element.
            outlines: what was drawn of it, in pixels.
            covers_canvas: whether the element is the background.
        """
        if clip_path == "none" or not (outlines or covers_canvas):
            return False
        url = _URL.fullmatch(clip_path)
        clip = None if url is None else self._by_id.get(url[1])
        if clip is None or local_name(clip.tag) != "clipPath" or clip.get("clip-path", "none") != "none":
            return True
        if clip.get("clipPathUnits") == "objectBoundingBox" or len(clip) > _SHAPES_MAX:
            return True
        if not self._budget.takes(_OUTLINE_EFFORT * len(outlines)):
            return True
        box = (0.0, 0.0, *self._size) if covers_canvas else self._visible_box(outlines)
        try:
            return not any(_contains(loops, box, _MARGIN * max(self._size)) for loops in self._shapes(clip, state))
        except ValueError:
            return True

    def cut_by_box(
        self, size: tuple[float, float], matrix: NDArray[np.float64], outlines: Sequence[Outline], covers_canvas: bool
    ) -> bool:
        """Return whether a box at the origin hides a part of what is on the canvas, or ``CLIP_EFFORT`` is used up.

        Args:
            size: width and height of the box.
            matrix: from its space to pixels.
            outlines, covers_canvas: as for `cut`.
        """
        if not (outlines or covers_canvas):
            return False
        if min(size) <= 0.0 or not self._budget.takes(_SHAPE_EFFORT + _OUTLINE_EFFORT * len(outlines)):
            return True
        frame = closed_loops(read_subpaths(f"M0 0H{size[0]}V{size[1]}H0z")[0])
        box = (0.0, 0.0, *self._size) if covers_canvas else self._visible_box(outlines)
        return not _contains(moved(frame, matrix), box, _MARGIN * max(self._size))

    def _visible_box(self, outlines: Sequence[Outline]) -> tuple[float, float, float, float]:
        curves = np.concatenate([curves_of(loop) for outline in outlines for loop in _loops(outline)])
        left, top, right, bottom = bounding_box(curves)
        reach = max((outline.stroke.width / 2 for outline in outlines if outline.stroke is not None), default=0.0)
        low, high = (max(left - reach, 0.0), max(top - reach, 0.0)), (right + reach, bottom + reach)
        return *low, min(high[0], self._size[0]), min(high[1], self._size[1])

    def _shapes(self, clip: Element, state: State) -> list[list[Loop]]:
        """Return the loops in pixels of each shape in ``clip``.

        Raises:
            ValueError: a transform cannot be read.
        """
        outer = compose(state.matrix, read_matrix(clip.get("transform", "")))
        shapes = [shape for shape in clip if local_name(shape.tag) in SHAPES and shape.get("clip-path") is None]
        return [loops for shape in shapes if (loops := self._shape(shape, outer, state.viewport))]

    def _shape(self, shape: Element, outer: NDArray[np.float64], viewport: tuple[float, float]) -> list[Loop]:
        data = shape_data(local_name(shape.tag), shape.attrib, *viewport)
        if data not in self._read:
            loops = closed_loops(read_subpaths(data)[0])
            self._read[data] = loops if sum(len(loop.is_line) for loop in loops) <= _CURVES_MAX else []
        loops = self._read[data]
        effort = _SHAPE_EFFORT + _LOOP_EFFORT * len(loops) + sum(len(loop.is_line) for loop in loops)
        if not self._budget.takes(effort):
            return []
        return moved(loops, compose(outer, read_matrix(shape.get("transform", ""))))


def _loops(outline: Outline) -> list[Loop]:
    stops = 3 * np.cumsum(outline.counts)[:-1]
    return [Loop(points, np.zeros(len(points) // 3, np.bool_)) for points in np.split(outline.points, stops)]


def _contains(loops: list[Loop], box: tuple[float, float, float, float], margin: float) -> bool:
    """Return whether a shape contains ``box`` less a ``margin``: it runs around the middle, and no edge runs through.

    Several loops contain it if they run around the middle once in sum. That holds for either fill rule.
    """
    left, top, right, bottom = box
    if not (left < right and top < bottom):
        return True
    low, high = np.array([left, top]) + margin, np.array([right, bottom]) - margin
    polygons = [polygon_of(loop) for loop in loops]
    if not all(np.isfinite(polygon).all() for polygon in polygons):
        return False
    if any(_run_through(polygon, np.roll(polygon, -1, 0), low, high).any() for polygon in polygons):
        return False
    return abs(sum(winding(polygon, (low + high) / 2) for polygon in polygons)) == 1


def _run_through(
    start: NDArray[np.float64], end: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return which edges [K] from ``start`` to ``end`` [K, 2] have a point inside the box (Liang and Barsky)."""
    step = end - start
    with np.errstate(all="ignore"):
        first, second = (low - start) / step, (high - start) / step
    is_still = step == 0.0
    inside = (start > low) & (start < high)
    enter = np.where(is_still, np.where(inside, -np.inf, np.inf), np.minimum(first, second)).max(1)
    leave = np.where(is_still, np.where(inside, np.inf, -np.inf), np.maximum(first, second)).min(1)
    crosses: NDArray[np.bool_] = np.maximum(enter, 0.0) < np.minimum(leave, 1.0)
    return crosses
