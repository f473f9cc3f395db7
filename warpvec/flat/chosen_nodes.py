"""Make the scene that a choice of nodes states, and put nodes back where that was wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.flat.fewest_spans import Choice
from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure


@dataclass(frozen=True, eq=False)
class Stays:
    """What must stay in a scene of R segments: nodes [R], and kinds of segments [R] (bool)."""

    node: NDArray[np.bool_]
    kind: NDArray[np.bool_]

    @staticmethod
    def nothing(count: int) -> Stays:
        return Stays(np.zeros(count, np.bool_), np.zeros(count, np.bool_))

    def after(self, choice: Choice) -> Stays:
        """Return the same for the segments of ``choice``."""
        return Stays(self.node[choice.first], self.kind[choice.first])


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


def with_spans_back(
    simple: Scene, stays: Stays, old: Scene, choice: Choice, wrong: NDArray[np.bool_]
) -> tuple[Scene, Stays]:
    """Return the scene ``simple`` with the segments of ``old`` where those of ``choice`` were ``wrong`` [S].

    The nodes of ``simple`` may have moved since the choice; what is put back moves along. Its nodes and kinds stay from
    now on.
    """
    counts = np.where(wrong, choice.size, 1)
    source = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(source)) - np.repeat(np.cumsum(counts) - counts, counts)
    loop = np.repeat(np.arange(len(choice.counts)), choice.counts)
    row = _rows_after(choice, old, loop[source], choice.first[source] + place)
    is_back = wrong[source]
    segments = np.where(is_back[:, None, None], _moved_along(simple, old, choice, source, place, row), 0.0)
    segments[~is_back] = simple.segments.numpy()[source[~is_back]]
    is_line = np.where(is_back, _lines(old)[row], _lines(simple)[source])
    structure = _structure(simple, np.bincount(loop, counts).astype(np.int64), torch.from_numpy(is_line))
    is_smooth = np.where(is_back & (place > 0), Joints.of(old).is_smooth[row], Joints.of(simple).is_smooth[source])
    tensor = torch.from_numpy(segments).to(simple.segments.dtype)
    back = replace(simple.detach(), segments=tensor, structure=structure)
    node = np.where(is_back & (place > 0), True, stays.node[source])
    return smoothed(back, torch.from_numpy(is_smooth)), Stays(node, stays.kind[source] | is_back)


def _rows_after(choice: Choice, old: Scene, loop: NDArray[np.int64], row: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return ``row``, which may run beyond the end of its ``loop``, within it."""
    first = old.structure.loop_first_segment.long().numpy()
    start, size = first[loop], np.diff(first)[loop]
    wrapped: NDArray[np.int64] = start + (row - start) % size
    return wrapped


def _moved_along(
    simple: Scene,
    old: Scene,
    choice: Choice,
    source: NDArray[np.int64],
    place: NDArray[np.int64],
    row: NDArray[np.int64],
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


def _structure(scene: Scene, counts: NDArray[np.int64], is_line: Tensor) -> Structure:
    starts = torch.from_numpy(np.concatenate([[0], np.cumsum(counts)])).int()
    return Structure(starts, scene.structure.path_first_loop, is_line if is_line.any() else None)


def _lines(scene: Scene) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = Joints.of(scene, keep=False).is_line.numpy()
    return found
