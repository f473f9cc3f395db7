"""Lay the outlines of a stacked drawing into one planar map, each of whose faces belongs to what shows there."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.necks import neck_mouths
from warpvec.flat.cutting.noding import Chords, chords_of, noded
from warpvec.flat.cutting.planar_map import PlanarMap, planar_map
from warpvec.flat.cutting.slivers import without_slivers
from warpvec.flat.cutting.spurs import spur_mouths
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.watch.watch import UNWATCHED, Watch

Stack = tuple[int, ...]
"""Paths that show in a face: an opaque one, or none, and the translucent ones above it."""


class Arrangement(NamedTuple):
    """A stacked drawing as a planar map.

    Attributes:
        stacked: the drawing over nothing; an opaque background is its lowest path.
        mapped: the map of its outlines and the edges of the canvas.
        owners: row of ``keys`` for each face [F]: what shows there, slivers, spurs and necks given to their neighbours.
        keys: the different stacks of paths; the first is empty.
        cubics: all curves [R, 4, 2], and the lines across the mouths of spurs and necks.
        is_line: which curves are lines [R].
        sliver_count: number of slivers that went to their neighbours.
    """

    stacked: Scene
    mapped: PlanarMap
    owners: Integers
    keys: list[Stack]
    cubics: Floats
    is_line: Mask
    sliver_count: int


def arranged(scene: Scene, width: float, height: float, watch: Watch = UNWATCHED) -> Arrangement:
    """Return the planar map of ``scene``, whose canvas is ``width`` x ``height`` pixels; it ends at the canvas."""
    stacked = _with_background(scene.detach().cpu(), width, height)
    cubics, is_line, path = _curves(stacked, width, height)
    path_count = len(stacked) + 1
    is_opaque = least_opacity(stacked).numpy() >= CUTTING.opaque

    def owned(chords: Chords) -> tuple[PlanarMap, Integers, int, list[Stack]]:
        """Return the map of ``chords``, the owner of each face, the number of slivers, and what the owners show."""
        # The canvas is the last path: its edges count before all others.
        mapped = planar_map(chords, path, path_count)
        owners, keys = _numbered(_visible_stacks(mapped.winding != 0, is_opaque))
        return mapped, *without_slivers(mapped, owners, path[mapped.curve]), keys

    error = CUTTING.chord_error_late if watch.is_over() else CUTTING.chord_error
    chords = noded(chords_of(cubics, is_line, error))
    mapped, owners, sliver_count, keys = owned(chords)
    for _ in range(CUTTING.spur_rounds_max):
        if watch.is_over():
            break
        mouths = np.concatenate([spur_mouths(mapped, owners), neck_mouths(mapped, owners)])
        if not len(mouths):
            break
        thirds = np.linspace(0.0, 1.0, 4)[None, :, None]
        added, lines = mouths[:, :1] + thirds * (mouths[:, 1:] - mouths[:, :1]), np.ones(len(mouths), bool)
        # All that was broken stays so.
        chords = noded(chords.joined(chords_of(added, lines), len(cubics)))
        cubics, is_line = np.concatenate([cubics, added]), np.concatenate([is_line, lines])
        path = np.concatenate([path, np.full(len(mouths), -1)])
        mapped, owners, sliver_count, keys = owned(chords)
    return Arrangement(stacked, mapped, owners, keys, cubics, is_line, sliver_count)


# The drawing as curves


def _with_background(scene: Scene, width: float, height: float) -> Scene:
    """Return ``scene`` over nothing; its background is then its lowest path."""
    if scene.transparent:
        return scene
    below = sheet(scene.background, width, height)
    return below.joined(replace(scene, transparent=True, background=torch.zeros(3)))


def sheet(color: Tensor, width: float, height: float) -> Scene:
    """Return a path of one ``color`` [3] that covers a canvas of ``width`` x ``height`` pixels, over nothing."""
    corners = torch.tensor([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    chord = corners.roll(-1, 0) - corners
    segments = torch.stack([corners, corners + chord / 3, corners + chord * 2 / 3], 1)
    return Scene(
        segments, Structure.of_loops([[4]], torch.ones(4, dtype=torch.bool)), color[None],
        torch.ones(1), torch.zeros(3), torch.zeros(1, dtype=torch.int64), transparent=True,
    )  # fmt: skip


def _curves(scene: Scene, width: float, height: float) -> tuple[Floats, Mask, Integers]:
    """Return all curves [R, 4, 2], which of them are lines [R], and their paths [R]; the canvas is one more path."""
    structure = scene.structure
    rows = scene.segments.double().numpy()
    ends = rows[structure.segment_next.long().numpy(), :1]
    sheet = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    thirds = np.linspace(0, 1, 4)[None, :, None]
    border = sheet[:, None] + thirds * (np.roll(sheet, -1, axis=0) - sheet)[:, None]
    is_line = np.zeros(len(rows), bool) if structure.is_line is None else structure.is_line.numpy()
    cubics = np.concatenate([np.concatenate([rows, ends], 1), border])
    path = np.concatenate([structure.segment_path.numpy(), np.full(4, len(scene))]).astype(np.int64)
    return cubics, np.concatenate([is_line, np.ones(4, bool)]), path


# Which paths show where


def _visible_stacks(is_covered: Mask, is_opaque: Mask) -> list[Stack]:
    """Return the paths that show in each face, which ``is_covered`` [F, N + 1] by paths and, last, by the canvas."""
    stacks = []
    for face in is_covered:
        rows = np.flatnonzero(face[:-1]) if face[-1] else np.zeros(0, np.int64)
        opaque = np.flatnonzero(is_opaque[rows])
        stacks.append(tuple(rows[opaque[-1] if len(opaque) else 0 :].tolist()))
    return stacks


def _numbered(stacks: list[Stack]) -> tuple[Integers, list[Stack]]:
    """Return the number of each stack among the different ones, and these; number 0 is the empty one."""
    keys: dict[Stack, int] = {(): 0}
    owners = [keys.setdefault(stack, len(keys)) for stack in stacks]
    return np.array(owners, np.int64), list(keys)


def least_opacity(scene: Scene) -> Tensor:
    """Return the opacity of each path [N] where it is most translucent."""
    return scene.opacity if scene.gradients is None else scene.opacity * scene.gradients.least_opacity()
