"""Round the curves of a drawing that nearly lie on a circle so that its file can state them as arcs."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.svg.arcs import BULGE, RADIUS_MIN, ROUNDING, Arc, arc_rows, are_arcs, nearest_arc, runs

MISS_MAX = 0.02
"""Largest distance in pixels by which an arc may miss the curves that it replaces."""

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


def with_arcs(scene: Scene, precision: int, units: float) -> Scene:
    """Return the cubic ``scene``, whose points are at whole ticks of ``10**-precision``, with true arcs.

    Curves of a loop that lie on one circle, within ``MISS_MAX``, become those of an arc. A whole circle
    becomes two halves. Forms stay.

    Args:
        scene: the drawing, in units of its file.
        precision: decimals of the coordinates.
        units: units per pixel of the picture.
    """
    structure, per_unit = scene.structure, 10**precision
    tolerance = max(MISS_MAX * units * per_unit, ROUNDING)  # files of large ticks could else have no arcs
    ticks, is_line = scene.segments.double().cpu().numpy() * per_unit, structure.lines.cpu().numpy()
    is_form = np.zeros(len(scene), bool) if scene.forms is None else scene.forms.is_form.cpu().numpy()
    is_open = np.zeros(structure.loop_count, bool) if structure.is_open is None else structure.is_open.cpu().numpy()
    first = structure.loop_first_segment.tolist()
    owner = structure.segment_path.cpu().numpy()[first[:-1]]
    loops = [(ticks[start:stop], is_line[start:stop]) for start, stop in pairwise(first)]
    rounded = [
        None if is_form[owner[loop]] else _with_arcs(rows, lines, bool(is_open[loop]), tolerance)
        for loop, (rows, lines) in enumerate(loops)
    ]
    if all(each is None for each in rounded):
        return scene
    loops = [each or loop for each, loop in zip(rounded, loops, strict=True)]
    counts = [[len(rows) for rows, _ in loops[a:b]] for a, b in pairwise(structure.path_first_loop.tolist())]
    lines = torch.from_numpy(np.concatenate([lines for _, lines in loops])).to(scene.segments.device)
    parted = Structure.of_loops(counts, lines if bool(lines.any()) else None, structure.is_open)
    segments = torch.from_numpy(np.concatenate([rows for rows, _ in loops]) / per_unit).to(scene.segments)
    return replace(scene, segments=segments, structure=parted).with_forms(scene.forms)


def _with_arcs(rows: Floats, is_line: Mask, is_open: bool, tolerance: float) -> tuple[Floats, Mask] | None:
    """Return the rows [S, 3, 2] of a loop in ticks with its arcs, and which are lines; None if it has none."""
    whole = None if is_open else _circle_of(rows, is_line, tolerance)
    if whole is not None:
        return whole, np.zeros(len(whole), bool)
    if not is_open:
        rows, is_line = _begun_between_arcs(rows, is_line)
    ends = np.roll(rows[:, 0], -1, axis=0)
    parts: list[tuple[Floats, Mask]] = []
    done, last = 0, len(rows) - is_open
    for start, stop in runs(rows[:last], is_line[:last], ends[:last]):
        curves = _arc(rows[start:stop], ends[stop - 1], tolerance)
        if curves is None and stop - start == 2 and are_arcs(rows[start:stop], ends[start:stop]).all():
            # Nearly a half of a circle may have no radius in ticks, and its quarters have one.
            each = [_arc(rows[row : row + 1], ends[row], tolerance) for row in range(start, stop)]
            curves = np.concatenate([own for own in each if own is not None] or [rows[:0]])
            curves = curves if len(curves) == stop - start else None
        if curves is not None:
            parts += [(rows[done:start], is_line[done:start]), (curves, np.zeros(len(curves), bool))]
            done = stop
    if not parts:
        return None
    parts.append((rows[done:], is_line[done:]))
    return np.concatenate([part for part, _ in parts]), np.concatenate([mask for _, mask in parts])


def _arc(rows: Floats, end: Floats, tolerance: float) -> Floats | None:
    """Return the curves [n, 3, 2] of the arc that ``rows`` are, up to their ``end``; None if they are none."""
    step = np.rint(end - rows[0, 0]).astype(np.int64)
    arc = nearest_arc(rows - rows[0, 0], step, tolerance) if step.any() else None
    return None if arc is None else rows[0, 0] + arc_rows(step, arc)


def _begun_between_arcs(rows: Floats, is_line: Mask) -> tuple[Floats, Mask]:
    """Return a closed loop so that no arc goes on from its last row to its first."""
    twice, lines = np.concatenate([rows, rows]), np.concatenate([is_line, is_line])
    ends = np.concatenate([twice[1:, 0], rows[:1, 0]])
    for start, stop in runs(twice, lines, ends):
        if start < len(rows) < stop:
            return np.roll(rows, -start, axis=0), np.roll(is_line, -start)
    return rows, is_line


def _circle_of(rows: Floats, is_line: Mask, tolerance: float) -> Floats | None:
    """Return the rows [4, 3, 2] of the circle that a loop is, as two halves; None if it is none."""
    if is_line.any() or len(rows) < 3:
        return None
    ends = np.roll(rows[:, 0], -1, axis=0)
    t = np.arange(4)[:, None] / 4.0
    a, b, c, d = (part[:, None] for part in (*np.moveaxis(rows, 1, 0), ends))
    points = ((1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d).reshape(-1, 2)
    center = np.rint((points.min(0) + points.max(0)) / 2.0)
    distances = np.hypot(*(points - center).T)
    radius = round(float(distances.mean()))
    if radius < RADIUS_MIN or np.abs(distances - radius).max() > tolerance + BULGE * radius:
        return None
    area = float((points[:, 0] * np.roll(points[:, 1], -1) - points[:, 1] * np.roll(points[:, 0], -1)).sum())
    there = arc_rows(np.array([-2 * radius, 0]), Arc(radius, False, area > 0.0))
    back = arc_rows(np.array([2 * radius, 0]), Arc(radius, False, area > 0.0))
    right = center + np.array([radius, 0.0])
    return np.concatenate([right + there, right - np.array([2.0 * radius, 0.0]) + back])
