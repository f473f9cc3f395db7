"""Prices of the parts of a chain, and the cheapest way along it, in plain NumPy: sums and fits for each part alone."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]


def prices(chain: Any, rules: Any, first: int, last: int) -> tuple[float, float, float]:
    """Return the numbers that a line, an arc and a cubic along one curve cost; infinity for none."""
    at, weights = chain.middles[first:last], (chain.lengths * chain.weights)[first:last]
    found = [np.inf, np.inf, np.inf]
    if chain.curve[first] == chain.curve[last - 1]:
        found[2] = rules.word + rules.cubic_numbers - 0.5 * (2 - chain.is_corner[[first, last]].sum())
    if not weights.sum():  # a point
        return found[0], found[1], found[2]
    chord, length = chain.points[last] - chain.points[first], chain.lengths[first:last].sum()
    is_place = np.ptp(at[weights > 0.0], axis=0).max() < 1e-6
    way, square = (np.zeros(2), 0.0) if is_place else _line(at, weights)  # one place has no direction
    if np.hypot(*chord) >= (1.0 - rules.length_error) * length:
        way = way * (1.0 if way @ chord >= 0.0 else -1.0)
        saved, paid = _ends(chain, rules, first, last, (way, way))
        saved = max(saved, float(np.abs(way).min() <= rules.level_sine and not is_place))
        found[0] = square * rules.per_square + rules.word + rules.line_numbers - saved + paid
    arc = _arc(chain, rules, first, last, weights)
    if arc is not None:
        ways, square, turn = arc
        saved, paid = _ends(chain, rules, first, last, ways)
        drawn = rules.cubic_numbers * max(np.ceil(turn / (np.pi / 2.0) - 1e-3), 1.0)
        numbers = drawn if rules.is_fitted else rules.arc_numbers
        found[1] = square * rules.per_square + rules.word + numbers - saved + paid
    return found[0], found[1], found[2]


def _line(at: Real, weights: Real) -> tuple[Real, float]:
    off = at - np.average(at, axis=0, weights=weights)
    values, vectors = np.linalg.eigh((off * weights[:, None]).T @ off)
    return vectors[:, 1], max(float(values[0]), 0.0)


def _arc(chain: Any, rules: Any, first: int, last: int, weights: Real) -> tuple[tuple[Real, Real], float, float] | None:
    """Return the directions of the nearest arc at its ends, its squares and its turn: the circle of least squares."""
    at, root = chain.middles[first:last], np.sqrt(weights)
    middle = np.average(at, axis=0, weights=weights)
    off = at - middle
    terms, aims = np.column_stack([2.0 * off, np.ones(len(off))]), (off**2).sum(1)
    solution, _, rank, _ = np.linalg.lstsq(terms * root[:, None], aims * root, rcond=1e-6)
    if last - first < 3 or rank < 3:
        return None
    radius = float(np.sqrt(solution[2] + solution[:2] @ solution[:2]))
    square = float((weights * (terms @ solution - aims) ** 2).sum()) / (4.0 * radius**2)
    start, end = chain.points[first] - middle - solution[:2], chain.points[last] - middle - solution[:2]
    way = chain.along[first]
    side = float(np.sign(start[0] * way[1] - start[1] * way[0]))
    turn = float(side * (np.arctan2(*end[::-1]) - np.arctan2(*start[::-1])) % (2.0 * np.pi))
    length = chain.lengths[first:last].sum()
    is_there = turn <= rules.sweep_max and abs(radius * turn - length) <= rules.length_error * radius * turn
    if not is_there or radius * (1.0 - np.cos(turn / 2.0)) < rules.rise:
        return None
    ways = [side * np.array([-each[1], each[0]]) / np.hypot(*each) for each in (start, end)]
    return (ways[0], ways[1]), square, turn


def _ends(chain: Any, rules: Any, first: int, last: int, ways: tuple[Real, Real]) -> tuple[float, float]:
    """Return the numbers that the ends of a part save, and those that they cost."""
    reach = max(float(np.hypot(*(chain.points[last] - chain.points[first]))), 1e-6)
    allowed = min(rules.smooth_angle + 3.0 * rules.spread / reach, rules.smooth_angle_max)
    saved = paid = 0.0
    for place, way in zip((first, last), ways, strict=True):
        if not chain.is_corner[place]:
            is_smooth = np.arccos(np.clip(way @ chain.along[place], -1.0, 1.0)) <= allowed
            saved, paid = (saved + 0.5, paid) if is_smooth else (saved, paid + rules.kink)
    return saved, paid


def least_cost(chain: Any, rules: Any, pairs: list[tuple[int, int]], costs: Real) -> float:
    """Return what the cheapest way costs, from ``costs`` [3, B] of parts between ``pairs``, over all ways to each."""
    count = len(chain.points)
    by_line, bent = np.full((2, count), np.inf)
    bent[0] = 0.0
    for (first, last), (line, *others) in sorted(zip(pairs, costs.T, strict=True), key=lambda each: each[0]):
        kink = 0.0 if chain.is_corner[first] else rules.line_kink
        by_line[last] = min(by_line[last], line + min(by_line[first] + kink, bent[first]))
        bent[last] = min(bent[last], min(others) + min(by_line[first], bent[first]))
    return float(min(by_line[-1], bent[-1]))


def cost_of(chain: Any, rules: Any, parts: list[Any], costs: dict[tuple[int, int], Real]) -> float:
    """Return what ``parts`` cost together, of which the costs [3] between two points are given."""
    total = sum(float(costs[part.first, part.last][part.kind]) for part in parts)
    return total + sum(
        rules.line_kink
        for before, after in pairwise(parts)
        if before.kind == after.kind == 0 and not chain.is_corner[after.first]
    )
