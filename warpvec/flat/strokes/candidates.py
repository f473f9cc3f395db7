"""The shapes of a drawing that may be strokes: most of their outline has the same distance from the other side."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import torch

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.outline_samples import control_points, cubic_points, segment_loops
from warpvec.flat.simplification.path_removal import loop_areas
from warpvec.flat.strokes.center_lines import center_lines, join_of
from warpvec.flat.strokes.inner_disks import boundary_of, inner_disks, may_have_width, stroke_width
from warpvec.flat.strokes.line_fitting import Rows, fit_line
from warpvec.flat.strokes.stroke import Stroke
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import BUTT, MITER, ROUND


def stroke_candidates(scene: Scene, generation_count: int, outline_width: float = math.inf) -> dict[int, Stroke]:
    """Return the connected parts of the paths of a scene of filled cubics that may be strokes.

    They go by the generation that each has as a path of its own; see `set_apart`. Paths of very many segments are left
    out, and bars at least as wide as ``outline_width`` pixels where no round pen shows.
    """
    parts, found = _parts_by_color(scene), dict[int, Stroke]()
    for of_color in parts.values():
        are_outlines = _are_outlines([part for own in of_color.values() for part in own])
        for path, own in of_color.items():
            strokes = [each for each in _strokes_of(own) if not are_outlines or each.width < outline_width]
            first = int(scene.generation[path]) + generation_count
            found |= {first + k * generation_count: stroke for k, stroke in enumerate(strokes)}
    return found


def _parts_by_color(scene: Scene) -> dict[tuple[float, ...], dict[int, list[_Part]]]:
    """Return the connected parts of each path that may be strokes, by the colour of the path and its number."""
    found = dict[tuple[float, ...], dict[int, list[_Part]]]()
    counts = torch.bincount(scene.structure.segment_path, minlength=len(scene)).tolist()
    for path in range(len(scene)):
        is_flat = scene.gradients is None or int(scene.gradients.kind[path]) == FLAT
        if is_flat and counts[path] <= STROKES.segments_max:
            color = tuple(torch.round(255.0 * scene.color[path]).tolist())
            found.setdefault(color, {})[path] = _parts_of(scene.select(torch.tensor([path])))
    return found


class _Part(NamedTuple):
    """A connected part of a path that may be a stroke.

    Attributes:
        loops: its loops, numbered within the path.
        lines: the rows of its centre lines; none if it is no stroke.
        width, cap, join: as in `Strokes`.
        length: of its centre lines, in pixels.
        cap_count: number of ends that show their cap.
    """

    loops: list[int]
    lines: list[Rows]
    width: float = 0.0
    cap: int = BUTT
    join: int = ROUND
    length: float = 0.0
    cap_count: int = 0

    @property
    def has_ends(self) -> bool:
        return any(line.is_open for line in self.lines)

    @property
    def is_long(self) -> bool:
        """Whether it would be a stroke without others beside it."""
        is_round = self.cap == ROUND and self.has_ends
        least = STROKES.round_length_min if is_round else STROKES.length_min
        return bool(self.lines) and self.length >= least * self.width


def _parts_of(scene: Scene) -> list[_Part]:
    """Return the connected parts of a scene of one path."""
    control, loop = control_points(scene), segment_loops(scene)
    areas = loop_areas(control, loop, scene.structure.loop_count)
    return [_part(control, loop, areas, loops) for loops in _components(control, loop, areas)]


def _strokes_of(parts: list[_Part]) -> list[Stroke]:
    """Return those of the ``parts`` of a path that may be strokes, which look alike."""
    widths = [part.width for part in parts if part.is_long]
    if not widths:
        return []
    common = float(np.median(widths))
    alike = [p for p in parts if p.lines and abs(p.width - common) <= STROKES.width_error * common]
    cap = _most([part.cap for part in alike if part.has_ends], BUTT)
    chosen = [part for part in alike if part.cap == cap or not part.has_ends]
    join = _most([part.join for part in chosen if part.is_long], ROUND)
    return [Stroke(part.loops, part.lines, common, cap, join, [None] * len(part.lines)) for part in chosen]


def _are_outlines(parts: list[_Part]) -> bool:
    """Return whether the ``parts`` of a colour are drawn by their outlines, and not by a pen.

    A round pen shows in round caps, outlines in square ends and miters.
    """
    bars = [part for part in parts if part.is_long]
    caps = {part.cap for part in bars if part.cap_count}
    return ROUND not in caps and (BUTT in caps or any(part.join == MITER for part in bars))


def _most(kinds: list[int], otherwise: int) -> int:
    return max(set(kinds), key=kinds.count) if kinds else otherwise


def _components(control: Floats, loop: Integers, areas: Floats) -> list[list[int]]:
    """Return the loops of each connected part: one that runs like the largest loop, and the holes in it."""
    sign = np.sign(areas[np.argmax(np.abs(areas))])
    outer = np.flatnonzero(np.sign(areas) == sign)
    outer = outer[np.argsort(np.abs(areas[outer]))]
    polygons = {
        k: cubic_points(control[loop == k], np.linspace(0.0, 1.0, 9)[:-1]).reshape(-1, 2) for k in outer.tolist()
    }
    parts = {k: [k] for k in outer.tolist()}
    for hole in np.flatnonzero(np.sign(areas) != sign).tolist():
        place = control[loop == hole][0, 0]
        owner = next((k for k in outer.tolist() if _contains(polygons[k], place)), int(outer[-1]))
        parts[owner].append(hole)
    return list(parts.values())


def _contains(polygon: Floats, place: Floats) -> bool:
    start, end = polygon, np.roll(polygon, -1, axis=0)
    crosses = (start[:, 1] > place[1]) != (end[:, 1] > place[1])
    rise = np.where(crosses, end[:, 1] - start[:, 1], 1.0)
    x = start[:, 0] + (place[1] - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    return bool((crosses & (x > place[0])).sum() % 2)


def _part(control: Floats, loop: Integers, areas: Floats, loops: list[int]) -> _Part:
    """Return what is known of the part with these ``loops``."""
    boundary = boundary_of(control[np.isin(loop, loops)], float(areas[loops[0]]))
    if len(boundary.points) < STROKES.points_min or not may_have_width(boundary):
        return _Part(loops, [])
    disks = inner_disks(boundary)
    width, has_width = stroke_width(boundary, disks)
    found = center_lines(boundary, disks, has_width, width) if width >= STROKES.width_min else None
    if found is None or not found.lines:
        return _Part(loops, [])
    length = sum(float(np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum()) for line in found.lines)
    spread = min(STROKES.spread, STROKES.spread_share * width)
    rows = [fit_line(line, width, spread) for line in found.lines]
    return _Part(loops, rows, width, found.cap, join_of(rows, boundary, width), length, found.cap_count)
