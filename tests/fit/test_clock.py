"""The clock of a fit: how many steps may be launched before the host looks."""

from __future__ import annotations

from typing import Any, cast

import pytest

from warpvec.fit.clock import LOOK_SECONDS, Clock
from warpvec.rendering.streams import STEPS_AHEAD


class Part:
    """A part of a run whose time is set."""

    time_budget = None
    now = 0.0

    def seconds(self) -> float:
        return self.now


@pytest.mark.parametrize("pace", [1e-5, 0.004, 0.3])
def test_slow_steps_are_launched_a_few_at_a_time(pace: float) -> None:
    part = Part()
    clock = Clock(1000, cast(Any, part), "cpu")
    assert clock.steps_to_look(64) == 64  # nothing is known yet
    part.now = 20.0  # the first step compiles
    clock.planned_iterations(1)
    iteration = 1
    while part.now < 22.0:
        count = clock.steps_to_look(64)
        part.now += pace * count
        iteration += count
        clock.planned_iterations(iteration)
    count = clock.steps_to_look(64)
    assert count in (1, 64) or (STEPS_AHEAD + 1) * count * pace <= LOOK_SECONDS < (STEPS_AHEAD + 1) * (count + 1) * pace
    assert (count == 1) == (pace > 0.1) and (count == 64) == (pace < 1e-4)
    assert clock.steps_to_look(0) == 0
