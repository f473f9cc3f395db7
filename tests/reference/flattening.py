"""Flatten cubic segments to polygons: points at equal steps of the parameter, moved out to keep the area."""

from __future__ import annotations

import torch
from torch import Tensor


def flatten(points: Tensor, counts: Tensor) -> list[Tensor]:
    """Return closed polygons, one [V_i, 2] per path, with the last vertex joined to the first.

    Args:
        points: control points [N, 3 S, 2]; segment s has the points 3s .. 3s + 3, modulo 3 S.
        counts: chords per segment [N, S], each at least 1; V_i is the sum of row i.
    """
    return [flatten_loop(path, row) for path, row in zip(points, counts.tolist(), strict=True)]


def uniform_counts(points: Tensor, count: int) -> Tensor:
    """Return counts [N, S] that give every segment of ``points`` [N, 3 S, 2] the same number of chords."""
    return torch.full((points.shape[0], points.shape[1] // 3), count, dtype=torch.int64)


def flatten_loop(loop: Tensor, counts: list[int]) -> Tensor:
    """Return the closed polygon [V, 2] of a loop [3 S, 2] with ``counts`` chords in its S segments."""
    closed = torch.cat([loop, loop[:1]])
    return torch.cat([_chord_starts(closed[3 * s : 3 * s + 4], count) for s, count in enumerate(counts)])


def _chord_starts(control: Tensor, count: int) -> Tensor:
    """Return B(t) - B''(t) / (12 n (n - 1)) at t = j / n for j < n = ``count``, and B itself at the joint j = 0.

    A parabola's chord has the mean distance |B''| / (12 n^2) from its arc; moving the n - 1 vertices between the joints
    out by n / (n - 1) times that gives its polygon its area. The end of a segment is the start of the next.
    """
    t = torch.arange(count, dtype=control.dtype)[:, None] / count
    u = 1 - t
    point = torch.cat([u**3, 3 * u**2 * t, 3 * u * t**2, t**3], -1) @ control
    bend = 6 * (u * (control[0] - 2 * control[1] + control[2]) + t * (control[1] - 2 * control[2] + control[3]))
    return point - bend * (t > 0) / (12 * count * max(count - 1, 1))
