"""The detail of outlines as the knob of a goal, with figures that follow from the detail in place of drawings."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import pytest
from trials import trial

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.goals import search as searching
from warpvec.goals.goal import Goal, make_goal
from warpvec.goals.search import Trial, meet
from warpvec.modes.detail import SEARCHED_DETAIL_MAX, Detail
from warpvec.watch.watch import Watch


@dataclass(frozen=True)
class Drawing:
    """A drawing of 9 paths: halving the detail gains 3 dB and costs 200 bytes, and a path takes a tenth."""

    detail: float
    removed: int = 0
    goal_facts: dict[str, Any] | None = field(default=None)

    @property
    def scene(self) -> range:
        return range(9 - self.removed)

    def trial(self) -> Trial:
        octaves = math.log2(0.1 / self.detail)
        size = round((2000 + 200 * octaves) * (1 - self.removed / 10))
        return trial(9, size, 40 + 3 * octaves - 5 * self.removed, curves=len(self.scene))

    def without(self, count: int) -> Drawing:
        return replace(self, removed=self.removed + count)


class Vanishing(Drawing):
    """A drawing of which nothing is left from a detail of 0.3 px on."""

    @property
    def scene(self) -> range:
        return range(0 if self.detail > 0.3 else 9 - self.removed)

    def trial(self) -> Trial:
        return trial(9, 90, 5.0, curves=0) if not self.scene else super().trial()


@pytest.fixture(autouse=True)
def figures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(searching, "trial_of", lambda drawing, goal: drawing.trial())


def search(tries: int = 99, kind: type[Drawing] = Drawing, **bounds: Any) -> tuple[Drawing, list[float]]:
    """Return the result of a search from 0.1 px that may make so many drawings, and the details of all."""
    details: list[float] = []

    def draw(detail: float) -> Any:
        details.append(detail)
        return kind(detail)

    class Impatient(Watch):
        def is_over(self) -> bool:
            return len(details) >= tries

    goal: Goal = make_goal(**bounds)
    request: Any = SimpleNamespace(goal=goal, watch=Impatient(), settings=FitConfig(mode="flat"))
    found: Any = meet(goal, Detail(request, draw))
    return found, details


def test_a_drawing_of_nothing_meets_no_goal() -> None:
    found, _ = search(kind=Vanishing, max_bytes=700)
    assert found.trial().curves == 2


def test_a_file_within_the_bytes_keeps_the_detail() -> None:
    found, details = search(max_bytes=2000)
    assert details == [0.1]
    assert found.goal_facts is not None and found.goal_facts["met"]


def test_bytes_are_met_by_the_finest_detail_that_fits() -> None:
    found, details = search(max_bytes=1500)
    assert 1400 < found.trial().bytes <= 1500
    assert len(details) == 6  # 0.1, 0.2, 0.4, 0.8 and twice between


def test_a_psnr_is_met_by_the_coarsest_detail_that_reaches_it() -> None:
    for target, low in ((33.0, 33.0), (44.5, 44.5)):
        found, _ = search(target_psnr=target)
        assert low <= found.trial().psnr <= target + 1.0


def test_paths_go_when_the_coarsest_detail_has_too_many_bytes() -> None:
    found, details = search(max_bytes=500)
    assert max(details) <= SEARCHED_DETAIL_MAX
    assert found.removed > 0
    assert found.trial().bytes <= 500
    with pytest.raises(InputError, match="max_bytes is too small for one path, got 50; give at least 160"):
        search(max_bytes=50)


def test_a_psnr_out_of_reach_gives_the_best_and_says_so() -> None:
    found, details = search(target_psnr=90.0)
    assert found.detail == min(details)
    assert found.goal_facts is not None and not found.goal_facts["met"]


def test_an_interrupt_ends_the_search() -> None:
    found, details = search(tries=2, max_bytes=1000)
    assert len(details) == 2
    assert found.trial().bytes <= 1000
