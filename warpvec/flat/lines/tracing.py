"""The lines of a drawing: from its ink to strokes that are fitted to the picture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from warpvec.arrays import Floats
from warpvec.config.fit_config import OFF, FitConfig
from warpvec.flat.chains.chains import with_chains
from warpvec.flat.constants.lines import LINES
from warpvec.flat.constants.mono import MONO
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.lines.branches import find_branches
from warpvec.flat.lines.dots import find_dots
from warpvec.flat.lines.ink import Ink, find_ink
from warpvec.flat.lines.line import DrawnLine, read_back, scene_of
from warpvec.flat.lines.local_skeleton import filled_grid
from warpvec.flat.lines.shared_nodes import attached_ends, with_shared_nodes
from warpvec.flat.lines.wide_areas import WideAreas, find_wide_areas, without
from warpvec.flat.lines.widths import by_width
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.strokes.attempts import form_of_line
from warpvec.flat.strokes.center_lines import joined
from warpvec.flat.strokes.inner_disks import Boundary, boundary_of, inner_disks
from warpvec.flat.strokes.joints import Shape
from warpvec.flat.strokes.line_fitting import Line, Rows, fit_line
from warpvec.geometry.forms.registry import form_of
from warpvec.geometry.scene import over_white
from warpvec.polish.polish import polish
from warpvec.watch.watch import Watch


@dataclass(frozen=True)
class LineTracing:
    """The lines of a picture.

    Attributes:
        lines: in pixels.
        speck_count: number of specks that were left out.
        wide_count: number of areas that are wider than a line, and are drawn by lines along their edges.
        faint_count: number of lines that were left out, because they cover no pixel by half.
    """

    lines: list[DrawnLine]
    speck_count: int
    wide_count: int = 0
    faint_count: int = 0


def trace_lines(image: NDArray[Any], settings: FitConfig, tolerance: float | None, watch: Watch) -> LineTracing:
    """Return the lines of ``image`` [h, w, 3 or 4], floats in [0, 1].

    Args:
        image: dark lines on light paper, or on nothing.
        settings: of the run.
        tolerance: of the outlines, from which the lines come, in pixels; None for one that suits the noise.
        watch: over the run. When it is over, the lines so far must do.
    """
    ink = find_ink(image, tolerance, settings.min_area, watch)
    if np.abs(ink.areas).max(initial=0.0) <= MONO.point_area:
        return LineTracing([], ink.speck_count)
    lines, wide = _lines_of(ink)
    if not lines:
        return LineTracing([], ink.speck_count, wide.number)
    fitted = _fitted(lines, without(ink.paper, wide.hidden), settings, watch)
    return LineTracing(fitted, ink.speck_count, wide.number, ink.faint_count)


def _lines_of(ink: Ink) -> tuple[list[DrawnLine], WideAreas]:
    """Return the lines of ``ink``, and its wide areas, whose outlines are among the lines."""
    boundary = boundary_of(ink.control, float(ink.areas[np.argmax(np.abs(ink.areas))]))
    disks = inner_disks(boundary)
    width = usual_width(boundary, disks.radii)
    dots, grid = find_dots(filled_grid(ink.control, ink.loop, width), width)
    wide = find_wide_areas(grid, width)
    dots += [DrawnLine(fit_line(line, width, LINES.outline_spread, LINES.nodes_max), width) for line in wide.outlines]
    found = find_branches(wide.rest, boundary, disks)
    if not found.kept:
        return dots, wide
    tree = cKDTree(boundary.points)
    shape = Shape(boundary, tree, cKDTree(disks.centers), width, found.widths)
    lines = joined(
        shape,
        found.places,
        [found.ends[k] for k in found.kept],
        found.kept,
        found.junctions,
        length_min=LINES.length_min,
    )
    return dots + [_fitted_line(line, tree, lines.cap) for line in lines.lines], wide


def usual_width(boundary: Boundary, radii: Floats) -> float:
    """Return the width that half of the outline of lines has at most, in pixels."""
    order = np.argsort(radii)
    total = np.cumsum(boundary.lengths[order])
    return max(2.0 * float(radii[order][np.searchsorted(total, total[-1] / 2.0)]), 1.0)


def _fitted_line(line: Line, tree: cKDTree, cap: int) -> DrawnLine:
    width = 2.0 * float(np.median(tree.query(line.points)[0]))
    return DrawnLine(fit_line(line, width, LINES.spread, LINES.nodes_max), width, cap)


def _fitted(lines: list[DrawnLine], paper: Floats, settings: FitConfig, watch: Watch) -> list[DrawnLine]:
    """Return ``lines`` with shared widths, fitted to the share of ``paper`` in each pixel [h, w]."""
    paths = by_width(lines)
    before = [line for path in paths for line in path]
    attached = attached_ends(before)
    if watch.is_over():
        return with_shared_nodes(before, attached)
    in_pixels = replace(settings, grid=OFF)
    critic = Critic(torch.from_numpy(np.repeat(paper[..., None], 3, 2).astype(np.float32)), in_pixels)
    watch.listener.hold()  # from now on, there are lines to save
    drawn = polish(
        critic.target, over_white(scene_of(paths)), settings, watch.part(planned=LINES.iterations),
        iterations=LINES.iterations, values_exact_max=SIMPLIFICATION.values_exact_max, gain_min=LINES.gain_min,
    ).scene  # fmt: skip
    lines = [line for path in read_back(drawn, paths) for line in path]
    return with_shared_nodes(_as_designed(lines, critic, watch), attached)


def _as_designed(lines: list[DrawnLine], critic: Critic, watch: Watch) -> list[DrawnLine]:
    """Return fitted ``lines`` as forms, or of lines, arcs and cubics, where the picture of the ``critic`` allows it."""
    detail = critic.config.detail
    found = [[_as_form(line, detail)] for line in lines]
    scene = with_chains(over_white(scene_of(found)), critic, watch, detail)
    return [line for path in read_back(scene, found) for line in path]


def _as_form(line: DrawnLine, detail: float) -> DrawnLine:
    """Return a closed ``line`` that is a circle, an ellipse or a rectangle as that form; others stay."""
    form = None if line.rows.is_open else form_of_line(line.rows, [], line.width, detail)
    if form is None:
        return line
    rows = Rows(form.curves, np.array(form_of(form.kind).is_line), False)
    return replace(line, rows=rows, form=form)
