"""The equations of a damped Gauss-Newton step, with a limit for each point: few of them as a whole matrix, in a kernel.

Many are a sparse matrix, whose factors SuperLU finds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
import torch
import warp as wp
from numpy.typing import NDArray
from scipy import sparse
from torch import Tensor

from warpvec.arrays import Floats
from warpvec.polish.machine import machine_of_thread, on_host

DAMPING_MIN = 1e-8
"""Least damping, as a share of the matrix's diagonal."""

LIMIT_ROUNDS = 4
"""Times that the damping of points that move too far is raised before their moves are cut."""

EXCESS_MAX = 1.1
"""Moves of at most this many times the limit are cut at once."""

EXCESS_DAMPING = 2.0
"""Factor of the damping of a point that moves as far as it may."""

POINT_FLOOR = 1.0
"""Share of the mean diagonal of all points that is added to that of each: points that the picture hardly holds would
else run far with every step. With 0.1 or 10 the mean PSNR of four tracings is 0.4 dB lower."""

FEW_MAX = 400
"""Most equations that are a whole matrix. With more SuperLU is faster."""


class Equations(Protocol):
    """The equations of one step, in the values that are free."""

    def limited_step(self, damping: float, extra: Floats, limit: Floats) -> Tensor:
        """Return the step [K] in float64 with more damping of the points that would move too far.

        Args:
            damping: of all values, as a share of the diagonal.
            extra: factor of the damping of each point [P].
            limit: how far each point may move [P], in pixels.
        """

    def decrease(self, step: Tensor) -> float:
        """Return by how much the loss should fall with ``step`` [K]."""


class FewEquations:
    """Equations as a whole matrix.

    Args:
        entries: matrices [K, K], of which the sum is the Gauss-Newton matrix.
        strength: what is added to its diagonal [K].
        slope: derivative of the loss by the values [K].
        order: the free values, in the order in which they are eliminated [F]; see `order_of_nodes`.
        point_count: P, the points are the first values, two each.
        floor_of: returns what damping must add to a diagonal [K].
    """

    def __init__(
        self,
        entries: Sequence[sparse.coo_matrix],
        strength: Floats,
        slope: Floats,
        order: NDArray[np.int32],
        point_count: int,
        floor_of: Callable[[Floats], Floats],
    ) -> None:
        self._machine, self._size, self._count = machine_of_thread(), len(order), len(strength)
        self._order, self._point_count = on_host(order), point_count
        size, get = self._size, self._machine.get
        place = np.full(self._count, -1, np.int32)
        place[order] = np.arange(size, dtype=np.int32)
        rows = np.zeros(size * size)
        self._rows, self._work = on_host(rows), get("factors", size * size, wp.float64)
        own = np.zeros(self._count)
        for each in entries:
            parts = [on_host(_or_one(part)) for part in (each.row, each.col, each.data)]
            into = [on_host(place), size, self._rows, on_host(own)]
            self._machine.run("add_entries", [each.nnz, *parts, *into])
        rows[:: size + 1] += strength[order]
        self._scale = on_host(_scale(own, strength, point_count, floor_of)[order])
        self._slope = on_host(slope[order])

    def limited_step(self, damping: float, extra: Floats, limit: Floats) -> Tensor:
        """See `Equations.limited_step`."""
        step, found = np.zeros(self._count), np.zeros(self._size)
        known = [self._size, self._order, self._rows, self._scale, self._slope, damping]
        bounds = [self._point_count, on_host(limit), LIMIT_ROUNDS, EXCESS_MAX, EXCESS_DAMPING, on_host(extra.copy())]
        self._machine.run("take_limited_step", [*known, *bounds, self._work, on_host(found), on_host(step)])
        # Equations without an answer move nothing.
        return torch.from_numpy(step if np.isfinite(step).all() else np.zeros_like(step))

    def decrease(self, step: Tensor) -> float:
        """See `Equations.decrease`."""
        found, moved = np.zeros(1), on_host(step.double().cpu().numpy())
        self._machine.run("expect_decrease", [self._size, self._order, self._rows, self._slope, moved, on_host(found)])
        return float(found[0])


