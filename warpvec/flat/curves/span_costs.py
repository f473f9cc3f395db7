"""Costs of one line or one cubic in place of the outline between two nodes, for all pairs worth a try."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.cubic_fitting import fit_cubics
from warpvec.flat.curves.outline_nodes import Nodes, Samples
from warpvec.flat.curves.straight_runs import straight_counts
from warpvec.watch.watch import UNWATCHED, Watch


class SpanCosts(NamedTuple):
    """Costs [N, K] of the pieces from each node to the one that is k + 1 nodes further, infinite for impossible ones.

    ``is_line`` [N, K] says which pieces are lines.
    """

    cost: Floats
    is_line: Mask


class Places(NamedTuple):
    """B pieces: nodes ``start`` and ``end`` [B], points between them [B, S, 2], and their parameters [B, S]."""

    start: Integers
    end: Integers
    points: Floats
    parameters: Floats


def span_costs(
    samples: Samples, nodes: Nodes, tolerance: Floats, watch: Watch = UNWATCHED, is_straight: Mask | None = None
) -> SpanCosts:
    """Return the costs of pieces that stay within ``tolerance`` pixels [L] of each outline.

    Only lines may replace outlines that are straight on purpose; ``is_straight`` says which samples [M] are.
    Once the ``watch`` is over, no longer pieces are tried; at first only those from each node to the next.
    """
    loop = np.repeat(np.arange(len(nodes.first) - 1), np.diff(nodes.first))
    count = np.diff(nodes.first)[loop]
    longest = int(min(CURVES.span_length_max, count.max() - 1))
    spans = SpanCosts(np.full((len(loop), longest), np.inf), np.zeros((len(loop), longest), bool))
    active, is_likely = np.arange(len(loop)), _likely_ends(nodes)
    for length in range(1, longest + 1, CURVES.spans_at_once):
        count_at_once = 1 if watch.is_over() else CURVES.spans_at_once
        lengths = np.arange(length, min(length + count_at_once, longest + 1))
        start, steps = (grid.ravel() for grid in np.meshgrid(active, lengths, indexing="ij"))
        end = nodes.first[loop[start]] + (start - nodes.first[loop[start]] + steps) % count[start]
        is_tried = (steps < count[start]) & ((steps <= CURVES.short_span) | (is_likely[start] & is_likely[end]))
        start, steps = start[is_tried], steps[is_tried]
        if not len(start) or (length > 1 and watch.is_over()):
            break
        distance = _try(samples, nodes, loop, start, steps, tolerance[loop], spans, is_straight)
        active = np.unique(start[distance < CURVES.span_alive * tolerance[loop[start]]])
    forced = np.isinf(spans.cost[:, 0])
    spans.cost[forced, 0], spans.is_line[forced, 0] = CURVES.forced_cost, True
    return spans


def _likely_ends(nodes: Nodes) -> Mask:
    """Return the nodes [N] where long pieces may end: corners, where the bend changes, and some of the others."""
    is_likely = nodes.is_corner.copy()
    for first, stop in pairwise(nodes.first):
        direction = nodes.direction[first:stop]
        following = np.roll(direction, -1, 0)
        cross = direction[:, 0] * following[:, 1] - direction[:, 1] * following[:, 0]
        change = np.abs(cross - np.roll(cross, 1)) > CURVES.bend_change
        is_likely[first:stop] |= change | np.roll(change, 1) | np.roll(change, -1)
        is_likely[first : stop : CURVES.sparse_ends] = True
    return is_likely


def places_between(samples: Samples, nodes: Nodes, start: Integers, end: Integers, point_count: int) -> Places:
    """Return points of the outline between pairs of nodes of one loop, without those that corners have rounded off."""
    loop = np.searchsorted(nodes.first, start, side="right") - 1
    first, count = samples.first[loop], np.diff(samples.first)[loop]
    span = (nodes.sample[end] - nodes.sample[start]) % count
    span = np.where(span == 0, count, span)
    low, high = np.maximum(nodes.trim[start], 1), span - np.maximum(nodes.trim[end], 1)
    middle = (low + high) / 2.0
    low, high = np.minimum(low, middle), np.maximum(high, middle)
    share = np.linspace(0.0, 1.0, point_count)
    index = np.rint(low[:, None] + (high - low)[:, None] * share).astype(np.int64)
    points = samples.xy[first[:, None] + (nodes.sample[start][:, None] + index) % count[:, None]]
    before = np.linalg.norm(points[:, 0] - nodes.point[start], axis=1)
    after = np.linalg.norm(nodes.point[end] - points[:, -1], axis=1)
    along = (index - index[:, :1]) * samples.step[loop][:, None]
    total = before + along[:, -1] + after
    return Places(start, end, points, (before[:, None] + along) / np.maximum(total, 1e-9)[:, None])


def _try(
    samples: Samples, nodes: Nodes, loop: Integers, start: Integers, steps: Integers, tolerance: Floats,
    spans: SpanCosts, is_straight: Mask | None,
) -> Floats:  # fmt: skip
    """Enter the costs of the pieces from ``start`` that are ``steps`` nodes long, and return their distances."""
    first, count = nodes.first[loop[start]], np.diff(nodes.first)[loop[start]]
    end = first + (start - first + steps) % count
    reach = (nodes.sample[end] - nodes.sample[start]) % np.diff(samples.first)[loop[start]]
    point_count = int(np.clip(reach.max() // 4, CURVES.span_points_min, CURVES.span_points_max))
    places = places_between(samples, nodes, start, end, point_count)
    line_cost, line_distance = _line_costs(nodes, places, tolerance)
    cost, distance = line_cost.copy(), line_distance.copy()
    curved = np.nonzero(~(line_cost < CURVES.cubic_cost))[0]
    part = Places(places.start[curved], places.end[curved], places.points[curved], places.parameters[curved])
    cubic_cost, cubic_distance = _cubic_costs(nodes, part, tolerance)
    if is_straight is not None and is_straight.any():
        rows = start[curved]
        straight = straight_counts(is_straight, samples, loop[rows], nodes.sample[rows], reach[curved])
        cubic_cost[straight * samples.step[loop[rows]] > CURVES.run_bent_max] = np.inf
    cost[curved] = np.minimum(line_cost[curved], cubic_cost)
    distance[curved] = np.minimum(line_distance[curved], cubic_distance)
    spans.cost[start, steps - 1] = cost
    spans.is_line[start, steps - 1] = line_cost <= cost
    return distance


def typical_distance(largest: Floats, square: Floats) -> Floats:
    """Return the distance [B] that counts, from the largest and the mean square: noise of single points is let pass.

    A curve that bends otherwise than the outline is twice as far at worst as on average; noise is up to four times.
    """
    return np.maximum(CURVES.rms_weight * np.sqrt(square), CURVES.largest_weight * largest)


def _line_costs(nodes: Nodes, places: Places, tolerance: Floats) -> tuple[Floats, Floats]:
    start = nodes.point[places.start]
    chord = nodes.point[places.end] - start
    normal = np.stack([-chord[:, 1], chord[:, 0]], 1) / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-9)
    off = np.abs(np.einsum("bsk,bk->bs", places.points - start[:, None], normal))
    distance = typical_distance(off.max(1), (off**2).mean(1))
    cost = CURVES.line_cost + _common_cost(nodes, places, distance, chord, chord, tolerance)
    return cost, distance


def _cubic_costs(nodes: Nodes, places: Places, tolerance: Floats) -> tuple[Floats, Floats]:
    start, end = nodes.point[places.start], nodes.point[places.end]
    handles, largest, square = fit_cubics(start, end, places.points, places.parameters)
    distance = typical_distance(largest, square)
    leaving, arriving = handles[:, 0] - start, end - handles[:, 1]
    return CURVES.cubic_cost + _common_cost(nodes, places, distance, leaving, arriving, tolerance), distance


def _common_cost(
    nodes: Nodes, places: Places, distance: Floats, leaving: Floats, arriving: Floats, tolerance: Floats
) -> Floats:
    """Return the cost of distance, kinks and corners; infinite where it is too far or too bent."""
    kinks = _kink_cost(nodes, places.start, leaving) + _kink_cost(nodes, places.end, arriving)
    corners = (nodes.is_corner[places.start] * 0.5 + nodes.is_corner[places.end] * 0.5) * CURVES.corner_cost
    allowed = tolerance[places.start]
    cost = CURVES.distance_cost * (distance / allowed) ** 2 + kinks + corners
    return np.where((distance > allowed) | (kinks > CURVES.kink_max), np.inf, cost)


def _kink_cost(nodes: Nodes, node: Integers, direction: Floats) -> Floats:
    cosine = (direction * nodes.direction[node]).sum(1) / np.maximum(np.linalg.norm(direction, axis=1), 1e-9)
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return np.where(nodes.is_corner[node], 0.0, (angle / (CURVES.kink_degrees * nodes.doubt[node])) ** 2)
