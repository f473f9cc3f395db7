"""Steps of few values against the same equations as a sparse matrix, and against those that NumPy solves."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy import sparse

from warpvec.arrays import Floats
from warpvec.polish.damped_steps import FewEquations, SparseEquations, order_by_nodes

NODES = 7
POINTS = 3 * NODES
COUNT = 2 * POINTS + 9
"""Values: of points, and some others."""


def _floor(diagonal: Floats) -> Floats:
    return np.where(np.arange(COUNT) >= 2 * POINTS, 0.02, 0.0)


@pytest.fixture
def matrices() -> tuple[FewEquations, SparseEquations, Floats, Floats]:
    """The same equations twice, in parts that overlap, with some values fixed; their matrix and slope."""
    rng = np.random.default_rng(4)
    slopes = [np.where(rng.random((80, COUNT)) < 0.15, rng.normal(size=(80, COUNT)), 0.0) for _ in range(2)]
    entries = [sparse.coo_matrix(each.T @ each) for each in slopes]
    strength, slope = np.where(np.arange(COUNT) == COUNT - 1, 3.0, 0.0), rng.normal(size=COUNT)
    free = np.flatnonzero(rng.random(COUNT) < 0.8)
    few = FewEquations(entries, strength, slope, order_by_nodes(free, POINTS), POINTS, _floor)
    many = SparseEquations(entries, strength, slope, free, POINTS, _floor, None)
    whole = sum(each.toarray() for each in entries) + np.diag(strength)
    kept = np.isin(np.arange(COUNT), free)
    return few, many, np.where(kept[:, None] & kept, whole, np.eye(COUNT)), np.where(kept, slope, 0.0)


@pytest.mark.parametrize("limit", [1e9, 0.05])
def test_few_equations_give_the_step_of_many(
    matrices: tuple[FewEquations, SparseEquations, Floats, Floats], limit: float
) -> None:
    few, many, _, _ = matrices
    extra = np.where(np.arange(POINTS) % 5 == 0, 9.0, 1.0)
    found, want = (each.limited_step(1e-2, extra, np.full(POINTS, limit)) for each in (few, many))
    torch.testing.assert_close(found, want, rtol=1e-9, atol=1e-12)
    moved = found[: 2 * POINTS].view(-1, 2).norm(dim=1)
    assert float(moved.max()) <= limit * (1.0 + 1e-9)
    assert bool((found == 0.0).any())  # the fixed values
    assert few.decrease(found) == pytest.approx(many.decrease(found), rel=1e-9)
    again = few.limited_step(1e-2, extra, np.full(POINTS, limit))
    assert torch.equal(again, found)  # the equations stay


def test_a_step_without_damping_goes_to_the_minimum(
    matrices: tuple[FewEquations, SparseEquations, Floats, Floats],
) -> None:
    few, _, matrix, slope = matrices
    step = few.limited_step(1e-13, np.ones(POINTS), np.full(POINTS, 1e9))
    want = -np.linalg.solve(matrix, slope)
    np.testing.assert_allclose(step.numpy(), want, rtol=1e-6, atol=1e-8)
    assert few.decrease(step) == pytest.approx(-0.5 * float(want @ slope), rel=1e-6)


def test_equations_of_a_thread_are_apart_and_those_without_an_answer_move_nothing(
    matrices: tuple[FewEquations, SparseEquations, Floats, Floats],
) -> None:
    few, _, _, _ = matrices
    room = np.ones(POINTS), np.full(POINTS, 1e9)
    before = few.limited_step(1e-2, *room)
    order = order_by_nodes(np.arange(COUNT), POINTS)
    nothing = [sparse.coo_matrix(np.full((COUNT, COUNT), np.nan))]
    broken = FewEquations(nothing, np.zeros(COUNT), np.ones(COUNT), order, POINTS, _floor)

    assert not broken.limited_step(1e-2, *room).any()
    assert torch.equal(few.limited_step(1e-2, *room), before)


def test_values_are_ordered_node_by_node() -> None:
    free = np.array([0, 1, 3, 6, 7, 9, 12, 20, 22])  # of two nodes: two anchors, two leaving, two arriving handles
    assert order_by_nodes(free, 6).tolist() == [0, 1, 9, 3, 6, 7, 12, 20, 22]
