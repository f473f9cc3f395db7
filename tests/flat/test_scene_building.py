"""Outlines are fitted in parts if they have very many points, and the clock is seen between and within them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warpvec.arrays import Floats
from warpvec.flat import scene_building
from warpvec.flat.chains.traced import said_loops
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.layers.outlines import Outline
from warpvec.watch.watch import UNWATCHED, Watch

OVER = Watch(time_budget=1e-9)


def gear(radius: float, center: float = 0.0) -> Floats:
    """Return a closed outline [n, 2] with a point for each pixel."""
    angle = np.linspace(0.0, 2.0 * np.pi, int(2.0 * np.pi * radius), endpoint=False)
    length = radius * (1.0 + 0.1 * np.sin(5.0 * angle))
    return center + length[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)


@pytest.fixture(autouse=True)
def few_points_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a thousand points be very many."""
    monkeypatch.setattr(scene_building, "DRAWING", replace(DRAWING, points_at_once=1000))


LOOPS = [gear(5.0 + index % 7, 30.0 * index) for index in range(40)]
OUTLINES = [Outline(loop) for loop in LOOPS]


def test_the_longest_outlines_are_fitted_before_the_time_is_over() -> None:
    found = scene_building._fitted_together(OUTLINES, 0.1, OVER)
    sizes = [[len(loop) for loop, fit in zip(LOOPS, found, strict=True) if (fit is None) == out] for out in (0, 1)]
    assert 0 < sum(sizes[0]) < 1000 and sizes[1]
    assert min(sizes[0]) >= max(sizes[1])


def test_outlines_of_many_points_are_all_fitted_if_there_is_time() -> None:
    for loop, fit in zip(LOOPS, scene_building._fitted_together(OUTLINES, 0.1, UNWATCHED), strict=True):
        assert fit is not None
        assert np.linalg.norm(fit[0][:, None, 0] - loop, axis=2).min(1).max() < 2.0  # of its own loop


def test_pieces_stay_short_once_the_time_is_over() -> None:
    loop = gear(60.0)
    ((long, _),), ((short, _),) = said_loops([loop]), said_loops([loop], watch=OVER)
    assert len(short) > len(long)
    assert np.linalg.norm(short[:, None, 0] - loop, axis=2).min(1).max() < 0.8
