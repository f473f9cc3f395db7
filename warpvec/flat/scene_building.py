"""From the regions of a picture to a scene of clean paths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch

from warpvec.flat.chains.saying import LoopRows
from warpvec.flat.chains.traced import said_enlarged
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.layers.outlines import Outline, outlines
from warpvec.flat.layers.stacking import StackedLayer, stack
from warpvec.flat.pixels.outlines import lines_through
from warpvec.flat.regions.fewer_regions import with_fewer_regions
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.regions import Regions
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import Stops
from warpvec.geometry.structure import Structure
from warpvec.watch.watch import UNWATCHED, Watch


def scene_of(
    regions: Regions, tolerance: float = CURVES.tolerance, watch: Watch = UNWATCHED, is_fine: bool = False
) -> Scene:
    """Return the drawing of ``regions``: a path for each layer, on the canvas's paint or none.

    Args:
        regions: regions of a picture.
        tolerance: largest distance in pixels between the outlines in the picture and the curves.
        watch: the watch over the run. When it is over, or little time is left, the layers so far must do, the lowest
            first, and outlines are fitted less well.
        is_fine: whether outlines are found on a finer grid, as those of icons are.
    """
    watch = watch.ahead(DRAWING.share_after_tracing)
    if watch.is_over():
        regions = with_fewer_regions(regions, DRAWING.layers_min + 1)  # and the canvas
    layers: list[StackedLayer] = []
    loops: list[list[Outline]] = []
    for layer in stack(regions, watch):
        if watch.is_over() and len(layers) >= DRAWING.layers_min:
            break
        found = outlines(regions, layer, watch, is_fine)
        if found:
            layers.append(layer)
            loops.append(found)
    fits = _fitted(loops, tolerance, watch)
    shown = [index for index, found in enumerate(fits) if found]  # of the others there was no time for a loop
    layers, fits = [layers[index] for index in shown], [fits[index] for index in shown]
    flat = [fit for found in fits for fit in found]
    segments = np.concatenate([segments for segments, _ in flat]) if flat else np.zeros((0, 3, 2))
    is_line = np.concatenate([mask for _, mask in flat]) if flat else np.zeros(0, bool)
    counts = [[len(segments) for segments, _ in found] for found in fits]
    structure = Structure.of_loops(counts, torch.from_numpy(is_line) if is_line.any() else None)
    return _painted(regions, layers, torch.from_numpy(segments).float(), structure)


def _fitted(loops: Sequence[Sequence[Outline]], tolerance: float, watch: Watch) -> list[list[LoopRows]]:
    """Return the curves of the ``loops`` of each layer, or of the lowest layers once the ``watch`` is over."""
    fits: list[list[LoopRows]] = []
    for first in range(0, len(loops), DRAWING.layers_at_once):
        if watch.is_over() and len(fits) >= DRAWING.layers_min:
            break
        some = loops[first : first + DRAWING.layers_at_once]
        found = iter(_fitted_together([loop for each in some for loop in each], tolerance, watch))
        fits += [[fit for fit in (next(found) for _ in each) if fit is not None] for each in some]
    return fits


def _fitted_together(loops: Sequence[Outline], tolerance: float, watch: Watch) -> list[LoopRows | None]:
    """Return the curves of ``loops``, together unless they have very many points.

    Then the longest are fitted first, and those that are left once the ``watch`` is over are None.
    """
    sizes = [len(loop.points) for loop in loops]
    if sum(sizes) <= DRAWING.points_at_once:
        return [*_curves(loops, tolerance, watch)]
    fits: list[LoopRows | None] = [None] * len(loops)
    longest_first = sorted(range(len(loops)), key=lambda index: -sizes[index])
    parts = np.cumsum([sizes[index] for index in longest_first]) // DRAWING.points_at_once
    for part in np.unique(parts):
        if part > parts[0] and watch.is_over():
            break
        chosen = [index for index, own in zip(longest_first, parts, strict=True) if own == part]
        for index, fit in zip(chosen, _curves([loops[index] for index in chosen], tolerance, watch), strict=True):
            fits[index] = fit
    return fits


def _curves(loops: Sequence[Outline], tolerance: float, watch: Watch) -> list[LoopRows]:
    """Return the curves of ``loops``: lines through the corners of exact ones, and the best curves along others."""
    fits = iter(_fitted_curves([loop for loop in loops if not loop.is_exact], tolerance, watch))
    return [_lines_of(loop) if loop.is_exact else next(fits) for loop in loops]


def _lines_of(loop: Outline) -> LoopRows:
    return lines_through(loop.points), np.ones(len(loop.points), bool)


def _fitted_curves(loops: Sequence[Outline], tolerance: float, watch: Watch) -> list[LoopRows]:
    """Return the curves along ``loops``. Those of thin parts are fitted as if they were larger."""
    if not loops:
        return []
    scales = np.array([loop.scale for loop in loops])
    is_dot = np.array([np.ptp(loop.points, 0).max() < LETTERING.dot_side for loop in loops], bool)
    tolerances = np.where(is_dot, tolerance / scales, tolerance)
    return said_enlarged([loop.points for loop in loops], scales.tolist(), tolerances, watch)


def _painted(regions: Regions, layers: Sequence[StackedLayer], segments: torch.Tensor, structure: Structure) -> Scene:
    rows, paints = [layer.members[0] for layer in layers], regions.paints
    chosen = paints.select(np.array(rows, np.int64))
    color, opacity = torch.from_numpy(chosen.color).float(), torch.from_numpy(chosen.opacity).float()
    canvas = regions.canvas
    is_opaque = canvas is not None and paints.opacity[canvas] > 0
    background = torch.from_numpy(paints.color[canvas]).float() if is_opaque else torch.zeros(3)
    generation = torch.zeros(len(rows), dtype=torch.int64)
    return Scene(segments, structure, color, opacity, background, generation, not is_opaque, _gradients(chosen))


def _gradients(paints: Paints) -> Gradients | None:
    """Return the gradients of a path for each of the ``paints``; None if all are flat."""
    if not paints.kind.any():
        return None
    count, kind = (torch.from_numpy(values).int() for values in (paints.count, paints.kind))
    offset, inner, shown, geometry, end_color = (
        torch.from_numpy(values).float()
        for values in (paints.offset, paints.inner_color, paints.shown, paints.geometry, paints.end_color)
    )
    stops = Stops(count, offset, inner, shown, geometry[:, 4].contiguous())
    return Gradients(kind, geometry[:, :4].contiguous(), end_color, stops).without_plain_stops()
