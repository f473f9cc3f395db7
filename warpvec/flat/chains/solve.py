"""Solve the numbers of chains of parts: as near to the chains as their smooth joints and relations allow.

All numbers of a drawing are one vector: both coordinates of each node, then the bulge of each arc and the handles of
each cubic. Coordinates that are equal are one free number. What is not linear, such as smooth joints and equal radii,
is held by weights.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph, linalg

from warpvec.arrays import Floats, Integers, dot
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.parts import ARC, SAMPLES, SIZES, drawn, radius_of
from warpvec.flat.chains.track import Track

ROUNDS = 5
"""Most Gauss-Newton steps. The last ones move nodes by less than ``MOVED``."""

MOVED = 1e-3
"""Largest change of a number in a step, in pixels, that ends a solution: files have two decimals."""

HELD = 3e3
"""Weight of what is held, over that of a pixel of distance: what is left of it is below the last decimal of files."""

HOLD_REACH = 20.0
"""Length in pixels whose end a smooth joint holds: a turn of a hundredth of a degree moves it by 0.003 px."""

END = 3.0
"""Weight of the ends of open chains: a cap is as wide as some pixels of outline."""

STAY = 0.02
"""Weight by which a number stays where it is: what nothing else holds, such as nodes along a line."""

DAMPING = 0.2
"""Weight by which a number stays where it is in a step. Nodes that slide along an arc by pixels leave their smooth
joints: with 0.02, two halves of a circle turn back and forth by a degree."""

STEP = 1e-5
"""Change of a number in pixels by which derivatives are measured."""

COLUMNS = 256
"""Values whose deviations are found at once: they take a column each."""

MOVE_MAX = 3.0
"""Largest change of a number in a step, in pixels."""


@dataclass(eq=False)
class Sketch:
    """Chains of parts with their numbers.

    Attributes:
        kind: of each part [P].
        columns: where the numbers of each part are in the vector: P arrays.
        numbers: the vector [M].
        chain: the chain of each part [P].
        first, last: the points of its chain between which each part is [P].
        smooth: pairs of parts that go on in one direction [J, 2].
        ranges: the first part of each chain, and the one after its last.
        chains: the chains.
        radii: groups of arcs of one radius.
        equal: pairs of numbers that are one.
        diagonal: lines that rise by 45 degrees.
        square: parts whose start (0) or end (1) has no direction along a coordinate but this one.
        axes: the number that is the place of the axis of a chain.
        folded: the coordinate that it mirrors.
        at_axis: starts (0) and ends (1) of chains that lie at their axis.
        fixed: numbers that stay.
        joined: starts (0) and ends (1) of open chains that meet another chain, by the number of the chain.
        lying: places, by their columns [2], that lie on a line.
        given: arcs with the radius that each has.
    """

    kind: Integers
    columns: list[Integers]
    numbers: Floats
    chain: Integers
    first: Integers
    last: Integers
    smooth: Integers
    ranges: list[tuple[int, int]]
    chains: list[Chain]
    radii: list[Integers] = field(default_factory=list)
    equal: list[list[int]] = field(default_factory=list)
    diagonal: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    square: list[tuple[int, int, int]] = field(default_factory=list)
    axes: dict[int, int] = field(default_factory=dict)
    folded: dict[int, int] = field(default_factory=dict)
    at_axis: list[tuple[int, int]] = field(default_factory=list)
    fixed: list[int] = field(default_factory=list)
    joined: set[tuple[int, int]] = field(default_factory=set)
    lying: list[tuple[Integers, int]] = field(default_factory=list)
    given: list[tuple[int, float]] = field(default_factory=list)

    def of(self, part: int) -> Floats:
        """Return the numbers of a part."""
        return self.numbers[self.columns[part]]

    @cached_property
    def track(self) -> Track:
        """Its chains one after the other, with its parts."""
        return Track.of(self.chains, self.chain, self.first, self.last)

    @cached_property
    def freed(self) -> list[int]:
        """The parts that have numbers of their own."""
        parts = zip(self.chain.tolist(), self.first.tolist(), self.last.tolist(), strict=True)
        return [k for k, (own, first, last) in enumerate(parts) if self.chains[own].is_freed(first, last)]

    def rows_of_kind(self, kind: int) -> Integers:
        """Return the parts of a kind."""
        return np.flatnonzero(self.kind == kind)


def solved(sketch: Sketch, rounds: int = ROUNDS) -> None:
    """Move the numbers of ``sketch`` as near to its chains as what is held allows."""
    basis, held = _basis(sketch), sketch.fixed
    free = (basis.T @ sketch.numbers) / np.asarray(basis.sum(0)).ravel()
    free[basis[held].indices] = sketch.numbers[held]
    moves = _moves(sketch, basis)
    sketch.numbers = basis @ free
    stay = DAMPING**2 * sparse.eye(moves.shape[1], format="csr")
    for _ in range(rounds if moves.shape[1] else 0):
        residual, slopes = _equations(sketch)
        slopes = slopes @ moves
        matrix = (slopes.T @ slopes + stay).tocsc()
        step = -np.asarray(linalg.spsolve(matrix, slopes.T @ residual))
        most = float(np.abs(step).max(initial=0.0))
        sketch.numbers = sketch.numbers + moves @ step * min(1.0, MOVE_MAX / max(most, 1e-12))
        if most < MOVED:
            break


def deviations(sketch: Sketch, slopes: sparse.csr_matrix) -> Floats:
    """Return the standard deviations of values [K] that follow the numbers of a solved ``sketch`` by ``slopes`` [K, M].

    The unit is the deviation of the place of one pixel of outline. Where a line becomes an arc smoothly, for example, a
    node may move along both and hardly shows. What fixed numbers say has 0.
    """
    moves = _moves(sketch, _basis(sketch))
    found = np.zeros(slopes.shape[0])
    if not moves.shape[1]:
        return found
    own = _equations(sketch)[1] @ moves
    solve = linalg.splu((own.T @ own + STAY**2 * sparse.eye(moves.shape[1])).tocsc()).solve
    follow = (slopes @ moves).tocsr()
    for start in range(0, len(found), COLUMNS):
        part = follow[start : start + COLUMNS].toarray().T
        found[start : start + COLUMNS] = np.sqrt((part * solve(part)).sum(0))
    return found


def _moves(sketch: Sketch, basis: sparse.csr_matrix) -> sparse.csr_matrix:
    """Return the columns of a ``basis`` [M, F] whose free numbers no fixed one holds."""
    return basis[:, np.setdiff1d(np.arange(basis.shape[1]), basis[sketch.fixed].indices)]


def _basis(sketch: Sketch) -> sparse.csr_matrix:
    """Return how the numbers [M] follow from free ones [F]: those that are equal share one."""
    count, ones = len(sketch.numbers), np.ones(len(sketch.equal))
    pairs = np.array(sketch.equal, np.int64).reshape(-1, 2).T
    graph = sparse.coo_matrix((ones, (pairs[0], pairs[1])), shape=(count, count))
    free, column = csgraph.connected_components(graph, directed=False)
    return sparse.csr_matrix((np.ones(count), (np.arange(count), column)), shape=(count, free))


class _Triplets:
    """Rows of a sparse matrix and their residuals."""

    def __init__(self) -> None:
        self.count, self._parts, self._residual = 0, list[tuple[Floats, Integers, Integers]](), list[Floats]()

    def add(self, residual: Floats, values: Floats, columns: Integers) -> None:
        """Add rows [R] with ``values`` [R, K] at ``columns`` [R, K]."""
        rows = np.arange(len(residual)) + self.count
        self._parts.append((values.ravel(), np.repeat(rows, values.shape[1]), columns.ravel()))
        self._residual.append(residual)
        self.count += len(residual)

    def matrix(self, width: int) -> tuple[Floats, sparse.csr_matrix]:
        """Return the residuals [R] and the matrix [R, width]."""
        values, rows, columns = (np.concatenate(each) for each in zip(*self._parts, strict=True))
        found = sparse.coo_matrix((values, (rows, columns)), shape=(self.count, width)).tocsr()
        return np.concatenate(self._residual), found


_Ways = dict[int, tuple[Floats, Floats, Integers]]
"""By parts: the directions at both ends [2, 2], how they follow the numbers of the part [K, 2, 2], and its columns."""


def _equations(sketch: Sketch) -> tuple[Floats, sparse.csr_matrix]:
    found = _Triplets()
    ways: _Ways = {}
    for kind, size in SIZES.items():
        parts = sketch.rows_of_kind(kind)
        if not len(parts):
            continue
        columns = np.stack([sketch.columns[part] for part in parts])
        points, ends, moves, turns = _derivatives(kind, sketch.numbers[columns], size)
        for row, part in enumerate(parts.tolist()):
            ways[part] = ends[row], turns[:, row], columns[row]
        residual, normal, weight = sketch.track.distances(parts, points)
        slopes = np.moveaxis(dot(moves, normal), 0, 2) * weight[..., None]
        found.add((residual * weight).ravel(), slopes.reshape(-1, size), np.repeat(columns, SAMPLES, 0))
    _hold_ends(sketch, found)
    _hold_joints(sketch, ways, found)
    _hold_square(sketch, ways, found)
    _hold_radii(sketch, found)
    _hold_diagonals(sketch, found)
    _hold_lying(sketch, found)
    _hold_given(sketch, found)
    return found.matrix(len(sketch.numbers))


def _derivatives(kind: int, numbers: Floats, size: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Return what parts of one ``kind`` with ``numbers`` [B, K] draw, and how that follows each of their K numbers.

    Returns:
        points [B, SAMPLES, 2], directions at both ends [B, 2, 2], and both derivatives [K, B, ...].
    """
    count, own = len(numbers), np.arange(size)
    moved = np.repeat(numbers[None], 2 * size + 1, 0)
    moved[own, :, own] += STEP
    moved[own + size, :, own] -= STEP
    points, ends = (each.reshape(2 * size + 1, count, -1, 2) for each in drawn(kind, moved.reshape(-1, size)))
    moves, turns = ((each[:size] - each[size:-1]) / (2.0 * STEP) for each in (points, ends))
    return points[-1], ends[-1], moves, turns


