"""Make small outlines that are nearly round true circles before the first fit.

The outline of a disc or a ring of a few pixels follows the noise of its mixed pixels: three paints meet in a pixel of a
thin ring. A fit of so rough an outline ends at a polygon. From a circle it ends close to one.
"""

from __future__ import annotations

import math

import numpy as np
import torch

from warpvec.arrays import Floats
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.accepted_changes import accepted_loops
from warpvec.flat.simplification.circles import Ellipse
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.outline_samples import (
    control_points,
    cubic_points,
    cubic_slopes,
    segment_loops,
)
from warpvec.flat.simplification.path_removal import loop_areas
from warpvec.geometry.scene import Scene

_PARAMETERS = (np.arange(8) + 0.5) / 8
"""Parameters of the points along a segment that are compared with a circle."""


def with_small_rounds(scene: Scene, critic: Critic) -> Scene:
    """Return the traced ``scene`` with circles for small loops that are nearly round, unless the error rises.

    Paths of many loops are words, whose letters stay alike.

    Args:
        scene: a scene of cubics, as it was traced.
        critic: judges the changes against the image.
    """
    found: dict[int, Floats] = {}
    control = control_points(scene)
    first, areas = (
        scene.structure.loop_first_segment,
        loop_areas(control, segment_loops(scene), scene.structure.loop_count),
    )
    counts = scene.structure.path_first_loop.diff()
    is_simple = torch.repeat_interleave(counts <= SIMPLIFICATION.round_loops_max, counts.long())
    for loop in torch.nonzero(is_simple).flatten().tolist():
        circle = _circle(control[int(first[loop]) : int(first[loop + 1])], float(areas[loop]))
        if circle is not None:
            found[loop] = circle.segments(bool(areas[loop] > 0.0))
    if not found:
        return scene
    return accepted_loops(scene, found, critic, critic.samples(scene), SIMPLIFICATION.round_move)


def _circle(control: Floats, area: float) -> Ellipse | None:
    """Return the circle of the same ``area`` as a loop, if the loop is small and nearly that circle.

    Args:
        control: control points of the segments of the loop [K, 4, 2].
        area: area of the loop in square pixels; its sign is its direction.
    """
    radius = math.sqrt(abs(area) / math.pi)
    if not SIMPLIFICATION.round_radius_min <= radius <= SIMPLIFICATION.round_radius_max:
        return None
    points = cubic_points(control, _PARAMETERS).reshape(-1, 2)
    lengths = np.linalg.norm(cubic_slopes(control, _PARAMETERS), axis=-1).reshape(-1)
    centre = np.average(points, axis=0, weights=lengths)
    off = np.abs(np.linalg.norm(points - centre, axis=1) - radius)
    rms = math.sqrt(float(np.average(np.square(off), weights=lengths)))
    if rms > SIMPLIFICATION.round_distance_rms or off.max() > SIMPLIFICATION.round_distance_max:
        return None
    return Ellipse(float(centre[0]), float(centre[1]), radius, radius, 0.0)
