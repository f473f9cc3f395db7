"""Fit closed outlines with few lines and cubics: corners are found, and smooth places are exactly smooth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.cycle_search import cheapest_cycle
from warpvec.flat.curves.outline_nodes import find_nodes, roughness, sample_loops
from warpvec.flat.curves.piece_joining import Pieces, join_pieces, rough_pieces
from warpvec.flat.curves.span_costs import span_costs
from warpvec.flat.curves.straight_runs import straight_samples
from warpvec.watch.watch import UNWATCHED, Watch

Curves = tuple[Floats, Mask]
"""The control points [n, 3, 2] of a loop, and a mask of its lines [n]."""


def fit_loops(
    loops: Sequence[Floats],
    tolerance: float | Floats = CURVES.tolerance,
    watch: Watch = UNWATCHED,
    straight_min: float | Floats = math.inf,
) -> list[Curves]:
    """Return the curves for each closed polyline [m, 2].

    The pieces of a loop are those of the cheapest cycle through nodes along it (`find_nodes`): few pieces, lines
    rather than cubics, each within ``tolerance`` pixels (one, or one for each loop) of the outline, and few kinks where
    it is smooth. A rough outline, such as that of a compressed picture, has a larger tolerance. Once the ``watch`` is
    over, the pieces are short, and only roughly smooth, and no outline counts as rough. Level and upright runs of at
    least ``straight_min`` pixels, one or one for each loop, are lines; see `straight_samples`.
    """
    if not loops:
        return []
    samples = sample_loops(loops)
    is_late = watch.is_over()
    nodes = find_nodes(samples, is_late)
    noise = np.zeros(len(loops)) if is_late else roughness(samples)
    allowed = np.maximum(tolerance, np.minimum(CURVES.noise_factor * noise, CURVES.noise_tolerance_max))
    is_straight = straight_samples(samples, np.broadcast_to(straight_min, len(loops)))
    spans = span_costs(samples, nodes, allowed, watch, is_straight)
    loops_of_nodes = list(pairwise(nodes.first))
    if watch.is_over() and np.isinf(spans.cost[:, 1:]).all():  # no piece is longer than from a node to the next
        cycles = [np.arange(first, stop) for first, stop in loops_of_nodes]
    else:
        cycles = [first + np.array(cheapest_cycle(spans.cost[first:stop])) for first, stop in loops_of_nodes]
    pieces = _pieces(nodes.first, cycles, spans.is_line)
    segments = rough_pieces(nodes, pieces) if watch.is_over() else join_pieces(samples, nodes, pieces, allowed)
    stops = np.cumsum([len(cycle) for cycle in cycles])[:-1]
    return list(zip(np.split(segments, stops), np.split(pieces.is_line, stops), strict=True))


def fit_enlarged(
    loops: Sequence[Floats],
    scales: Sequence[float],
    tolerance: float | Floats = CURVES.tolerance,
    watch: Watch = UNWATCHED,
    straight_min: float | Floats = math.inf,
) -> list[Curves]:
    """Return the curves for each closed polyline [m, 2], fitted as if it were so many times larger.

    Its corners and bends may then be closer to each other. The ``tolerance`` and
    ``straight_min``, one or one for each, are in pixels of the given polylines.
    """
    larger = [scale * loop for scale, loop in zip(scales, loops, strict=True)]
    fits = fit_loops(larger, tolerance * np.array(scales), watch, straight_min * np.array(scales))
    return [(segments / scale, is_line) for (segments, is_line), scale in zip(fits, scales, strict=True)]


def _pieces(first_node: Integers, cycles: Sequence[Integers], is_line: Mask) -> Pieces:
    start = np.concatenate(cycles)
    rows = np.split(np.arange(len(start)), np.cumsum([len(cycle) for cycle in cycles])[:-1])
    before, after = (np.concatenate([np.roll(row, shift) for row in rows]) for shift in (1, -1))
    end = start[after]
    loop = np.searchsorted(first_node, start, side="right") - 1
    steps = (end - start) % np.diff(first_node)[loop]
    return Pieces(start, end, is_line[start, steps - 1], before, after)