def _hold_ends(sketch: Sketch, found: _Triplets) -> None:
    """Hold both ends of open chains that meet nothing: nothing else does along the chain."""
    for number, (begin, end) in enumerate(sketch.ranges):
        chain = sketch.chains[number]
        for side, part in ((0, begin), (1, end - 1)):
            if not chain.is_closed and (number, side) not in sketch.joined | set(sketch.at_axis):
                columns = sketch.columns[part][2 * side : 2 * side + 2]
                off = sketch.numbers[columns] - chain.points[-side]
                found.add(END * off, np.full((2, 1), END), columns[:, None])


def _hold_joints(sketch: Sketch, ways: _Ways, found: _Triplets) -> None:
    for before, after in sketch.smooth.tolist():
        (first, first_turns, first_columns), (second, second_turns, second_columns) = ways[before], ways[after]
        u, v = first[1], second[0]
        slopes = [
            first_turns[:, 1, 0] * v[1] - first_turns[:, 1, 1] * v[0],
            u[0] * second_turns[:, 0, 1] - u[1] * second_turns[:, 0, 0],
        ]
        weight = HELD * HOLD_REACH
        found.add(
            np.array([weight * (u[0] * v[1] - u[1] * v[0])]),
            weight * np.concatenate(slopes)[None],
            np.concatenate([first_columns, second_columns])[None],
        )


