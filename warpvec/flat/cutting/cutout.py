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

from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.arrangement import Stack, arranged, least_opacity
from warpvec.flat.cutting.cut_edges import CutEdges
from warpvec.flat.cutting.fewest_parts import CurvePart
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
        watch: the watch over the run. Once it is over, curves are followed less closely, spurs stay, and parts are not
            joined.
    """
    laid = arranged(scene, width, height, watch)
    stacked, keys = laid.stacked, laid.keys
    edges = CutEdges(laid.mapped, laid.owners, laid.cubics, laid.is_line, tick, watch)
    loops = {owner: edges.loops(owner) for owner in range(1, len(keys))}
    shown = [owner for owner in sorted(loops, key=lambda each: keys[each][-1]) if loops[owner]]
    used = {row for owner in shown for row in keys[owner]}
    page = None if scene.transparent else (0,)
    drawn = [owner for owner in shown if keys[owner] != page]
    cut = _scene(stacked, [keys[owner] for owner in drawn], [loops[owner] for owner in drawn])
    return Cutout(
        cut if page is None else _on_page(cut, scene.background.cpu()),
        hidden_count=len(stacked) - len(used),
        sliver_count=laid.sliver_count,
        blended_count=sum(1 for row in used if least_opacity(stacked)[row] < CUTTING.opaque),
        sharpened_count=scene.soft_count,
    )


def _on_page(cut: Scene, background: Tensor) -> Scene:
    """Return the scene over its page; a white one is left out."""
    is_white = bool((background >= CUTTING.white).all())
    return cut if is_white else replace(cut, background=background, transparent=False)


# The result


def _scene(stacked: Scene, stacks: list[Stack], loops: list[list[list[CurvePart]]]) -> Scene:
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


def _blended(scene: Scene, stack: Stack) -> tuple[int, Tensor]:
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
