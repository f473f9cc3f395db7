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
from warpvec.flat.cutting.cut_edges import CutEdges
from warpvec.flat.cutting.fewest_parts import CurvePart
from warpvec.flat.cutting.noding import Chords, chords_of, noded
from warpvec.flat.cutting.planar_map import PlanarMap, planar_map
from warpvec.flat.cutting.slivers import without_slivers
from warpvec.flat.cutting.spurs import spur_mouths
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX
from warpvec.geometry.structure import Structure
from warpvec.watch.watch import UNWATCHED, Watch


@dataclass(frozen=True)
class Cutout:
    """A drawing without overlaps.

    Attributes:
        scene: paths that share their edges, over nothing or over a page that is not white.
        hidden_count: number of paths of the drawing that nothing is left of, because others cover them.
        sliver_count: number of slivers that went to their neighbours.
        blended_count: number of translucent paths, which are mixed with the colours of what they cover.
        sharpened_count: number of soft paths, which are cut along their outlines.
    """

    scene: Scene
    hidden_count: int
    sliver_count: int
    blended_count: int
    sharpened_count: int = 0


def cut_out(
    scene: Scene,
    width: int,
    height: int,
    tick: tuple[float, float] | None = None,
    watch: Watch = UNWATCHED,
) -> Cutout:
    """Return ``scene``, whose canvas is ``width`` x ``height`` pixels, without overlaps, and cut at the canvas.

    Where the background shows, there is no path: a page is not cut. A white background is left out, as files are seen
    over white. Where a translucent path lies on others or on the background, the parts get their mixed colours; of two
    gradients on one another, the upper one counts with the mean of its colours.

    Args:
        tick: last decimals of the file in pixels, across and down. Points are rounded to them, so that the file states
            both sides of an edge alike; None to round nothing.
        watch: the watch over the run. Once it is over, curves are followed less closely, and spurs stay.
    """
    stacked = _with_background(scene.detach().cpu(), width, height)
    cubics, is_line, path = _curves(stacked, width, height)
    path_count = len(stacked) + 1
    is_opaque = _least_opacity(stacked).numpy() >= CUTTING.opaque

    def owned(chords: Chords) -> tuple[PlanarMap, Integers, int, list[_Stack]]:
        """Return the map of ``chords``, the owner of each face, the number of slivers, and what the owners show."""
        # The canvas is the last path: its edges count before all others.
        mapped = planar_map(chords, path, path_count)
        owners, keys = _numbered(_visible_stacks(mapped.winding != 0, is_opaque))
        return mapped, *without_slivers(mapped, owners, path[mapped.curve]), keys

    error = CUTTING.chord_error_late if watch.is_over() else CUTTING.chord_error
    chords = noded(chords_of(cubics, is_line, error))
    mapped, owners, sliver_count, keys = owned(chords)
    for _ in range(CUTTING.spur_rounds_max):
        mouths = spur_mouths(mapped, owners) if not watch.is_over() else np.zeros((0, 2, 2))
        if not len(mouths):
            break
        thirds = np.linspace(0.0, 1.0, 4)[None, :, None]
        added, lines = mouths[:, :1] + thirds * (mouths[:, 1:] - mouths[:, :1]), np.ones(len(mouths), bool)
        # All that was broken stays so.
        chords = noded(chords.joined(chords_of(added, lines), len(cubics)))
        cubics, is_line = np.concatenate([cubics, added]), np.concatenate([is_line, lines])
        path = np.concatenate([path, np.full(len(mouths), -1)])
        mapped, owners, sliver_count, keys = owned(chords)
    edges = CutEdges(mapped, owners, cubics, is_line, tick)
    loops = {owner: edges.loops(owner) for owner in range(1, len(keys))}
    shown = [owner for owner in sorted(loops, key=lambda each: keys[each][-1]) if loops[owner]]
    used = {row for owner in shown for row in keys[owner]}
    page = None if scene.transparent else (0,)
    drawn = [owner for owner in shown if keys[owner] != page]
    cut = _scene(stacked, [keys[owner] for owner in drawn], [loops[owner] for owner in drawn])
    return Cutout(
        cut if page is None else _on_page(cut, scene.background.cpu()),
        hidden_count=len(stacked) - len(used),
        sliver_count=sliver_count,
        blended_count=sum(1 for row in used if _least_opacity(stacked)[row] < CUTTING.opaque),
        sharpened_count=0 if scene.softness is None else int(scene.softness.is_soft.sum()),
    )