def _hold_square(sketch: Sketch, ways: _Ways, found: _Triplets) -> None:
    weight = HELD * HOLD_REACH
    for part, side, axis in sketch.square:
        directions, turns, columns = ways[part]
        off = directions[side, 1 - axis]
        found.add(np.array([weight * off]), weight * turns[None, :, side, 1 - axis], columns[None])


def _hold_radii(sketch: Sketch, found: _Triplets) -> None:
    for group in sketch.radii:
        pairs = [(group[0], other) for other in group[1:]]
        for pair in pairs:
            values, radii = list[Floats](), list[float]()
            for part, side in zip(pair, (1.0, -1.0), strict=True):
                radius, slopes = radius_slopes(sketch, int(part))
                radii.append(side * radius)
                values.append(side * slopes)
            columns = [sketch.columns[part] for part in pair]
            found.add(np.array([HELD * sum(radii)]), HELD * np.concatenate(values)[None],
                      np.concatenate(columns)[None])  # fmt: skip


def radius_slopes(sketch: Sketch, part: int) -> tuple[float, Floats]:
    """Return the radius of an arc, above 0, and how it follows its numbers [5]."""
    numbers = sketch.of(part)[None]
    sign, steps = np.sign(numbers[0, 4]), np.eye(SIZES[ARC]) * STEP
    slopes = (radius_of(numbers + steps) - radius_of(numbers - steps)) / (2.0 * STEP)
    return float(sign * radius_of(numbers)[0]), sign * slopes


def _hold_given(sketch: Sketch, found: _Triplets) -> None:
    for part, given in sketch.given:
        radius, slopes = radius_slopes(sketch, part)
        found.add(np.array([HELD * (radius - given)]), HELD * slopes[None], sketch.columns[part][None])


def _hold_lying(sketch: Sketch, found: _Triplets) -> None:
    for columns, part in sketch.lying:
        place, (start, end) = sketch.numbers[columns], sketch.of(part).reshape(2, 2)
        length = max(float(np.linalg.norm(end - start)), 1e-9)
        normal = np.array([start[1] - end[1], end[0] - start[0]]) / length
        share = float((place - start) @ (end - start)) / length**2
        # Turning the line moves it at the place by the shares of its ends.
        slopes = np.concatenate([normal, -(1.0 - share) * normal, -share * normal])
        own = np.concatenate([columns, sketch.columns[part]])
        found.add(np.array([HELD * float((place - start) @ normal)]), HELD * slopes[None], own[None])


def _hold_diagonals(sketch: Sketch, found: _Triplets) -> None:
    for part in sketch.diagonal:
        numbers = sketch.of(part)
        x, y = np.sign(numbers[2:] - numbers[:2]) * HELD
        off = abs(numbers[2] - numbers[0]) - abs(numbers[3] - numbers[1])
        found.add(np.array([HELD * off]), np.array([[-x, y, x, -y]]), sketch.columns[part][None])
