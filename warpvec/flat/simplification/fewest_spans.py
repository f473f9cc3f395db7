"""Choose which nodes of closed outlines stay, so that few segments show the outlines within a tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.span_candidates import Outlines, span_candidates


@dataclass(frozen=True, eq=False)
class ChosenSpans:
    """The segments of the simpler outlines.

    Attributes:
        first: row of the node at which each starts [S].
        size: number of old segments that each replaces [S].
        is_line: [S].
        handles: [S, 2, 2].
        counts: segments of each loop [L].
    """

    first: Integers
    size: Integers
    is_line: Mask
    handles: Floats
    counts: Integers


def fewest_spans(outlines: Outlines, detail: Floats, price: float) -> ChosenSpans:
    """Return the cheapest segments: ``price`` for each curve, in cubic pixels, and the error of each.

    Args:
        outlines: closed outlines.
        detail: largest root mean square of the visible distance of what replaces each segment [R], in pixels.
        price: error that a curve less may cost, in cubic pixels.
    """
    table: _Table = {}
    for spans in span_candidates(outlines, detail):
        for first, cost, handles in zip(spans.first.tolist(), spans.cost, spans.handles, strict=True):
            table.setdefault(first, []).append((spans.size, cost, handles))
    chosen, counts = [], []
    for start, stop in pairwise(outlines.loop_first.tolist()):
        found = _best_loop(outlines, table, start, stop - start, price)
        chosen += found
        counts.append(len(found))
    first, size, is_line, handles = zip(*chosen, strict=True)
    return ChosenSpans(np.array(first), np.array(size), np.array(is_line), np.stack(handles), np.array(counts))


_Table = dict[int, list[tuple[int, Floats, Floats]]]
_Chosen = list[tuple[int, int, bool, Floats]]
_Step = tuple[int, int, Floats]


def _best_loop(outlines: Outlines, table: _Table, start: int, count: int, price: float) -> _Chosen:
    """Return the cheapest spans around a loop of ``count`` rows.

    A closed outline has no first node. The sharpest one serves as such; then a node of the result does, opposite.
    """
    smooth = outlines.is_smooth[start : start + count]
    seam = int(np.argmin(smooth))
    total, found = _best_chain(outlines, table, start, count, seam, price)
    if smooth[seam] and len(found) > 1:
        seam = found[len(found) // 2][0] - start
        again, other = _best_chain(outlines, table, start, count, seam, price)
        found = other if again < total else found
    return found


def _best_chain(
    outlines: Outlines, table: _Table, start: int, count: int, seam: int, price: float
) -> tuple[float, _Chosen]:
    """Return the cheapest spans from the node ``seam`` of a loop around to itself, and their cost.

    The cost of reaching each node is kept for both kinds of the last segment, curve and line.
    """
    best = np.full((count + 1, 2), np.inf)
    best[0] = 0.0
    came: list[list[_Step | None]] = [[None, None] for _ in range(count + 1)]
    prices = price * np.array([SIMPLIFICATION.curve_price, SIMPLIFICATION.line_price])
    for place in range(count):
        here, row = best[place], start + (seam + place) % count
        cheapest = int(np.argmin(here))
        for size, cost, handles in table.get(row, ()):
            after = place + size
            for kind in (0, 1) if after <= count else ():
                # Two lines do not make a smooth node.
                before = 0 if kind == 1 and place and outlines.is_smooth[row] else cheapest
                total = here[before] + cost[kind] + prices[kind]
                if total < best[after, kind]:
                    best[after, kind] = total
                    came[after][kind] = (place, before, handles[kind])
    last = int(np.argmin(best[count]))
    return float(best[count, last]), _traced(came, start, count, seam, last)


def _traced(came: list[list[_Step | None]], start: int, count: int, seam: int, kind: int) -> _Chosen:
    """Return the spans of a loop in order, from how each node was reached; the last segment is of ``kind``."""
    place, chosen = count, []
    while place:
        step = came[place][kind]
        assert step is not None
        before, before_kind, handles = step
        chosen.append((start + (seam + before) % count, place - before, bool(kind), handles))
        place, kind = before, before_kind
    return chosen[::-1]
