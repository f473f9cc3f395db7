"""Goals: refused ones, their effect on the settings, and the facts of a search."""

from __future__ import annotations

import math
from typing import Any

import pytest
from trials import trial

from warpvec.errors import InputError
from warpvec.goals.goal import SEARCHED_CURVES_MAX, describe, make_goal, settings_and_goal, with_curves
from warpvec.goals.search import make_facts


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("max_bytes", 0), ("max_bytes", 1.5), ("max_bytes", True), ("max_bytes", "80k"), ("target_psnr", 0.0),
        ("max_bytes", 10**400), ("target_psnr", 10**400),
        ("target_psnr", 100.5), ("target_psnr", math.nan), ("target_psnr", "30"), ("target_psnr", True), ("gzip", 1),
    ],
)  # fmt: skip
def test_a_goal_says_which_value_is_wrong(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"^{field} must "):
        make_goal(**{field: value})


def test_a_goal_without_requirements_is_false() -> None:
    assert not make_goal() and not make_goal(gzip=True)
    assert make_goal(max_bytes=1) and make_goal(target_psnr=30) and make_goal(auto=True)


def test_a_given_number_of_paths_is_the_most_that_a_goal_may_use() -> None:
    goal = make_goal(max_bytes=1000)
    assert with_curves({"seed": 1}, None, goal) == {"seed": 1, "minify": True, "curves": SEARCHED_CURVES_MAX}
    assert with_curves({}, "auto", make_goal(auto=True)) == {"curves": SEARCHED_CURVES_MAX}
    assert with_curves({"minify": False}, 20, goal) == {"minify": False, "curves": 20}
    assert with_curves({}, None, make_goal()) == {}
    with pytest.raises(InputError, match="curves must be a whole number or auto, got 'many'"):
        with_curves({}, "many", goal)


def test_two_qualities_are_refused() -> None:
    with pytest.raises(InputError, match="^target_ssim must not be given with target_psnr; leave one of them out"):
        make_goal(target_psnr=30, target_ssim=0.8)


def test_segments_that_are_given_are_kept_in_a_file_of_some_bytes() -> None:
    for options, kept in (({}, False), ({"segments": 5}, True)):
        config, goal = settings_and_goal("default", {"max_bytes": 1000, **options})
        assert goal.keeps_segments is kept and config.minify


def test_the_facts_of_a_goal_are_one_line() -> None:
    goal = make_goal(max_bytes=10_000, gzip=True, target_psnr=30)
    facts = make_facts(goal, [trial(64, curves=60), trial(90, psnr=29.0)], trial(90, psnr=29.0))
    assert not facts["met"]
    assert facts["trials"][0] == {"curves": 60, "bytes": 10_000, "psnr": 25.0}
    line = "goal: 10,000 of 10,000 gzipped bytes; 30 dB not reached"
    assert describe(facts) == line
    assert describe({**facts, "curves_max": 90}).endswith(
        "; all 90 paths of --curves are used, and more would come closer"
    )
    reached = make_facts(make_goal(target_psnr=30.0), [trial(psnr=30.1)], trial(psnr=30.1))
    assert reached["met"] and describe(reached) == "goal: 30 dB reached"
    assert "as many paths as pay" in describe(make_facts(make_goal(auto=True), [trial()], trial()))
