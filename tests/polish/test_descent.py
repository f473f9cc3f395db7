"""The iterations by gradients, on a bowl that is a thousand times as steep in one direction as in another."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.polish.descent import Descent
from warpvec.polish.variables import Evaluation

STEEP = torch.tensor([1.0, 1000.0, 30.0, 5.0])
LOWEST = torch.tensor([0.5, -0.25, 1.0, -1.0])


class _Bowl:
    """Stands for a drawing of two points. Its values also act together, which the strengths do not tell."""

    point_count = 2
    is_free = torch.tensor([True, True, True, True])

    def __init__(self) -> None:
        turn = torch.linalg.qr(torch.randn(4, 4, generator=torch.Generator().manual_seed(3)))[0]
        self._matrix = turn @ torch.diag(STEEP) @ turn.T

    def evaluate(self, x: Tensor) -> Evaluation:
        off = x - LOWEST
        return Evaluation(x, 0.5 * float(off @ self._matrix @ off), self._matrix @ off)

    def limited(self, x: Tensor) -> Tensor:
        return x

    def strength(self, x: Tensor, probes: int, generator: torch.Generator) -> Tensor:
        return self._matrix.diagonal().clone()

    def with_bounded_forms(self, step: Tensor, most: float) -> Tensor:
        return step


def _losses(steps: int, method: str) -> list[float]:
    descent = Descent(_Bowl(), torch.zeros(4), 0, 1.0)  # type: ignore[arg-type]
    return [found.loss for found in getattr(descent, method)(steps)]


def test_curvature_is_learnt_from_the_steps() -> None:
    losses = _losses(26, "by_curvature")
    assert min(losses) < 1e-6 * losses[0]
    assert len(losses) <= 26


def test_momentum_gets_far_without_it() -> None:
    losses = _losses(150, "with_momentum")
    assert len(losses) == 150
    assert losses[-1] < 1e-2 * losses[0]


def test_values_taken_back_stand_still_and_then_move_less() -> None:
    moved = []
    for is_taken in (False, True):
        descent = Descent(_Bowl(), torch.zeros(4), 0, 1.0)  # type: ignore[arg-type]
        places = []
        for step, found in enumerate(descent.with_momentum(8)):
            places.append(found.x)
            if step in (1, 4) and is_taken:
                descent.take_back(found.x, torch.tensor([True, False, False, False]))
        moved.append((places[5] - places[4]).abs())
    assert float(moved[1][0]) < 0.7 * float(moved[0][0])
