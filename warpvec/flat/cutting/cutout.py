"""Make a stacked drawing one without overlaps, for cutting and plotting: neighbours share the very same edge.

The outlines of all paths are laid into one planar map. Each of its faces belongs to the uppermost path that covers it.
A piece of outline between two paths is computed once and used by both, so that there are neither gaps nor overlaps.
Lines stay lines, and curves are parts of the curves that they were.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.cut_edges import CurvePart, CutEdges
from warpvec.flat.cutting.noding import chords_of, noded
from warpvec.flat.cutting.planar_map import planar_map
from warpvec.flat.cutting.slivers import without_slivers
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure


@dataclass(frozen=True)
class Cutout:
    """A drawing without overlaps.

    Attributes:
        scene: paths that share their edges, over nothing.
        hidden_count: number of paths of the drawing that nothing is left of, because others cover them.
        sliver_count: number of slivers that went to their neighbours.
        blended_count: number of translucent paths, which are mixed with the colours of what they cover.
    """

    scene: Scene
    hidden_count: int
    sliver_count: int
    blended_count: int


def cut_out(scene: Scene, width: int, height: int, tick: tuple[float, float] | None = None) -> Cutout:
    """Return ``scene``, whose canvas is ``width`` x ``height`` pixels, without overlaps, and cut at the canvas.

    The background, if there is one, becomes a path of its own. Where a translucent path lies on others, the parts get
    their mixed colours; of two gradients on one another, the upper one counts with the mean of its colours.

    Args:
        tick: last decimals of the file in pixels, across and down. Points are rounded to them, so that the file states
            both sides of an edge alike; None to round nothing.
    """
    stacked = _with_background(scene.detach().cpu(), width, height)
    cubics, is_line, path = _curves(stacked, width, height)
    path_count = len(stacked) + 1
    chords = noded(chords_of(cubics, is_line))
    # The canvas is the last path: its edges count before all others.
    mapped = planar_map(chords, path, path_count)
    stacks = _visible_stacks(mapped.winding != 0, stacked.opacity.numpy() >= CUTTING.opaque)
    owners, keys = _numbered(stacks)
    owners, sliver_count = without_slivers(mapped, owners, path[mapped.curve])
    edges = CutEdges(mapped, owners, cubics, is_line, tick)
    loops = {owner: edges.loops(owner) for owner in range(1, len(keys))}
    drawn = [owner for owner in sorted(loops, key=lambda each: keys[each][-1]) if loops[owner]]
    used = {row for owner in drawn for row in keys[owner]}
    return Cutout(
        _scene(stacked, [keys[owner] for owner in drawn], [loops[owner] for owner in drawn]),
        hidden_count=len(stacked) - len(used),
        sliver_count=sliver_count,
        blended_count=sum(1 for row in used if stacked.opacity[row] < CUTTING.opaque),
    )


# The drawing as curves


def _with_background(scene: Scene, width: int, height: int) -> Scene:
    """Return ``scene`` over nothing; its background is then its lowest path."""
    if scene.transparent:
        return scene
    corners = torch.tensor([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    chord = corners.roll(-1, 0) - corners
    segments = torch.stack([corners, corners + chord / 3, corners + chord * 2 / 3], 1)
    sheet = Scene(
        segments, Structure.of_loops([[4]], torch.ones(4, dtype=torch.bool)), scene.background[None],
        torch.ones(1), torch.zeros(3), torch.zeros(1, dtype=torch.int64), transparent=True,
    )  # fmt: skip
    return sheet.joined(replace(scene, transparent=True, background=torch.zeros(3)))


def _curves(scene: Scene, width: int, height: int) -> tuple[Floats, Mask, Integers]:
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

_Stack = tuple[int, ...]
"""Paths that show in a face: an opaque one, or none, and the translucent ones above it."""


def _visible_stacks(is_covered: Mask, is_opaque: Mask) -> list[_Stack]:
    """Return the paths that show in each face, which ``is_covered`` [F, N + 1] by paths and, last, by the canvas."""
    stacks = []
    for face in is_covered:
        rows = np.flatnonzero(face[:-1]) if face[-1] else np.zeros(0, np.int64)
        opaque = np.flatnonzero(is_opaque[rows])
        stacks.append(tuple(rows[opaque[-1] if len(opaque) else 0 :].tolist()))
    return stacks


def _numbered(stacks: list[_Stack]) -> tuple[Integers, list[_Stack]]:
    """Return the number of each stack among the different ones, and these; number 0 is the empty one."""
    keys: dict[_Stack, int] = {(): 0}
    owners = [keys.setdefault(stack, len(keys)) for stack in stacks]
    return np.array(owners, np.int64), list(keys)


# The result


def _scene(stacked: Scene, stacks: list[_Stack], loops: list[list[list[CurvePart]]]) -> Scene:
    """Return a path for each stack, with its ``loops``."""
    pieces = [piece for path in loops for loop in path for piece in loop]
    segments = torch.tensor(np.array([piece.cubic[:3] for piece in pieces]).reshape(-1, 3, 2), dtype=torch.float32)
    is_line = torch.tensor([piece.is_line for piece in pieces], dtype=torch.bool)
    structure = Structure.of_loops([[len(loop) for loop in path] for path in loops], is_line)
    paints = [_blended(stacked, stack) for stack in stacks]
    rows = torch.tensor([row for row, *_ in paints], dtype=torch.int64)
    color, end_color = (
        torch.stack([stops[k] for _, stops, _ in paints]) if paints else torch.zeros(0, 3) for k in (0, 1)
    )
    paths = stacked.gradients
    gradients = None if paths is None else Gradients(paths.kind[rows], paths.geometry[rows], end_color)
    opacity = torch.tensor([opacity for *_, opacity in paints])
    generation = stacked.generation[torch.tensor([stack[0] for stack in stacks], dtype=torch.int64)]
    return Scene(segments, structure, color, opacity, torch.zeros(3), generation, transparent=True, gradients=gradients)


def _blended(scene: Scene, stack: _Stack) -> tuple[int, list[Tensor], float]:
    """Return the paint that the paths of ``stack`` show together.

    It is the path whose gradient counts, the colours of the two stops, and the opacity.
    """
    paints = Gradients.none(scene.color) if scene.gradients is None else scene.gradients
    end_colors = torch.where((paints.kind == FLAT)[:, None], scene.color, paints.end_color)
    row, opacity = stack[0], float(scene.opacity[stack[0]])
    stops = [scene.color[row], end_colors[row]]
    for above in stack[1:]:
        share = float(scene.opacity[above])
        whole = share + opacity * (1 - share)
        added = [scene.color[above], end_colors[above]]
        if paints.kind[above] != FLAT and paints.kind[row] != FLAT:
            added = [(added[0] + added[1]) / 2] * 2
        elif paints.kind[above] != FLAT:
            row = above
        stops = [
            (share * new + opacity * (1 - share) * old) / max(whole, 1e-9)
            for new, old in zip(added, stops, strict=True)
        ]
        opacity = whole
    return row, stops, opacity
