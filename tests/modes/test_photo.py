"""The mode photo: what its drawing leaves out when the time budget is used up."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import warpvec
from warpvec.drawing.drawing import Drawing


@pytest.mark.parametrize(("time_budget", "is_late"), [(1e-3, True), (1e4, False), (None, False)])
def test_fewer_hidden_paths_are_looked_at_once_the_time_is_over(
    time_budget: float | None, is_late: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[bool] = []
    make = Drawing.of

    def of(*args: Any, **more: Any) -> Drawing:
        asked.append(more.get("is_late", False))
        return make(*args, **more)

    monkeypatch.setattr(Drawing, "of", staticmethod(of))
    photo = np.random.default_rng(0).integers(0, 256, (16, 24, 3), dtype=np.uint8)
    warpvec.vectorize(photo, 4, mode="photo", iterations=2, time_budget=time_budget, threads=1)
    assert asked[0] is is_late
