"""Count where the outline of a path crosses itself."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.arrays import Floats, counted, cross
from warpvec.geometry.bezier import bernstein, whole_curves
from warpvec.geometry.scene import Scene

CHORDS = 8
"""Chords of a curve. Loops smaller than a chord are not seen, and neither are they on the screen."""

FOLD_MIN = 0.25
"""Area in square pixels of the smaller part that a crossing cuts off a loop, from which on it counts. Less cannot be
seen, and the rounding of a file makes such crossings at sharp turns."""

FOLD_WIDTH = 0.05
"""Mean width in pixels of that part from which on it counts. A thinner sliver cannot be seen either, however long."""

_PAIRS_AT_ONCE = 2**12
"""Pairs of segments whose chords are compared at once, which bounds the memory."""

Rows = NDArray[np.int64]


def self_crossings(scene: Scene) -> Tensor:
    """Return how often the outline of each path, drawn as chords, crosses itself or another loop of the path [N]."""
    return sums_of_paths(scene, crossings_of_rows(scene)) // 2


def sums_of_paths(scene: Scene, row_count: Tensor) -> Tensor:
    """Return the sum of a number of each segment [R] over each path [N]."""
    total = torch.zeros(len(scene), dtype=row_count.dtype, device=row_count.device)
    return total.index_add_(0, scene.structure.segment_path.long(), row_count)


def crossings_of_rows(scene: Scene, is_counted: Tensor | None = None) -> Tensor:
    """Return how often each segment [R] crosses another one of its path, or itself, which counts twice.

    A crossing of a loop with itself counts if it cuts off a part that can be seen: see ``FOLD_MIN`` and ``FOLD_WIDTH``.
    The time grows with the number of pairs of segments whose boxes overlap: see `overlapping_pairs`.

    Args:
        scene: the drawing, in pixels.
        is_counted: paths [N] (bool) to look at, by default all; segments of others get 0.
    """
    found = np.zeros(len(scene.segments), np.int64)
    looked_at = np.ones(len(scene), np.bool_) if is_counted is None else is_counted.cpu().numpy()
    if not looked_at.any():
        return torch.from_numpy(found).to(scene.segments.device)
    chords = _Chords(scene)
    for one, other in chords.pairs(looked_at):
        low, high = chords.crossings(one, other)
        counted = chords.is_visible(low, high)
        np.add.at(found, low[counted] // CHORDS, 1)
        np.add.at(found, high[counted] // CHORDS, 1)
    return torch.from_numpy(found).to(scene.segments.device)


def overlapping_pairs(scene: Scene) -> Tensor:
    """Return how many pairs of segments of each path overlap from left to right [N]: what a look at it costs."""
    total = np.zeros(len(scene), np.int64)
    order, counts, path = _Chords(scene).reach(np.ones(len(scene), np.bool_))
    np.add.at(total, path[order], counts)
    return torch.from_numpy(total).to(scene.segments.device)


class _Chords:
    """The chords of all segments in one list: ``CHORDS`` of each row, so that the chords of a loop are consecutive."""

    def __init__(self, scene: Scene) -> None:
        structure = scene.structure
        parameters = torch.arange(CHORDS + 1, dtype=torch.float64) / CHORDS
        points = (bernstein(scene.degree, parameters) @ whole_curves(scene).double().cpu()).numpy()
        following = structure.segment_next.cpu().numpy()
        points[:, -1] = points[following, 0]  # the same to the last bit
        self._path = structure.segment_path.cpu().numpy().astype(np.int64)
        self._least, self._most = points.min(1), points.max(1)
        self._start, self._end = points[:, :-1].reshape(-1, 2), points[:, 1:].reshape(-1, 2)
        self._chord_boxes = [
            (np.minimum(start, end).reshape(-1, CHORDS), np.maximum(start, end).reshape(-1, CHORDS))
            for start, end in zip(self._start.T, self._end.T, strict=True)
        ]
        first = structure.loop_first_segment.cpu().numpy().astype(np.int64) * CHORDS
        self._loop = np.repeat(np.arange(len(first) - 1), np.diff(first))
        self._areas = _sums(cross(self._start, self._end))
        self._lengths = _sums(np.linalg.norm(self._end - self._start, axis=1))
        self._whole_area = self._areas[first[1:]] - self._areas[first[:-1]]
        self._whole_length = self._lengths[first[1:]] - self._lengths[first[:-1]]

    def reach(self, looked_at: NDArray[np.bool_]) -> tuple[Rows, Rows, Rows]:
        """Return the rows of some paths sorted by their left side, and how many after each it reaches; and all paths.

        Rows of one path come one after another.
        """
        rows = np.flatnonzero(looked_at[self._path])
        width = np.ptp(self._start[:, 0]) + np.ptp(self._end[:, 0]) + 1.0 if len(self._start) else 1.0
        # Paths stand side by side, too far apart to reach each other.
        offset = 2.0 * width * self._path[rows] - (self._least[:, 0].min() if len(self._least) else 0.0)
        left, right = self._least[rows, 0] + offset, self._most[rows, 0] + offset
        order = np.argsort(left, kind="stable")
        last = np.searchsorted(left[order], right[order], side="right")
        return rows[order], last - np.arange(len(order)) - 1, self._path

    def pairs(self, looked_at: NDArray[np.bool_]) -> Iterator[tuple[Rows, Rows]]:
        """Yield pairs of rows of one path whose boxes overlap, a row with itself included, some at a time."""
        order, counts, _ = self.reach(looked_at)
        counts = counts + 1  # itself
        ends = np.cumsum(counts)
        start = 0
        while start < len(order):
            stop = max(start + 1, int(np.searchsorted(ends, (ends[start - 1] if start else 0) + _PAIRS_AT_ONCE)))
            some = counts[start:stop]
            index = np.repeat(np.arange(start, stop), some)
            within = counted(some)
            one, other = order[index], order[index + within]
            touches = self._least[one, 1] <= self._most[other, 1]
            touches &= self._least[other, 1] <= self._most[one, 1]
            yield np.minimum(one, other)[touches], np.maximum(one, other)[touches]
            start = stop

    def crossings(self, one: Rows, other: Rows) -> tuple[Rows, Rows]:
        """Return the chords of pairs of rows that cross, the earlier one and the later one of each pair of chords."""
        fits = np.ones((len(one), CHORDS, CHORDS), np.bool_)
        for least, most in self._chord_boxes:
            fits &= most[one][:, :, None] >= least[other][:, None, :]
            fits &= most[other][:, None, :] >= least[one][:, :, None]
        pair, first, second = np.nonzero(fits)
        low, high = CHORDS * one[pair] + first, CHORDS * other[pair] + second
        is_new = low < high  # a row with itself: each pair of chords once
        low, high = low[is_new], high[is_new]
        a, b, c, d = self._start[low], self._end[low], self._start[high], self._end[high]
        is_across = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
        return low[is_across], high[is_across]

    def is_visible(self, low: Rows, high: Rows) -> NDArray[np.bool_]:
        """Return which crossings of chords cut off a visible part of their loop, or are of two loops."""
        inner = self._areas[high] - self._areas[low + 1] + cross(self._start[high], self._start[low + 1])
        length = self._lengths[high] - self._lengths[low + 1]
        loop = self._loop[low]
        outer, rest = self._whole_area[loop] - inner, self._whole_length[loop] - length
        is_inner = np.abs(inner) < np.abs(outer)
        area = 0.5 * np.where(is_inner, np.abs(inner), np.abs(outer))
        thin = 0.5 * FOLD_WIDTH * np.where(is_inner, length, rest)
        return (loop != self._loop[high]) | (area >= np.maximum(FOLD_MIN, thin))


def _sums(values: Floats) -> Floats:
    return np.concatenate([np.zeros(1), np.cumsum(values)])


def _side(a: Floats, b: Floats, point: Floats) -> Floats:
    """Return on which side of the line from ``a`` to ``b`` each point lies: the sign of a cross product."""
    return np.sign(cross(b - a, point - a))
