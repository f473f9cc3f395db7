"""Tell which strokes overshoot the end of a segment and come back, as a handle that lies beyond the end makes them."""

from __future__ import annotations

from torch import Tensor

from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene


def overshoots(scene: Scene) -> Tensor:
    """Return which segments [R] (bool) of strokes, which are cubics, turn back at an end although they are straight.

    They are as straight as one sees if both handles lie within half a width of the line between the ends. A handle that
    lies beyond an end then changes neither side of the stroke, but turns the cap round. Loops and steep bends leave
    that line, and may begin and end in any direction.
    """
    assert scene.strokes is not None
    start, leaving, arriving, end = whole_curves(scene).unbind(1)
    at_start = ((leaving - start) * (arriving - start)).sum(1)
    at_end = ((end - arriving) * (end - leaving)).sum(1)
    width = scene.strokes.width[scene.structure.segment_path.long()]
    is_straight = _distance(leaving, start, end).maximum(_distance(arriving, start, end)) < 0.5 * width
    return is_straight & ((at_start < 0.0) | (at_end < 0.0))


def _distance(point: Tensor, start: Tensor, end: Tensor) -> Tensor:
    """Return the distance [R] of points [R, 2] from the straight lines through two others [R, 2]."""
    along, offset = end - start, point - start
    cross = along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]
    return cross.abs() / along.norm(dim=1).clamp_min(1e-9)
