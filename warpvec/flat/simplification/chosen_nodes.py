"""Make the scene that a choice of nodes states, and put nodes back where that was wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.fewest_spans import ChosenSpans
from warpvec.flat.simplification.span_candidates import Outlines
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure


def chosen_scene(scene: Scene, choice: ChosenSpans, is_smooth: Mask) -> Scene:
    """Return ``scene`` with the segments of ``choice``, of whose nodes some are made smooth [S]."""
    first = torch.from_numpy(choice.first)
    handles = torch.from_numpy(choice.handles).to(scene.segments.dtype)
    segments = torch.cat([scene.segments[first, :1], handles], 1)
    structure = with_counts(scene, choice.counts, torch.from_numpy(choice.is_line))
    return smoothed(replace(scene.detach(), segments=segments, structure=structure), torch.from_numpy(is_smooth))


def smoothed(scene: Scene, is_smooth: Tensor) -> Scene:
    """Return ``scene`` with nodes that are smooth [R] made exactly so, except those between two lines."""
    free = Joints.of(scene, keep=False)
    joints = replace(free, is_smooth=is_smooth & ~(free.is_line & free.is_line[free.preceding]))
    return replace(scene, segments=joints.segments(*joints.values(scene)))


def with_spans_back(
    simple: Scene, old: Scene, choice: ChosenSpans, wrong: Mask, corner: Mask
) -> tuple[Scene, Integers]:
    """Return the scene ``simple`` with the segments of ``old`` where those of ``choice`` were ``wrong`` [S].

    The nodes of ``simple`` may have moved since the choice; what is put back moves along. The nodes ``corner`` [S] are
    corners again.

    Returns:
        the scene of R segments, and the row of ``old`` where each of them starts [R].
    """
    source, place, row = members(choice, np.where(wrong, choice.size, 1), old)
    is_back = wrong[source]
    segments = np.where(is_back[:, None, None], _moved_along(simple, old, choice, source, place, row), 0.0)
    segments[~is_back] = simple.segments.numpy()[source[~is_back]]
    is_line = np.where(is_back, old.structure.lines.numpy()[row], simple.structure.lines.numpy()[source])
    loop = np.repeat(np.arange(len(choice.counts)), choice.counts)
    counts = np.bincount(loop[source], minlength=len(choice.counts)).astype(np.int64)
    structure = with_counts(simple, counts, torch.from_numpy(is_line))
    now_smooth = Joints.of(simple).is_smooth.numpy() & ~corner
    is_smooth = np.where(is_back & (place > 0), Joints.of(old).is_smooth.numpy()[row], now_smooth[source])
    tensor = torch.from_numpy(segments).to(simple.segments.dtype)
    back = replace(simple.detach(), segments=tensor, structure=structure)
    return smoothed(back, torch.from_numpy(is_smooth)), row


def nearly_smooth(scene: Scene) -> Mask:
    """Return which nodes [R] of a scene of cubics are corners that hardly differ from smooth nodes."""
    joints = Joints.of(scene)
    following, preceding = joints.following, joints.preceding
    end = scene.segments[following, 0]
    ahead, behind = scene.segments[:, 1] - scene.segments[:, 0], (end - scene.segments[:, 2])[preceding]
    one, other = ahead.norm(dim=1), behind.norm(dim=1)
    turn = torch.where(one * other > 1e-6, ((ahead * behind).sum(1) / (one * other)).clamp(-1.0, 1.0).acos(), math.pi)
    # Only the curve moves beside a line. Of two curves, the one with the shorter handle turns more.
    move = turn * torch.where(
        joints.is_line, other, torch.where(joints.is_line[preceding], one, one * other / (one + other))
    )
    is_near = (turn < math.radians(SIMPLIFICATION.smooth_node_degrees)) & (move < SIMPLIFICATION.smooth_node_move)
    return (is_near & ~joints.is_smooth & ~(joints.is_line & joints.is_line[preceding])).numpy()


def wrong_segments(
    simple: Scene, choice: ChosenSpans, outlines: Outlines, excess: Mask, is_new: Mask, rounded: Mask
) -> tuple[Mask, Mask]:
    """Return which segments [S] of ``choice`` must go back, and which nodes [S] are corners.

    A segment with an ``excess`` of error [S] is wrong if it ``is_new`` [S], or if one of its nodes was ``rounded`` [S].
    These nodes are corners then, and both segments beside them wrong.
    """
    structure = simple.structure
    following, preceding = structure.segment_next.long().numpy(), structure.segment_previous.long().numpy()
    corner = rounded & (excess | excess[preceding])
    wrong = (is_new & excess) | corner | corner[following]
    old = outlines.samples.control[choice.first, 0]
    slides = np.linalg.norm(simple.segments[:, 0].double().numpy() - old, axis=1) > SIMPLIFICATION.slide_max
    while True:
        grown = wrong | (wrong[preceding] & slides) | (wrong & slides)[following]
        if (grown == wrong).all():
            return wrong, corner
        wrong = grown


def members(choice: ChosenSpans, sizes: Integers, old: Scene) -> tuple[Integers, Integers, Integers]:
    """List the old segments of each new one, ``sizes`` [S] of them: its number, their place in it and their row [M]."""
    source = np.repeat(np.arange(len(sizes)), sizes)
    place = counted(sizes)
    first = old.structure.loop_first_segment.long().numpy()
    loop = np.repeat(np.arange(len(choice.counts)), choice.counts)[source]
    start, size = first[loop], np.diff(first)[loop]
    return source, place, start + (choice.first[source] + place - start) % size


def _moved_along(
    simple: Scene, old: Scene, choice: ChosenSpans, source: Integers, place: Integers, row: Integers
) -> Floats:
    """Return the old segments ``row`` [S', 3, 2], moved as the ends of the new segments ``source`` have."""
    before, now = old.segments.double().numpy(), simple.segments.double().numpy()[:, 0]
    following = simple.structure.segment_next.long().numpy()
    start_shift = now - before[choice.first, 0]
    shifts = start_shift[source], start_shift[following[source]]
    share = (place[:, None] + np.array([0.0, 1 / 3, 2 / 3])) / choice.size[source][:, None]
    return before[row] + (1.0 - share[..., None]) * shifts[0][:, None] + share[..., None] * shifts[1][:, None]


def with_counts(scene: Scene, counts: Integers, is_line: Tensor) -> Structure:
    """Return the structure of ``scene`` with loops of so many segments [L], of which some are lines [R]."""
    starts = torch.from_numpy(np.concatenate([[0], np.cumsum(counts)])).int()
    return Structure(starts, scene.structure.path_first_loop, is_line if is_line.any() else None)
