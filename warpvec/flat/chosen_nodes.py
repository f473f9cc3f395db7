"""Make the scene that a choice of nodes states, and put nodes back where that was wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.flat.fewest_spans import Choice
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

Rows = NDArray[np.int64]
Mask = NDArray[np.bool_]


def chosen_scene(scene: Scene, choice: Choice) -> Scene:
    """Return ``scene`` with the segments of ``choice``, smooth where its nodes were smooth."""
    first = torch.from_numpy(choice.first)
    handles = torch.from_numpy(choice.handles).to(scene.segments.dtype)
    segments = torch.cat([scene.segments[first, :1], handles], 1)
    structure = _structure(scene, choice.counts, torch.from_numpy(choice.is_line))
    return smoothed(replace(scene.detach(), segments=segments, structure=structure), Joints.of(scene).is_smooth[first])


def smoothed(scene: Scene, is_smooth: Tensor) -> Scene:
    """Return ``scene`` with nodes that are smooth [R] made exactly so, except those between two lines."""
    free = Joints.of(scene, keep=False)
    joints = replace(free, is_smooth=is_smooth & ~(free.is_line & free.is_line[free.preceding]))
    return replace(scene, segments=joints.segments(*joints.values(scene)))


def with_spans_back(simple: Scene, old: Scene, choice: Choice, wrong: Mask) -> tuple[Scene, Rows]:
    """Return the scene ``simple`` with the segments of ``old`` where those of ``choice`` were ``wrong`` [S].

    The nodes of ``simple`` may have moved since the choice; what is put back moves along.

    Returns:
        the scene of R segments, and the row of ``old`` where each of them starts [R].
    """
    source, place, row = members(choice, np.where(wrong, choice.size, 1), old)
    is_back = wrong[source]
    segments = np.where(is_back[:, None, None], _moved_along(simple, old, choice, source, place, row), 0.0)
    segments[~is_back] = simple.segments.numpy()[source[~is_back]]
    is_line = np.where(is_back, _lines(old)[row], _lines(simple)[source])
    loop = np.repeat(np.arange(len(choice.counts)), choice.counts)
    counts = np.bincount(loop[source], minlength=len(choice.counts)).astype(np.int64)
    structure = _structure(simple, counts, torch.from_numpy(is_line))
    is_smooth = np.where(is_back & (place > 0), Joints.of(old).is_smooth[row], Joints.of(simple).is_smooth[source])
    tensor = torch.from_numpy(segments).to(simple.segments.dtype)
    back = replace(simple.detach(), segments=tensor, structure=structure)
    return smoothed(back, torch.from_numpy(is_smooth)), row


def members(choice: Choice, sizes: Rows, old: Scene) -> tuple[Rows, Rows, Rows]:
    """List the old segments of each new one, ``sizes`` [S] of them: its number, their place in it and their row [M]."""
    source = np.repeat(np.arange(len(sizes)), sizes)
    place = np.arange(len(source)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    first = old.structure.loop_first_segment.long().numpy()
    loop = np.repeat(np.arange(len(choice.counts)), choice.counts)[source]
    start, size = first[loop], np.diff(first)[loop]
    return source, place, start + (choice.first[source] + place - start) % size


def _moved_along(
    simple: Scene, old: Scene, choice: Choice, source: Rows, place: Rows, row: Rows
) -> NDArray[np.float64]:
    """Return the old segments ``row`` [S', 3, 2], moved as the ends of the new segments ``source`` have."""
    before, now = old.segments.double().numpy(), simple.segments.double().numpy()[:, 0]
    following = simple.structure.segment_next.long().numpy()
    start_shift = now - before[choice.first, 0]
    shifts = start_shift[source], start_shift[following[source]]
    share = (place[:, None] + np.array([0.0, 1 / 3, 2 / 3])) / choice.size[source][:, None]
    moved: NDArray[np.float64] = (
        before[row] + (1.0 - share[..., None]) * shifts[0][:, None] + share[..., None] * shifts[1][:, None]
    )
    return moved


def _structure(scene: Scene, counts: Rows, is_line: Tensor) -> Structure:
    starts = torch.from_numpy(np.concatenate([[0], np.cumsum(counts)])).int()
    return Structure(starts, scene.structure.path_first_loop, is_line if is_line.any() else None)


def _lines(scene: Scene) -> Mask:
    found: Mask = Joints.of(scene, keep=False).is_line.numpy()
    return found
