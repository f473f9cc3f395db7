"""Keep the changes of a drawing that the picture does not object to, and take back the others."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import torch

from warpvec.arrays import Floats, Floats32, Integers, Mask
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.price import CUBIC, FORM_NUMBERS, LINE
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.local_error import boxes_of, errors_in_boxes, errors_near
from warpvec.flat.simplification.outline_samples import OutlineSamples, control_points, segment_loops
from warpvec.geometry.forms.registry import ELLIPSE
from warpvec.geometry.regrouping import with_loops
from warpvec.geometry.scene import Scene
from warpvec.watch.decisions import are_wanted, box_of


def accepted_loops(
    old: Scene, loops: dict[int, Floats], critic: Critic, samples: OutlineSamples, detail: float
) -> Scene:
    """Return ``old`` with other curves for some ``loops`` [K, 3, 2], where the exact error rises by little."""
    kept = kept_loops(old, loops, critic, samples, detail)
    return _with_curves(old, kept) if kept else old


def kept_loops(
    old: Scene, loops: dict[int, Floats], critic: Critic, samples: OutlineSamples, detail: float
) -> dict[int, Floats]:
    """Return those ``loops`` [K, 3, 2] that may replace the loops of ``old``, as the exact error rises by little.

    It may rise far from both curves: a hole that the old curve surrounded can lie outside of the new one.
    """
    before, allowed = critic.error(old), critic.allowed(samples.worth, samples.moves(detail), SIMPLIFICATION.noise)
    count = old.structure.loop_count
    limit = np.bincount(segment_loops(old), allowed, count).astype(np.float64)
    while loops:
        new = _with_curves(old, loops)
        rise = critic.error(new) - before
        outlines = [(segment_loops(scene), control_points(scene)) for scene in (old, new)]
        costs = [np.bincount(owner, errors_near(control, rise), count) for owner, control in outlines]
        cost = np.maximum(*costs)
        wrong = cost > limit
        if are_wanted():
            _note(old, loops, critic, cost, limit)
        if not wrong[list(loops)].any():
            wrong = _is_worse_inside(outlines, rise, limit, list(loops))
        kept = {loop: curves for loop, curves in loops.items() if not wrong[loop]}
        if len(kept) == len(loops):
            break
        loops = kept
    return loops


def _note(old: Scene, loops: dict[int, Floats], critic: Critic, cost: Floats, limit: Floats) -> None:
    """Note each of the ``loops`` that may be a form, with its rise of the error and the one that is allowed [L]."""
    first, is_line = old.structure.loop_first_segment.tolist(), old.structure.lines
    for loop, curves in loops.items():
        rows = slice(first[loop], first[loop + 1])
        numbers = float(torch.where(is_line[rows], LINE, CUBIC).sum()) - FORM_NUMBERS[ELLIPSE]
        words = f"{first[loop + 1] - first[loop]} segments", f"form of {len(curves)} segments"
        critic.note("forms", box_of(curves), *words, numbers, (float(cost[loop]), float(limit[loop])))


def _is_worse_inside(
    outlines: Iterable[tuple[Integers, Floats]], rise: Floats32, limit: Floats, changed: list[int]
) -> Mask:
    """Return which loops [L] have more ``rise`` [h, w] in their box than all ``changed`` ones there may cause.

    Args:
        outlines: loop of each segment [R], and control points [R, 4, 2], before and after the change.
        rise: of the squared error in each pixel [h, w].
        limit: rise that each loop may cause [L].
        changed: the loops that have changed.
    """
    boxes = [boxes_of(control, owner, len(limit)) for owner, control in outlines]
    low, high = np.minimum(boxes[0][0], boxes[1][0])[changed], np.maximum(boxes[0][1], boxes[1][1])[changed]
    meet = ((low[:, None] <= high) & (low <= high[:, None])).all(2)
    wrong = np.zeros(len(limit), np.bool_)
    wrong[changed] = errors_in_boxes(rise, low, high) > meet @ limit[changed]
    return wrong


def _with_curves(scene: Scene, loops: dict[int, Floats]) -> Scene:
    """Return ``scene`` with the curves [K, 3, 2] for the loops of these numbers."""
    changed = {loop: (torch.from_numpy(rows), torch.zeros(len(rows), dtype=torch.bool)) for loop, rows in loops.items()}
    return with_loops(scene, changed)
