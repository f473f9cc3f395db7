"""Box-filtered signed coverage of a polygon: the polygon is clipped to each pixel, the rest is the shoelace formula.

Clipping here is the retraction onto the pixel: each point of the boundary moves to the nearest point of the square,
which is to clamp x and y. On that way a point from outside a convex square never crosses its inside, so every inner
point of the pixel keeps its winding number, and the signed area of the retracted loop is the integral of the winding
number over the pixel. That holds for loops that cross or cover themselves, and that enter a pixel any number of times.

Sign: x right, y down, positive inside a path that runs clockwise on the screen.
"""

from __future__ import annotations

import torch
from torch import Tensor


def coverage(signed: Tensor) -> Tensor:
    """Return min(|s|, 1), with derivative sign(s) where |s| <= 1 and 0 where |s| > 1 or s = 0."""
    return signed.abs().clamp(max=1.0)


def signed_coverage(polygon: Tensor, height: int, width: int) -> Tensor:
    """Return the integral of the winding number over each pixel [h, w], differentiable in ``polygon`` [V, 2].

    Where an edge lies on a pixel border the integral has a kink and the gradient is not defined.
    """
    corner = _grid(height, width, 1, polygon)
    whole = winding_number(polygon, corner + 0.5)
    near = _near_an_edge(polygon, corner)
    return whole.index_put((near,), _retracted_area(polygon, corner[near])).reshape(height, width)


def winding_number(polygon: Tensor, point: Tensor) -> Tensor:
    """Return the signed turns of the closed ``polygon`` [V, 2] around each ``point`` [P, 2]; no gradient."""
    start, end = polygon.detach(), polygon.detach().roll(-1, 0)
    x, y = point[:, :1], point[:, 1:]
    edge = end - start
    side = edge[:, 0] * (y - start[:, 1]) - edge[:, 1] * (x - start[:, 0])
    downward = (start[:, 1] <= y) & (y < end[:, 1]) & (side > 0)
    upward = (end[:, 1] <= y) & (y < start[:, 1]) & (side < 0)
    return (downward.to(polygon.dtype) - upward.to(polygon.dtype)).sum(1)


def supersampled_winding(polygon: Tensor, height: int, width: int, sample_count: int = 64) -> Tensor:
    """Return the winding number [h, w, sample_count ** 2] on a regular grid of samples inside each pixel."""
    rows = []
    for row in range(height):
        sample = _grid(sample_count, width * sample_count, sample_count, polygon) + 0.5 / sample_count
        sample[:, 1] += row
        winding = winding_number(polygon, sample).reshape(sample_count, width, sample_count)
        rows.append(winding.transpose(0, 1).reshape(width, -1))
    return torch.stack(rows)


def supersampled_coverage(polygon: Tensor, height: int, width: int, sample_count: int = 64) -> Tensor:
    """Return the share [h, w] of samples that the non-zero rule fills: the true coverage by brute force."""
    return (supersampled_winding(polygon, height, width, sample_count) != 0).to(polygon.dtype).mean(-1)


def _grid(height: int, width: int, step_count: int, like: Tensor) -> Tensor:
    """Return the top left corners [height * width, 2] of square cells in raster order, ``step_count`` per pixel."""
    y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    return torch.stack([x, y], -1).reshape(-1, 2).to(like.dtype) / step_count


def _near_an_edge(polygon: Tensor, corner: Tensor) -> Tensor:
    """Return a mask [P] of the pixels that the bounding box of an edge touches; the boundary misses all others."""
    start, end = polygon.detach(), polygon.detach().roll(-1, 0)
    low, high = torch.minimum(start, end), torch.maximum(start, end)
    overlap = (low <= corner[:, None] + 1) & (high >= corner[:, None])
    return overlap.all(-1).any(-1)


def _retracted_area(polygon: Tensor, corner: Tensor) -> Tensor:
    """Return the shoelace area [P] of ``polygon`` [V, 2] retracted onto the unit squares at ``corner`` [P, 2]."""
    loop = _retract(_retract(polygon - corner[:, None], axis=0), axis=1)
    (ax, ay), (bx, by) = loop.unbind(-1), loop.roll(-1, 1).unbind(-1)
    return 0.5 * (ax * by - ay * bx).sum(1)


def _retract(loop: Tensor, axis: int) -> Tensor:
    """Return loops [P, V, 2] with one coordinate clamped to [0, 1], split where they meet 0 and 1: [P, 3 V, 2]."""
    edge = loop.roll(-1, 1) - loop
    t = _breaks(loop[..., axis], edge[..., axis])
    split = (loop[:, :, None] + t[..., None] * edge[:, :, None]).flatten(1, 2)
    x, y = split.unbind(-1)
    return torch.stack([x.clamp(0.0, 1.0), y] if axis == 0 else [x, y.clamp(0.0, 1.0)], -1)


def _breaks(start: Tensor, edge: Tensor) -> Tensor:
    """Return the parameters [P, V, 3] of an edge's start and of its crossings with 0 and 1, in order of travel.

    A line that is not met repeats an end point. The two are ordered before they are clamped: on a vertex that lies on a
    pixel border they become equal, and the wrong one of them first would carry a wrong gradient.
    """
    parallel = edge == 0
    step = edge.masked_fill(parallel, 1.0)
    zero, one = -start / step, (1.0 - start) / step
    t = torch.stack([torch.zeros_like(zero), torch.minimum(zero, one), torch.maximum(zero, one)], -1)
    return t.masked_fill(parallel[..., None], 0.0).clamp(0.0, 1.0)
