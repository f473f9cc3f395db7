"""Leave out nodes of a scene whose outlines hardly change for it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import torch
from torch import Tensor

from warpvec.geometry.lines import thirds
from warpvec.geometry.quick_merge import quick_merges
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

_FEWEST = 2
"""Fewest segments of a loop."""

_STRAIGHT = 1e-3
"""Distance in pixels within which two lines are one: less than what files of pixels state."""


def with_fewer_nodes(scene: Scene, tolerance: float) -> Scene:
    """Return ``scene``, of one path, with fewer nodes; its outline moves by at most about ``tolerance`` pixels.

    Neighbouring cubics become one, those first that move the outline least. What each has moved adds up. Ends of open
    lines stay, and two lines become one only where they lie in a line.
    """
    scene = scene.outlined()
    moved = torch.zeros(scene.structure.segment_count, dtype=torch.float64)
    while True:
        found = _best_merge(scene, moved, tolerance)
        if found is None:
            return scene
        scene, moved = _merged(scene, moved, *found)


def _best_merge(scene: Scene, moved: Tensor, tolerance: float) -> tuple[int, Tensor, float] | None:
    """Return the row whose node goes, the handles of the cubic that comes, and how far its outline has moved then."""
    structure, merges = scene.structure, quick_merges(scene)
    before = structure.segment_previous.long()
    gap = merges.offset.abs().amax(1)
    are_lines = structure.lines & structure.lines[before]
    loop = torch.repeat_interleave(torch.arange(structure.loop_count), structure.loop_first_segment.diff().long())
    is_open = structure.line_ends
    is_short = structure.loop_first_segment.diff()[loop] <= _FEWEST
    is_refused = is_open | is_short | (are_lines & (gap > _STRAIGHT))
    total = torch.where(is_refused, torch.inf, gap + torch.maximum(moved, moved[before]))
    row = int(total.argmin())
    return (row, merges.handles[row], float(total[row])) if float(total[row]) <= tolerance else None


def _merged(scene: Scene, moved: Tensor, row: int, handles: Tensor, total: float) -> tuple[Scene, Tensor]:
    structure, segments, moved = scene.structure, scene.segments.clone(), moved.clone()
    before, after = int(structure.segment_previous[row]), int(structure.segment_next[row])
    is_line = structure.lines.clone()
    is_line[before] &= is_line[row]
    if is_line[before]:
        handles = torch.stack(thirds(segments[before, 0], segments[after, 0]))
    segments[before, 1:] = handles.to(segments)
    moved[before] = total
    kept = torch.arange(len(segments)) != row
    counts = [int(kept[start:stop].sum()) for start, stop in pairwise(structure.loop_first_segment.tolist())]
    lines = is_line[kept] if bool(is_line.any()) else None
    made = Structure.of_loops([counts], lines, structure.is_open)
    return replace(scene, segments=segments[kept], structure=made), moved[kept]
