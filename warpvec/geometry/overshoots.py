"""Tell which segments overshoot their end and come back, as a handle that lies beyond the end makes them."""

from __future__ import annotations

from torch import Tensor

from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene


def overshoots(scene: Scene) -> Tensor:
    """Return which segments [R] (bool) of a scene of cubics begin or end against the way to their other handle.

    A cubic that is nearly straight turns back at such an end. As the side of a fill it hardly shows. As the centre line
    of a stroke it turns the cap round.
    """
    curves = whole_curves(scene)
    start, leaving, arriving, end = curves.unbind(1)
    at_start = ((leaving - start) * (arriving - start)).sum(1)
    at_end = ((end - arriving) * (end - leaving)).sum(1)
    return (at_start < 0.0) | (at_end < 0.0)
