"""From chains to a sketch: the chosen parts as nodes, bulges and handles, and which joints are smooth."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Integers
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.choice import Part, chosen_parts, is_smooth_joint
from warpvec.flat.chains.parts import ARC, LINE
from warpvec.flat.chains.solve import Sketch
from warpvec.flat.cutting.cut_edges import between


def parted(chain: Chain, spread: float, number_nats: float) -> tuple[Chain, list[Part]]:
    """Return a chain and its cheapest parts.

    A closed chain begins at a corner, or where a part ends in a first search.
    """
    if chain.is_closed:
        corners = np.flatnonzero(chain.is_corner)
        if len(corners):
            start = int(corners[0])
        else:
            parts = chosen_parts(chain, spread, number_nats)
            start = parts[len(parts) // 2].first if len(parts) > 1 else 0
        chain = chain.begun_at(start)
    return chain, chosen_parts(chain, spread, number_nats)


def sketch_of(found: list[tuple[Chain, list[Part]]], spread: float) -> Sketch:
    """Return the sketch of chains with their parts."""
    kinds, owners, firsts, lasts = (list[int]() for _ in range(4))
    columns = list[Integers]()
    values: list[float] = []
    smooth: list[tuple[int, int]] = []
    ranges: list[tuple[int, int]] = []
    for number, (chain, parts) in enumerate(found):
        begin, node = len(kinds), len(values)
        places = [part.first for part in parts] + ([] if chain.is_closed else [parts[-1].last])
        values += chain.points[places].ravel().tolist()
        count = len(places)
        for k, part in enumerate(parts):
            own = [node + 2 * k, node + 2 * k + 1]
            following = (k + 1) % count
            own += [node + 2 * following, node + 2 * following + 1]
            more = _more_numbers(chain, part)
            own += range(len(values), len(values) + len(more))
            values += more
            kinds.append(part.kind)
            columns.append(np.array(own))
            owners.append(number)
            firsts.append(part.first)
            lasts.append(part.last)
        ranges.append((begin, len(kinds)))
        smooth += _smooth_joints(chain, parts, begin, spread)
    pairs = np.array(smooth, np.int64).reshape(-1, 2)
    return Sketch(
        np.array(kinds), columns, np.array(values), np.array(owners), np.array(firsts), np.array(lasts), pairs, ranges,
         [chain for chain, _ in found],
    )  # fmt: skip


def _more_numbers(chain: Chain, part: Part) -> list[float]:
    """Return the numbers of a part beside its ends."""
    if part.kind == LINE:
        return []
    if part.kind == ARC:
        return [part.bulge]
    if part.handles is not None:
        joined: list[float] = part.handles.ravel().tolist()
        return joined
    curve = chain.curves[chain.curve[part.first]]
    start, stop = chain.parameters[part.first, 0], chain.parameters[part.last - 1, 1]
    own = between(curve[None], start[None], stop[None])[0]
    handles: list[float] = own[1:3].ravel().tolist()
    return handles


def _smooth_joints(chain: Chain, parts: list[Part], begin: int, spread: float) -> list[tuple[int, int]]:
    """Return the pairs of parts that go on in one direction, numbered from ``begin`` on."""
    found, count = [], len(parts)
    for k in range(count if chain.is_closed else count - 1):
        before, after = parts[k], parts[(k + 1) % count]
        lengths = [float(chain.lengths[each.first : each.last].sum()) for each in (before, after)]
        may_be = count > 1 and not chain.is_corner[after.first]
        if may_be and is_smooth_joint(before, after, spread, (lengths[0], lengths[1])):
            found.append((begin + k, begin + (k + 1) % count))
    return found