def _on_page(cut: Scene, background: Tensor) -> Scene:
    """Return the scene over its page; a white one is left out."""
    is_white = bool((background >= CUTTING.white).all())
    return cut if is_white else replace(cut, background=background, transparent=False)


# The drawing as curves


def _with_background(scene: Scene, width: int, height: int) -> Scene:
    """Return ``scene`` over nothing; its background is then its lowest path."""
    if scene.transparent:
        return scene
    below = sheet(scene.background, width, height)
    return below.joined(replace(scene, transparent=True, background=torch.zeros(3)))


def sheet(color: Tensor, width: int, height: int) -> Scene:
    """Return a path of one ``color`` [3] that covers a canvas of ``width`` x ``height`` pixels, over nothing."""
    corners = torch.tensor([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    chord = corners.roll(-1, 0) - corners
    segments = torch.stack([corners, corners + chord / 3, corners + chord * 2 / 3], 1)
    return Scene(
        segments, Structure.of_loops([[4]], torch.ones(4, dtype=torch.bool)), color[None],
        torch.ones(1), torch.zeros(3), torch.zeros(1, dtype=torch.int64), transparent=True,
    )  # fmt: skip


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
    rows = torch.tensor([row for row, _ in paints], dtype=torch.int64)
    values = torch.stack([values for _, values in paints]) if paints else torch.zeros(0, STOPS_MAX, 4)
    opacity = values[..., 3].amax(1)
    gradients = None if stacked.gradients is None else _with_stops(stacked.gradients, rows, values)
    generation = stacked.generation[torch.tensor([stack[0] for stack in stacks], dtype=torch.int64)]
    background = torch.zeros(3)
    return Scene(segments, structure, values[:, 0, :3], opacity, background, generation, True, gradients)


def _with_stops(gradients: Gradients, rows: Tensor, values: Tensor) -> Gradients:
    """Return the gradients of the paths ``rows`` with the colours and opacities ``values`` [N, STOPS_MAX, 4]."""
    own = gradients.map(lambda each: each[rows])
    stops, share = own.all_stops(), values[..., 3] / values[..., 3].amax(1, keepdim=True).clamp_min(1e-9)
    last = (stops.count.long() - 1).view(-1, 1, 1).expand(-1, 1, 4)
    stops = replace(stops, inner_color=values[:, 1:-1, :3].contiguous(), opacity=share)
    return replace(own, end_color=values.gather(1, last)[:, 0, :3], stops=stops).without_plain_stops()


def _blended(scene: Scene, stack: _Stack) -> tuple[int, Tensor]:
    """Return the paint that the paths of ``stack`` show together.

    It is the path whose gradient counts, and the colours and opacities of its stops [STOPS_MAX, 4].
    """
    paints = Gradients.none(scene.color) if scene.gradients is None else scene.gradients
    row = stack[0]
    values = _stop_values(scene, paints, row)
    for above in stack[1:]:
        added = _stop_values(scene, paints, above)
        if paints.kind[above] != FLAT and paints.kind[row] != FLAT:
            added = added[: int(paints.all_stops().count[above])].mean(0).expand_as(added)
        elif paints.kind[above] != FLAT:
            row = above
        share, below = added[:, 3:], values[:, 3:] * (1 - added[:, 3:])
        color = (share * added[:, :3] + below * values[:, :3]) / (share + below).clamp_min(1e-9)
        values = torch.cat([color, share + below], 1)
    return row, values


def _stop_values(scene: Scene, paints: Gradients, row: int) -> Tensor:
    """Return the colour and the opacity of each stop of a path [STOPS_MAX, 4]; all are equal in a flat path."""
    color = scene.color[row].expand(STOPS_MAX, 3)
    opacity = scene.opacity[row].expand(STOPS_MAX)
    if paints.kind[row] != FLAT:
        stops = paints.all_stops().map(lambda each: each[row : row + 1])
        color = stops.colors(scene.color[row : row + 1], paints.end_color[row : row + 1])[0]
        opacity = opacity * torch.where(stops.is_used(), stops.opacity, stops.opacity[:, int(stops.count[0]) - 1])[0]
    return torch.cat([color, opacity[:, None]], 1)


def _least_opacity(scene: Scene) -> Tensor:
    """Return the opacity of each path [N] where it is most translucent."""
    return scene.opacity if scene.gradients is None else scene.opacity * scene.gradients.least_opacity()
