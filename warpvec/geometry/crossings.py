"""Count where the outline of a path crosses itself."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.geometry.bezier import bernstein, whole_curves
from warpvec.geometry.scene import Scene

CHORDS = 8
"""Chords of a curve. Loops smaller than a chord are not seen, and neither are they on the screen."""

FOLD_MIN = 0.25
"""Area in square pixels of the smaller part that a crossing cuts off a loop, from which on it counts. Less cannot be
seen, and the rounding of a file makes such crossings at sharp turns."""

_PAIRS_MAX = 2**22
"""Pairs of chords that are compared at once, which bounds the memory."""


def self_crossings(scene: Scene) -> Tensor:
    """Return how often the outline of each path, drawn as chords, crosses itself or another loop of the path [N]."""
    structure = scene.structure
    found = crossings_of_rows(scene)
    total = torch.zeros(len(scene), dtype=torch.int64, device=found.device)
    return total.index_add_(0, structure.segment_path.long(), found) // 2


def crossings_of_rows(scene: Scene, is_counted: Tensor | None = None) -> Tensor:
    """Return how often each segment [R] crosses another one of its path, or itself, which counts twice.

    A crossing of a loop with itself counts if it cuts off ``FOLD_MIN`` or more. The time grows with the square of the
    number of segments of a path.

    Args:
        scene: the drawing, in pixels.
        is_counted: paths [N] (bool) to look at, by default all; segments of others get 0.
    """
    loops = scene.structure.loop_first_segment.long().diff()
    loop = torch.arange(len(loops), device=loops.device).repeat_interleave(loops * CHORDS).reshape(-1, CHORDS)
    starts = _chords(scene).double()  # [R, CHORDS, 2]
    ends = torch.cat([starts[:, 1:], starts[scene.structure.segment_next.long(), :1]], 1)
    first = scene.structure.path_first_segment.long()
    counts = first.diff()
    found = torch.zeros(len(starts), dtype=torch.int64, device=starts.device)
    looked_at = torch.ones_like(counts, dtype=torch.bool) if is_counted is None else is_counted
    for count in sorted(set(counts[looked_at].tolist())):
        paths = (looked_at & (counts == count)).nonzero().flatten()
        step = max(1, _PAIRS_MAX // (count * CHORDS) ** 2)
        for some in (paths[k : k + step] for k in range(0, len(paths), step)):
            rows = first[some, None] + torch.arange(count, device=first.device)
            crossings = _crossings(starts[rows].flatten(1, 2), ends[rows].flatten(1, 2), loop[rows].flatten(1, 2))
            found[rows] = crossings.reshape(len(some), count, CHORDS).sum(2)
    return found


def _chords(scene: Scene) -> Tensor:
    parameters = torch.arange(CHORDS, dtype=scene.segments.dtype, device=scene.segments.device) / CHORDS
    return bernstein(scene.degree, parameters) @ whole_curves(scene)


def _crossings(start: Tensor, end: Tensor, loop: Tensor) -> Tensor:
    """Return how many others each chord crosses in each of K paths [K, E], from its ends [K, E, 2] and loop [K, E]."""
    paths, count = start.shape[:2]
    found = torch.zeros((paths, count), dtype=torch.int64, device=start.device)
    step = max(1, _PAIRS_MAX // (paths * count))
    for first in range(0, count, step):
        a, b = (ends[:, first : first + step, None] for ends in (start, end))
        c, d = start[:, None], end[:, None]
        is_across = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
        path, one, other = is_across.nonzero().unbind(1)
        one = one + first
        counts = _cut_off(start, end, loop, path, torch.minimum(one, other), torch.maximum(one, other)) >= FOLD_MIN
        found.index_put_((path, one), counts.long(), accumulate=True)
    return found


def _cut_off(start: Tensor, end: Tensor, loop: Tensor, path: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """Return the area of the smaller part of a loop that the crossing of chords ``low`` and ``high`` [C] cuts off.

    It is infinite if the chords are of two loops.
    """
    parts = _cross(start, end)
    sums = torch.nn.functional.pad(parts.cumsum(1), (1, 0))  # [K, E + 1]
    inner = sums[path, high] - sums[path, low + 1] + _cross(start[path, high], start[path, low + 1])
    first = loop.min()
    areas = parts.new_zeros(int(loop.max() - first) + 1).index_add_(0, (loop - first).flatten(), parts.flatten())
    whole = areas[loop[path, low] - first]
    smaller = 0.5 * torch.minimum(inner.abs(), (whole - inner).abs())
    return torch.where(loop[path, low] == loop[path, high], smaller, torch.inf)


def _cross(a: Tensor, b: Tensor) -> Tensor:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _side(a: Tensor, b: Tensor, point: Tensor) -> Tensor:
    """Return on which side of the line from ``a`` to ``b`` each point lies: the sign of a cross product."""
    return _cross(b - a, point - a).sign()