class SparseEquations:
    """Equations as a sparse matrix; see `FewEquations`.

    Attributes:
        order: the order in which the free values are eliminated, which keeps the factors sparse [F]. Another step may
            begin with it.
    """

    def __init__(
        self,
        entries: Sequence[sparse.coo_matrix],
        strength: Floats,
        slope: Floats,
        free: NDArray[np.int64],
        point_count: int,
        floor_of: Callable[[Floats], Floats],
        order: NDArray[np.int64] | None,
    ) -> None:
        self._free, self._count, self._point_count = free, len(strength), point_count
        matrix = sum_of(entries)
        whole = matrix + sparse.diags(strength, format="csc") if strength.any() else matrix
        self._matrix = whole[free][:, free].tocsc()
        self._diagonal = _scale(matrix.diagonal(), strength, point_count, floor_of)[free]
        self._slope = slope[free]
        least = self._matrix + sparse.diags(DAMPING_MIN * self._diagonal, format="csc")  # with a whole diagonal
        self.order = _order_of(least) if order is None else order
        self._least = least[self.order][:, self.order].tocsc()
        self._least.sort_indices()
        columns = np.repeat(np.arange(len(free)), np.diff(self._least.indptr))
        self._places = np.flatnonzero(self._least.indices == columns)

    def limited_step(self, damping: float, extra: Floats, limit: Floats) -> Tensor:
        """See `Equations.limited_step`."""
        bound = 2 * self._point_count
        for _ in range(LIMIT_ROUNDS):
            factors = np.ones(self._count)
            factors[:bound] = extra.repeat(2)
            step = self._step(damping * factors)
            excess = np.hypot(*step[:bound].reshape(-1, 2).T) / limit
            if excess.max() < EXCESS_MAX:
                break
            extra = np.where(excess > 1.0, extra * EXCESS_DAMPING * excess**1.5, extra)
        step[:bound] /= np.maximum(excess, 1.0).repeat(2)
        return torch.from_numpy(step)

    def _step(self, damping: Floats) -> Floats:
        """Return the step [K] with so much ``damping`` [K] of each value, at least ``DAMPING_MIN``."""
        from scipy.sparse.linalg import splu

        damped, rows = self._least.copy(), self._free[self.order]
        damped.data[self._places] += (damping[rows] - DAMPING_MIN) * self._diagonal[self.order]
        step = np.zeros(self._count)
        step[rows] = -splu(damped, permc_spec="NATURAL", **_SYMMETRIC).solve(self._slope[self.order])
        return step

    def decrease(self, step: Tensor) -> float:
        """See `Equations.decrease`."""
        move = step.double().cpu().numpy()[self._free]
        # Sums, because a dot product of BLAS has other bits with other numbers of threads.
        return float(-(move * self._slope).sum() - 0.5 * (move * (self._matrix @ move)).sum())


def order_by_nodes(free: NDArray[np.int64], point_count: int) -> NDArray[np.int32]:
    """Return the values ``free`` [F] node by node, of P points that are all anchors, then all handles, and last others.

    Nodes act with those beside them, so the factors of a matrix in this order are mostly zero.
    """
    count = max(point_count // 3, 1)
    point, axis = np.divmod(free, 2)
    part, node = np.divmod(point, count)
    key = np.where(free < 2 * point_count, 6 * node + 2 * part + axis, free)
    found: NDArray[np.int32] = free[np.argsort(key, kind="stable")].astype(np.int32)
    return found


def sum_of(entries: Sequence[sparse.coo_matrix]) -> sparse.csc_matrix:
    """Return the sum of matrices."""
    found = entries[0].tocsc()
    for each in entries[1:]:
        found += each.tocsc()
    return found


def _scale(own: Floats, strength: Floats, point_count: int, floor_of: Callable[[Floats], Floats]) -> Floats:
    """Return the diagonal [K] that damping multiplies, of a matrix with the diagonal ``own``."""
    diagonal, points = own + strength, 2 * point_count
    diagonal[:points] += POINT_FLOOR * diagonal[:points].mean()
    found: Floats = np.maximum(diagonal + floor_of(own), 1e-12)
    return found


def _or_one(values: NDArray[Any]) -> NDArray[Any]:
    """Return ``values`` without gaps in memory, at least one."""
    return np.ascontiguousarray(values) if len(values) else np.zeros(1, values.dtype)


_SYMMETRIC: dict[str, Any] = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
"""Arguments with which SuperLU takes its pivots from the diagonal of a symmetric matrix."""


def _order_of(matrix: sparse.csc_matrix) -> NDArray[np.int64]:
    """Return an order of the values of a symmetric matrix whose factors are sparse.

    It takes half of the time of a solution. What few steps change in a matrix hardly changes it.
    """
    from scipy.sparse.linalg import splu

    found: NDArray[np.int64] = np.argsort(splu(matrix, permc_spec="MMD_AT_PLUS_A", **_SYMMETRIC).perm_c)
    return found
