"""Find the grid that a drawing was made on: the unit of which its numbers are whole, half, quarter or tenth multiples.

A number of a drawing lies on the grid, or anywhere. How many lie on which multiples is told by the drawing itself, as
shares of a mixture (expectation maximisation). The grid is there if its mixture explains the numbers better than none
does, in nats, by more than it takes to say which grid it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import torch
from scipy import sparse
from torch import Tensor

from warpvec.arrays import Floats, Integers, Mask
from warpvec.config.fit_config import AUTO, OFF
from warpvec.flat.chains.parts import ARC, SIZES, bulge_of, drawn
from warpvec.flat.chains.solve import Sketch, deviations, radius_slopes, solved
from warpvec.flat.simplification.outline_samples import segment_loops
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.forms.form import ANGLE, FIRST, SECOND
from warpvec.geometry.forms.registry import ROUND_RECT
from warpvec.geometry.scene import Scene
from warpvec.svg.arcs import are_arcs, own_circles

SIDES = (24, 16, 20, 32, 48, 64, 100, 128, 256, 512)
"""Sides of artboards in units, the commonest first: those that icons and logos are drawn on."""

PARTS = (1, 2, 4, 10)
"""A number is a multiple of the unit over one of these."""

STEP_MIN = 1.0
"""Shortest step in pixels of the multiples of a grid: places on finer ones are so dense that any number is near one."""

ROUNDS = 30
"""Rounds of expectation maximisation. Shares of a dozen numbers have settled after ten."""

PRIOR = 1.0
"""Numbers that each share of the mixture counts in advance, so that none vanishes."""

SURE = 0.9
"""Least probability by which a number is taken for a multiple: one in ten of those at the limit is none."""

EVIDENCE_MIN = math.log(len(SIDES)) + math.log(100.0)
"""Nats by which a grid must explain the numbers better than none: which side it has, and one wrong in a hundred."""

COARSER_SHARE = 0.5
"""Share of the nats of a grid with which one of whole multiples of its unit is taken: halves and quarters of a unit are
as short to say, and a fine grid explains more by chance."""

SOLUTIONS = 2
"""How often numbers are held: those that follow from the others are near their places in the second."""

LEVEL = math.sin(math.radians(0.1))
"""Least coordinate of a direction that is slanted: relations make level ones exact."""

HANDLE_ERROR, RADIUS_MIN = 0.01, 0.5
"""Error in pixels of the handles of a cubic that is an arc, and least radius."""

HALVES_MIN = 0.3
"""Least share of numbers on half units with which a file is written in units: with fewer they are no shorter. Of 107
icons on a grid 100 have more, and of emoji and logos that are said to be on one none has."""

EXACT = 0.02
"""Deviation in pixels of numbers that were put on a grid: of what rounding and solutions leave."""

CORNER_VAGUE = 1.0 / math.sqrt(2.0 - 6.0 / math.pi)
"""Deviation of the radius of a rectangle's corner over that of a side. A change of the radius moves the outline there
by so much less: by cos(a) + sin(a) - 1 of it, over the angles of a quarter turn."""

SAME_CIRCLE = 0.05
"""Largest difference in pixels of the centres and radii of arcs that are parts of one: its inner nodes say nothing."""


class Grid(NamedTuple):
    """A grid from the upper left corner of the canvas.

    Attributes:
        unit: its unit in pixels.
        side: the longer side of the canvas in units.
        shares: of the numbers that are multiples of the unit over each of ``PARTS``, and that are none [5].
        spread: deviation of numbers in pixels.
        nats: by which it explains the numbers better than none.
    """

    unit: float
    side: int
    shares: Floats
    spread: float
    nats: float

    def held(self, values: Floats, vague: Floats | None = None) -> Floats:
        """Return ``values`` [K] with those on the grid that are surely meant to be there; the others are NaN.

        A value that is ``vague`` [K], as `deviations` tells, has a larger deviation than others by this factor.
        """
        spread = self.spread * np.maximum(np.ones(len(values)) if vague is None else vague, 1.0)
        density, places = _densities(values, self.unit, spread[:, None])
        weighted = self.shares * density
        multiples = weighted[:, :-1]
        sure = multiples.sum(1) / weighted.sum(1)
        return np.where(sure >= SURE, places[np.arange(len(values)), multiples.argmax(1)], np.nan)

    def put(self, values: Floats, vague: Floats | None = None) -> Floats:
        """Return ``values`` [K] with those on the grid that are surely meant to be there; as `held`."""
        places = self.held(values, vague)
        return np.where(np.isnan(places), values, places)


def grid_of(values: Floats, size: tuple[int, int], spread: float, wanted: str = AUTO) -> Grid | None:
    """Return the grid of a drawing with the numbers ``values`` [K] in pixels; None if it has none.

    Args:
        values: coordinates, radii and widths. Those that say the same count once.
        size: height and width of the canvas in pixels.
        spread: standard deviation of the numbers in pixels.
        wanted: "auto", "off", or its units along the longer side.
    """
    own = _distinct(values, spread)
    if wanted == OFF or not len(own):
        return None
    if wanted != AUTO:
        return _explained(own, max(size) / int(wanted), int(wanted), spread) if fits(size, int(wanted)) else None
    # The centre and the border of any drawing may be on a grid.
    usual = np.array([0.0, *(share * side for side in size for share in (0.5, 1.0))])
    own = own[np.abs(own[:, None] - usual).min(1) > 2.0 * spread]
    found = [_explained(own, max(size) / side, side, spread) for side in SIDES if fits(size, side)]
    best = max(found, key=lambda grid: grid.nats, default=None)
    # Whole pixels are multiples of some part of many units: the unit itself must explain more.
    pixels = _explained(own, 1.0, max(size), spread, (1,))
    if best is None or best.nats < max(pixels.nats, 0.0) + EVIDENCE_MIN:
        return None
    coarser = [grid for grid in found if best.side % grid.side == 0 and grid.nats >= COARSER_SHARE * best.nats]
    return min(coarser, key=lambda grid: grid.side)


def fits(size: tuple[int, int], side: int) -> bool:
    """Return whether the shorter side of a canvas has a whole number of units too, and a unit a pixel at least."""
    return max(size) >= side and min(size) * side % max(size) == 0


def _distinct(values: Floats, spread: float) -> Floats:
    """Return ``values`` [K] without those that are nearly equal to others: what is said twice is no second proof."""
    ordered = np.sort(values)
    return ordered[np.append(True, np.diff(ordered) > 2.0 * spread)] if len(ordered) else ordered


def _explained(values: Floats, unit: float, side: int, spread: float, parts: tuple[int, ...] = PARTS) -> Grid:
    density, _ = _densities(values, unit, spread, parts)
    shares = np.full(len(parts) + 1, 1.0 / (len(parts) + 1))
    for _ in range(ROUNDS):
        weighted = shares * density
        counts = (weighted / weighted.sum(1, keepdims=True)).sum(0) + PRIOR
        shares = counts / counts.sum()
    return Grid(unit, side, shares, spread, float(np.log((shares * density).sum(1)).sum()))


def _densities(
    values: Floats, unit: float, spread: float | Floats, parts: tuple[int, ...] = PARTS
) -> tuple[Floats, Floats]:
    """Return the densities of ``values`` [K] over an even one, for each of P ``parts`` and for none, and the multiples.

    The shapes are [K, P + 1] and [K, P].
    """
    steps = unit / np.array(parts)
    places = np.round(values[:, None] / steps) * steps
    off = (values[:, None] - places) / spread
    near = steps / (spread * math.sqrt(2.0 * math.pi)) * np.exp(-0.5 * np.square(off))
    near *= steps >= STEP_MIN
    return np.concatenate([near, np.ones((len(values), 1))], 1), places


class _Numbers(NamedTuple):
    """The numbers of a sketch that may lie on a grid.

    Attributes:
        nodes: columns of coordinates and axes [N].
        arcs: the parts that are arcs [A].
        values: of the coordinates, then the radii [N + A].
        vague: the deviation of each over that of a place, as `deviations` tells [N + A].
    """

    nodes: Integers
    arcs: Integers
    values: Floats
    vague: Floats

    @staticmethod
    def of(sketch: Sketch) -> _Numbers:
        """Return those of a solved ``sketch``. Where slanted parts meet smoothly, a node follows from other numbers."""
        ends = np.concatenate([columns[:4] for columns in sketch.columns])
        nodes = np.setdiff1d(np.append(ends, np.array([*sketch.axes.values()], np.int64)), _slanted_joints(sketch))
        freed = sketch.freed
        nodes = np.setdiff1d(nodes, np.concatenate([nodes[:0], *(sketch.columns[part][:4] for part in freed)]))
        arcs = np.setdiff1d(sketch.rows_of_kind(ARC), freed)
        known = [radius_slopes(sketch, arc) for arc in arcs.tolist()]
        rows = np.concatenate([np.arange(len(nodes)), len(nodes) + np.repeat(np.arange(len(arcs)), SIZES[ARC])])
        columns = np.concatenate([nodes, *(sketch.columns[arc] for arc in arcs)])
        slopes = np.concatenate([np.ones(len(nodes)), *(own for _, own in known)])
        shape = (len(nodes) + len(arcs), len(sketch.numbers))
        values = np.concatenate([sketch.numbers[nodes], [radius for radius, _ in known]])
        return _Numbers(nodes, arcs, values, deviations(sketch, sparse.csr_matrix((slopes, (rows, columns)), shape)))


def _slanted_joints(sketch: Sketch) -> Integers:
    """Return the columns of nodes where parts meet smoothly in a direction that is neither level nor upright."""
    found = [np.zeros(0, np.int64)]
    for before in sketch.smooth[:, 0].tolist():
        _, ways = drawn(int(sketch.kind[before]), sketch.of(before)[None])
        if np.abs(ways[0, 1]).min() > LEVEL:
            found.append(sketch.columns[before][2:4])
    return np.concatenate(found)


def determined_numbers(sketch: Sketch) -> Floats:
    """Return the numbers [K] of a solved ``sketch`` that its chains determine as well as a place."""
    found = _Numbers.of(sketch)
    return found.values[found.vague <= 1.0]


def hold_grid(sketch: Sketch, grid: Grid) -> None:
    """Solve ``sketch`` with the numbers on the ``grid`` that are surely meant to be there.

    A node where a line becomes an arc is hardly seen: it follows from the radius. So radii and coordinates are held,
    and then those that came near by that.
    """
    for _ in range(SOLUTIONS):
        found = _Numbers.of(sketch)
        places, radii = np.split(grid.held(found.values, found.vague), [len(found.nodes)])
        is_held = np.isfinite(places)
        sketch.numbers[found.nodes[is_held]] = places[is_held]
        sketch.fixed = sorted({*sketch.fixed, *found.nodes[is_held].tolist()})
        sketch.given = [
            (arc, radius) for arc, radius in zip(found.arcs.tolist(), radii.tolist(), strict=True) if radius > 0.0
        ]
        solved(sketch)
    for arc, radius in sketch.given:
        # The solution leaves the last decimals of a file.
        sketch.numbers[sketch.columns[arc][4]] = bulge_of(sketch.of(arc), radius)


def on_grid(scene: Scene, grid: Grid, stays: Tensor | None = None) -> Scene:
    """Return ``scene`` with the numbers of its level forms and the widths of its strokes on the ``grid``.

    Paths of which ``stays`` [N] is true stay as they are.
    """
    stays = torch.zeros(len(scene), dtype=torch.bool) if stays is None else stays
    if scene.strokes is not None:
        old = scene.strokes.width.double().numpy()
        width = np.where(stays.numpy(), old, grid.put(old))
        scene = replace(scene, strokes=replace(scene.strokes, width=torch.from_numpy(width).to(scene.strokes.width)))
    if scene.forms is None:
        return scene
    parameters = scene.forms.parameters.clone()
    for kind, form, paths in scene.forms.groups():
        own = parameters[paths].double()
        own = own[is_level := (own[:, ANGLE].abs() * own[:, FIRST : SECOND + 1].amax(1) <= grid.spread) & ~stays[paths]]
        numbers = form.numbers(own)
        vague = np.ones(numbers.shape)
        if kind == ROUND_RECT:
            vague[:, -1] = CORNER_VAGUE
        put = torch.from_numpy(grid.put(numbers.numpy().ravel(), vague.ravel())).reshape(numbers.shape)
        parameters[paths[is_level]] = form.parameters(put, torch.zeros(len(own)).double()).to(parameters)
    return scene.with_forms(replace(scene.forms, parameters=parameters))


def grid_side(scene: Scene, size: tuple[int, int], wanted: str) -> int:
    """Return the units along the longer side of the grid that the numbers of a finished ``scene`` lie on; 0 for none.

    Args:
        scene: a drawing whose numbers were put on its grid.
        size: height and width of the canvas in pixels.
        wanted: as in `grid_of`.
    """
    values = stated_numbers(scene)
    grid = grid_of(values, size, EXACT, wanted)
    if grid is None or grid.side == max(size):
        return 0
    return grid.side if wanted != AUTO or share_on_halves(values, grid.unit) >= HALVES_MIN else 0


def share_on_halves(values: Floats, unit: float) -> float:
    """Return the share of the numbers ``values`` [K] that are whole multiples of half a ``unit`` in pixels."""
    halves = values / (unit / 2.0)
    return float((np.abs(halves - np.round(halves)) * unit / 2.0 <= EXACT).mean()) if len(halves) else 0.0


def arcs_of(scene: Scene) -> tuple[Mask, Mask, Floats]:
    """Return which rows [S] of ``scene`` are arcs, which go on with the arc of the row before, and their radii [S]."""
    control, structure = whole_curves(scene).double().numpy(), scene.structure
    return arcs_among(control, structure.segment_next.numpy(), ~structure.end_rows.numpy())


def arcs_among(control: Floats, after: Integers, is_shown: Mask | bool = True) -> tuple[Mask, Mask, Floats]:
    """Return which curves [S, 4, 2] are arcs, which go on with the arc of the curve before, and their radii [S].

    ``after`` is the curve after each [S]; those that are not shown [S] are no arcs.
    """
    x, y, radius = own_circles(control[:, :3], control[:, 3])
    is_arc = are_arcs(control[:, :3], control[:, 3], HANDLE_ERROR, RADIUS_MIN) & is_shown
    circle = np.stack([x, y, radius], 1)
    goes_on = np.zeros(len(control), bool)
    goes_on[after] = is_arc & is_arc[after] & (np.abs(circle - circle[after]).max(1) <= SAME_CIRCLE)
    return is_arc, goes_on, radius


def stated_numbers(scene: Scene, but: Iterable[int] = ()) -> Floats:
    """Return the numbers that a file says of ``scene`` [K]: nodes, radii, sides of forms, and widths of strokes.

    Those of loops ``but`` these are left out.
    """
    control, structure = whole_curves(scene).double().numpy(), scene.structure
    found, is_outline = list[Floats](), ~np.isin(segment_loops(scene), list(but))
    if scene.forms is not None:
        is_outline &= ~scene.forms.is_form.numpy()[structure.segment_path.numpy()]
        for _, form, paths in scene.forms.groups():
            found.append(form.numbers(scene.forms.parameters[paths].double()).numpy().ravel())
    is_arc, goes_on, radius = arcs_of(scene)
    found += [control[is_outline & ~goes_on, 0].ravel(), radius[is_arc & is_outline]]
    if scene.strokes is not None:
        found.append(scene.strokes.width.double().numpy())
    values: Floats = np.concatenate(found)
    return values[values > 0.0]
