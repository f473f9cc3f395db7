"""Say outlines as they are traced: as lines, arcs and cubics that meet smoothly or in corners."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.saying import SIZE_MIN, LoopRows, has_size, said_rows
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.outline_nodes import Nodes, find_nodes, roughness, sample_loops
from warpvec.flat.price import number_nats
from warpvec.watch.watch import UNWATCHED, Watch

AT_ONCE = 32
"""Loops whose parts are chosen together, between which the clock is seen."""


def said_loops(
    loops: Sequence[Floats], tolerance: float | Floats = CURVES.tolerance, watch: Watch = UNWATCHED
) -> list[LoopRows]:
    """Return the rows of each closed polyline [m, 2].

    They are the cheapest lines, arcs and cubics; see `choice.chosen_parts`. A rough outline, such as that of a
    compressed picture, may be missed by more. Once the ``watch`` is over, the rows are short, and only roughly smooth.

    Args:
        loops: the polylines.
        tolerance: largest distance in pixels from an outline to what it traces, a number for all loops or one for each.
            The deviation of the places of an outline is ``CURVES.spread_share`` of its tolerance.
        watch: the watch over the run.
    """
    if not loops:
        return []
    samples = sample_loops(loops)
    is_late = watch.is_over()
    nodes = find_nodes(samples, is_late)
    found = _short_rows(nodes)
    rough = np.zeros(len(loops)) if is_late else roughness(samples)
    allowed = np.maximum(tolerance, np.minimum(CURVES.noise_factor * rough, CURVES.noise_tolerance_max))
    nats = number_nats(max(float(np.ptp(loop, 0).max()) for loop in loops))
    for first in range(0, len(loops), AT_ONCE):
        if watch.is_over():
            break
        some = range(first, min(first + AT_ONCE, len(loops)))
        for value in np.unique(allowed[first : first + AT_ONCE]).tolist():
            chains = {loop: _chain(found[loop]) for loop in some if allowed[loop] == value}
            said = said_rows(chains, CURVES.spread_share * value, nats)
            for loop, rows in said.items():
                found[loop] = rows if has_size(rows[0], True) else found[loop]
    return found


def said_enlarged(
    loops: Sequence[Floats],
    scales: Sequence[float],
    tolerance: float | Floats = CURVES.tolerance,
    watch: Watch = UNWATCHED,
) -> list[LoopRows]:
    """Return the rows of each closed polyline [m, 2] as `said_loops` finds them if it were so many times larger.

    Its corners and bends may then be closer to each other. The ``tolerance`` is in pixels of the given polylines.
    """
    larger = [scale * loop for scale, loop in zip(scales, loops, strict=True)]
    found = said_loops(larger, tolerance * np.array(scales), watch)
    return [(rows / scale, is_line) for (rows, is_line), scale in zip(found, scales, strict=True)]


def _chain(short: LoopRows) -> Chain:
    rows = short[0]
    return Chain.of(np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], 1), True, is_traced=True)


def _short_rows(nodes: Nodes) -> list[LoopRows]:
    """Return rows from each node of a loop to the next, smooth at smooth nodes."""
    found = []
    for first, stop in pairwise(nodes.first.tolist()):
        own = slice(first, stop)
        start, way, is_corner = nodes.point[own], nodes.direction[own], nodes.is_corner[own, None]
        third = (np.roll(start, -1, axis=0) - start) / 3.0
        reach = np.linalg.norm(third, axis=1, keepdims=True)
        leaving = np.where(is_corner, third, reach * way)
        arriving = np.where(np.roll(is_corner, -1, axis=0), third, reach * np.roll(way, -1, axis=0))
        rows = np.stack([start, start + leaving, start + 3.0 * third - arriving], 1)
        has_length = reach[:, 0] > SIZE_MIN  # two corners may be found at one place
        rows = rows[has_length] if has_length.any() else rows
        found.append((rows, np.zeros(len(rows), bool)))
    return found
