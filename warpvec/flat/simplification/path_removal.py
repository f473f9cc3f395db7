"""Remove paths and loops that the picture hardly shows: slivers along edges, specks, and what is hidden."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import torch

from warpvec.arrays import Floats, Integers, Mask
from warpvec.config.fit_config import FitConfig
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.price import words_of
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.local_error import boxes_of, errors_in_boxes
from warpvec.flat.simplification.outline_samples import segment_loops
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.watch.decisions import are_wanted
from warpvec.watch.watch import Watch


def remove_paths(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> tuple[Scene, int]:
    """Remove the paths and loops that raise the squared error by no more than a move of their outline by ``detail``.

    Returns the scene, and the number of loops that are gone of paths that are left.

    Args:
        scene: a scene of cubics, fitted to the image.
        critic: judges the changes against the image.
        watch: the watch over the run. When it is over, what is removed so far must do.
        detail: root mean square in pixels by which an outline may move.
    """
    for _ in range(SIMPLIFICATION.removal_rounds):
        keep = _needed(scene, critic, detail)
        scene = scene.select(torch.from_numpy(keep))
        if keep.all() or watch.is_over():
            break
    return (scene, 0) if watch.is_over() else _without_loops(scene, critic, detail)


def _needed(scene: Scene, critic: Critic, detail: float) -> Mask:
    """Return which paths [N] stay. A path goes if it costs little and overlaps with no other that goes."""
    cost, samples = critic.removal_costs(scene), critic.samples(scene)
    worth = np.bincount(samples.path, samples.worth, len(scene)).astype(np.float64)
    order, allowed = np.argsort(cost, kind="stable"), critic.allowed(worth, detail, SIMPLIFICATION.whole_noise)
    low, high = boxes_of(samples.control, samples.path, len(scene))
    keep = np.ones(len(scene), np.bool_)
    for path in range(len(scene)) if are_wanted() else ():
        numbers = words_of(scene.select(torch.tensor([path]))).number_count
        place = (*low[path].tolist(), *high[path].tolist())
        critic.note("paths", place, "path", "nothing", numbers, (float(cost[path]), float(allowed[path])))
    for path in order[cost[order] <= allowed[order]].tolist():
        overlaps = (low[path] <= high) & (low <= high[path])
        keep[path] = bool((overlaps.all(1) & ~keep).any())
    return keep


def _without_loops(scene: Scene, critic: Critic, detail: float) -> tuple[Scene, int]:
    """Return ``scene`` without loops that show as little, of paths that have others, and the number of these loops."""
    structure, samples = scene.structure, critic.samples(scene)
    loop, count = segment_loops(scene), structure.loop_count
    worth = np.bincount(loop, samples.worth, count).astype(np.float64)
    length = np.bincount(loop, samples.lengths.sum(1), count)
    allowed = critic.allowed(worth, detail, SIMPLIFICATION.whole_noise)
    cost = np.abs(loop_areas(samples.control, loop, count)) * worth / np.maximum(length, 1e-9)
    per_path = structure.path_first_loop.diff().long().numpy()
    has_others = np.repeat(per_path > 1, per_path)
    gone = (cost <= allowed) & has_others
    first = structure.path_first_loop[:-1].long().numpy()
    gone[first] &= np.add.reduceat(~gone, first) > 0 if len(first) else False  # a path keeps one
    if not gone.any():
        return scene, 0
    before, box = critic.error(scene), boxes_of(samples.control, loop, count)
    gone &= errors_in_boxes(critic.error(without_loops(scene, gone)) - before, *box) <= allowed
    fewer = without_loops(scene, gone)
    if float((critic.error(fewer) - before).sum()) > allowed[gone].sum():
        return scene, 0  # one loop made up for another
    return fewer, int(gone.sum())


def loop_areas(control: Floats, loop: Integers, count: int) -> Floats:
    """Return the signed area of each of ``count`` loops of cubics ``control`` [R, 4, 2], of ``loop`` [R]."""
    pairs = ((0, 1, 6.0), (0, 2, 3.0), (0, 3, 1.0), (1, 2, 3.0), (1, 3, 3.0), (2, 3, 6.0))
    area = np.zeros(len(control))
    for i, j, weight in pairs:
        area += weight / 20.0 * (control[:, i, 0] * control[:, j, 1] - control[:, i, 1] * control[:, j, 0])
    return np.bincount(loop, area, count).astype(np.float64)


def without_loops(scene: Scene, gone: Mask) -> Scene:
    """Return ``scene`` without the loops ``gone`` [L]; every path must keep one."""
    structure = scene.structure
    sizes = structure.loop_first_segment.diff().long().numpy()
    rows = torch.from_numpy(np.repeat(~gone, sizes))
    loops = pairwise(structure.path_first_loop.tolist())
    counts = [sizes[start:stop][~gone[start:stop]].tolist() for start, stop in loops]
    is_line = None if structure.is_line is None else structure.is_line[rows]
    return replace(scene, segments=scene.segments[rows], structure=Structure.of_loops(counts, is_line))
