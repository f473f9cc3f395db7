"""The goal of a smallest structural similarity."""

from __future__ import annotations

import math

import pytest
from short_fits import small_photo

import warpvec
from warpvec.errors import InputError
from warpvec.goals import file_ssim
from warpvec.goals.goal import describe, make_goal

QUICK = {"mode": "photo", "iterations": 60, "threads": 1}


def test_a_file_reaches_the_similarity_with_few_paths() -> None:
    photo = small_photo()
    rough, close = (warpvec.vectorize(photo, target_ssim=target, **QUICK) for target in (0.5, 0.75))
    for result, target in ((rough, 0.5), (close, 0.75)):
        facts = result.goal_facts
        assert facts is not None and facts["met"] and facts["target_ssim"] == target
        assert result.metrics["ssim"] >= target
        assert facts["trials"][-1]["ssim"] == pytest.approx(result.metrics["ssim"], abs=1e-6)
        assert describe(facts) == f"goal: SSIM {target:g} reached"
    assert len(rough.scene) < len(close.scene)


def test_the_scale_of_the_search_rises_with_the_similarity() -> None:
    decibels = file_ssim.QUANTITY.decibels
    assert [decibels(figure) for figure in (0.0, 0.9, 0.99)] == pytest.approx([0.0, 10.0, 20.0])
    assert decibels(1.0) == math.inf


@pytest.mark.parametrize("bound", [0, 1, -0.5, math.nan, "high", True])
def test_other_bounds_are_refused(bound: object) -> None:
    with pytest.raises(InputError, match="^target_ssim must "):
        make_goal(target_ssim=bound)
