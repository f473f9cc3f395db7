"""Make small outlines that are nearly round true circles before the first fit.

The outline of a disc or a ring of a few pixels follows the noise of its mixed pixels: three paints meet in a pixel of a
thin ring. A fit of so rough an outline ends at a polygon. From a circle it ends close to one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.accepted_changes import accepted_loops
from warpvec.flat.simplification.circles import Ellipse
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.local_error import boxes_of, errors_in_boxes
from warpvec.flat.simplification.outline_samples import (
    OutlineSamples,
    control_points,
    cubic_points,
    cubic_slopes,
    segment_loops,
)
from warpvec.flat.simplification.path_removal import loop_areas
from warpvec.geometry.scene import Scene

_PARAMETERS = (np.arange(8) + 0.5) / 8
"""Parameters of the points along a segment that are compared with a circle."""


class _Round(NamedTuple):
    """A nearly round loop.

    Attributes:
        loop: its number.
        circle: the circle of the same area.
        is_clockwise: whether the loop is clockwise.
        off_max: largest distance in pixels of the loop from the circle.
    """

    loop: int
    circle: Ellipse
    is_clockwise: bool
    off_max: float


def with_small_rounds(scene: Scene, critic: Critic) -> Scene:
    """Return the traced ``scene`` with circles for small loops that are nearly round, unless the error rises.

    These are loops that are roughly traced and leave much unexplained, and those that share their centre. Paths of many
    loops are words, whose letters stay alike.

    Args:
        scene: a scene of cubics, as it was traced.
        critic: judges the changes against the image.
    """
    rounds = list(_rounds(scene))
    is_rough = np.array([each.off_max >= SIMPLIFICATION.round_rough_min for each in rounds], bool)
    if not is_rough.any():
        return scene
    samples = critic.samples(scene)
    is_rough &= _are_doubtful(scene, [each.loop for each in rounds], critic, samples)
    centers = np.array([(each.circle.x, each.circle.y) for each in rounds])
    apart = np.linalg.norm(centers[:, None] - centers[is_rough], axis=-1).min(1, initial=np.inf)
    chosen = [each for each, far in zip(rounds, apart, strict=True) if far <= SIMPLIFICATION.round_centers_apart]
    circles = {each.loop: each.circle.segments(each.is_clockwise) for each in chosen}
    return accepted_loops(scene, circles, critic, samples, SIMPLIFICATION.round_move) if circles else scene


def _are_doubtful(scene: Scene, loops: list[int], critic: Critic, samples: OutlineSamples) -> Mask:
    """Return which ``loops`` [n] leave much of the picture unexplained: the others were traced as they are."""
    owner, count = segment_loops(scene), scene.structure.loop_count
    low, high = (sides[loops] for sides in boxes_of(samples.control, owner, count))
    allowed = critic.allowed(samples.worth, SIMPLIFICATION.round_move, SIMPLIFICATION.noise)
    error = errors_in_boxes(critic.error(scene), low, high)
    return np.asarray(error >= SIMPLIFICATION.round_doubt_min * np.bincount(owner, allowed, count)[loops])


def _rounds(scene: Scene) -> Iterator[_Round]:
    """Yield the nearly round small loops of paths of few loops."""
    control, structure = control_points(scene), scene.structure
    areas = loop_areas(control, segment_loops(scene), structure.loop_count).tolist()
    first, paths = structure.loop_first_segment.tolist(), structure.path_first_loop.tolist()
    for start, stop in pairwise(paths):
        if stop - start <= SIMPLIFICATION.round_loops_max:
            for loop in range(start, stop):
                found = _round(loop, control[first[loop] : first[loop + 1]], areas[loop])
                if found is not None:
                    yield found


def _round(loop: int, control: Floats, area: float) -> _Round | None:
    """Return the circle of the same ``area`` as a loop, if the loop is small and nearly that circle.

    Args:
        loop: number of the loop.
        control: control points of its segments [K, 4, 2].
        area: its area in square pixels; the sign is its direction.
    """
    radius = math.sqrt(abs(area) / math.pi)
    if not SIMPLIFICATION.round_radius_min <= radius <= SIMPLIFICATION.round_radius_max:
        return None
    points = cubic_points(control, _PARAMETERS).reshape(-1, 2)
    lengths = np.linalg.norm(cubic_slopes(control, _PARAMETERS), axis=-1).reshape(-1)
    x, y = np.average(points, axis=0, weights=lengths).tolist()
    off = np.abs(np.linalg.norm(points - (x, y), axis=1) - radius)
    rms, most = math.sqrt(float(np.average(np.square(off), weights=lengths))), float(off.max())
    if rms > SIMPLIFICATION.round_distance_rms or most > SIMPLIFICATION.round_distance_max:
        return None
    return _Round(loop, Ellipse(x, y, radius, radius, 0.0), area > 0.0, most)
