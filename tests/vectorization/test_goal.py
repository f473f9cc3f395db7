"""Goals: sizes as people write them, when the search ends, and the next number of paths to try."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import pytest

from warpvec.errors import InputError
from warpvec.vectorization.goal import (
    CURVES_MAX,
    PROBE_CURVES,
    Goal,
    Trial,
    describe,
    make_facts,
    parse_size,
    with_curves,
)
from warpvec.vectorization.next_trial import (
    AUTO_CURVES_MAX,
    STEP_UP_MAX,
    best_trial,
    is_hopeless,
    is_met,
    is_worth_doubling,
    narrows_bracket,
    next_count,
    worthwhile_count,
)
from warpvec.vectorization.search import CORRECTIONS_MAX


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("50000", 50_000), ("80k", 80_000), ("80 K", 80_000), ("80kB", 80_000), ("1.5M", 1_500_000), ("2.m", 2_000_000),
        (" 7 ", 7), ("1.001M", 1_001_000), ("0.001k", 1), ("300b", 300),
    ],
)  # fmt: skip
def test_sizes_are_read_in_thousands(text: str, size: int) -> None:
    assert parse_size(text) == size


@pytest.mark.parametrize(
    "text",
    ["", "k", "0", "-5", "0.5", "1e5", "80KiB", "8_0", "80kk", "5 apples", "٣k", "nan", "inf", "9" * 400, "1\n\n2"],
)
def test_a_text_that_is_not_a_size_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match="^max_bytes must be a size such as 50000, 80k or 1.5M, got ") as caught:
        parse_size(text)
    assert "\n" not in str(caught.value)


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
        Goal(**{field: value})


def test_a_goal_without_requirements_is_false() -> None:
    assert not Goal() and not Goal(gzip=True)
    assert Goal(max_bytes=1) and Goal(target_psnr=30) and Goal(auto=True)


def test_a_given_number_of_paths_is_the_most_that_a_goal_may_use() -> None:
    goal = Goal(max_bytes=1000)
    assert with_curves({"seed": 1}, None, goal) == {"seed": 1, "minify": True, "curves": CURVES_MAX}
    assert with_curves({}, "auto", Goal(auto=True)) == {"curves": CURVES_MAX}
    assert with_curves({"minify": False}, 20, goal) == {"minify": False, "curves": 20}
    assert with_curves({}, None, Goal()) == {}
    with pytest.raises(InputError, match="curves must be a whole number or auto, got 'many'"):
        with_curves({}, "many", goal)


# the end of a search


def _trial(asked: int = 100, size: int = 10_000, psnr: float = 25.0, curves: int | None = None, **facts: Any) -> Trial:
    return Trial(asked, asked if curves is None else curves, size, psnr, **facts)


@pytest.mark.parametrize(
    ("goal", "trial", "met"),
    [
        (Goal(max_bytes=10_000), _trial(size=10_000), True),
        (Goal(max_bytes=10_000), _trial(size=10_001), False),
        (Goal(max_bytes=10_000), _trial(size=9_500), True),
        (Goal(max_bytes=10_000), _trial(size=9_499), False),
        (Goal(max_bytes=10_000), _trial(size=10_000, eligible=False), False),
        (Goal(max_bytes=10_000), _trial(512, size=100), True),  # as many paths as may be
        (Goal(max_bytes=10_000), _trial(512, size=10_001), False),
        (Goal(target_psnr=25.0), _trial(psnr=25.0), True),
        (Goal(target_psnr=25.0), _trial(psnr=24.99), False),
        (Goal(target_psnr=25.0), _trial(psnr=25.25), True),
        (Goal(target_psnr=25.0), _trial(psnr=25.26), False),
        (Goal(target_psnr=25.0), _trial(psnr=40.0, curves=1), True),  # there are no fewer
        (Goal(target_psnr=25.0), _trial(psnr=math.inf, curves=0), True),
        (Goal(target_psnr=25.0), _trial(512, psnr=20.0), True),
        (Goal(target_psnr=25.0), _trial(psnr=25.1, eligible=False), False),
        (Goal(max_bytes=10_000, target_psnr=25.0), _trial(size=5_000, psnr=25.1), True),
        (Goal(max_bytes=10_000, target_psnr=25.0), _trial(size=9_800, psnr=20.0), True),  # the bytes stop it
        (Goal(max_bytes=10_000, target_psnr=25.0), _trial(size=5_000, psnr=20.0), False),
        (Goal(max_bytes=10_000, target_psnr=25.0), _trial(size=9_800, psnr=26.0), False),
        (Goal(max_bytes=10_000, target_psnr=25.0), _trial(size=10_001, psnr=25.1), False),
    ],
)
def test_a_search_ends_when_no_other_number_of_paths_would_be_better(goal: Goal, trial: Trial, met: bool) -> None:
    assert is_met(goal, [trial], 512) is met


# the next number of paths


@pytest.mark.parametrize(
    ("goal", "trials", "count"),
    [
        (Goal(max_bytes=20_000), [_trial()], 196),
        (Goal(max_bytes=5_000), [_trial()], 49),
        (Goal(max_bytes=20_000), [_trial(curves=90)], 196),  # of those that are asked for a tenth is invisible again
        (Goal(max_bytes=20_000), [_trial(curves=0, size=1_500)], 26),  # but paths do not help where none is seen
        (Goal(max_bytes=10**9), [_trial(10)], 10 * STEP_UP_MAX),
        (Goal(max_bytes=10**9), [_trial(300)], 512),
        (Goal(max_bytes=1), [_trial()], 1),
        (Goal(max_bytes=1), [_trial(1)], 1),
        (Goal(target_psnr=24.9), [_trial(psnr=25.0, eligible=False)], 101),  # aimed at 0.1 dB above
        (Goal(target_psnr=27.2), [_trial(psnr=25.0)], 200),  # 2.3 dB a doubling
        (Goal(target_psnr=28.9), [_trial(50, psnr=23.0), _trial(psnr=25.0)], 400),  # 2 dB, as it turned out
        (Goal(target_psnr=28.9), [_trial(50, psnr=25.0), _trial(psnr=25.0)], 512),  # at least 0.8
        (Goal(target_psnr=32.9), [_trial(50, psnr=15.0), _trial(psnr=25.0)], 400),  # at most 4
        (Goal(target_psnr=27.2), [_trial(98, psnr=20.0), _trial(psnr=25.0)], 200),  # too near to tell
        (Goal(target_psnr=25.0), [_trial(psnr=25.09)], 101),
        (Goal(target_psnr=20.0), [_trial(2, psnr=20.11)], 1),
        (Goal(target_psnr=20.0), [_trial(psnr=math.inf, curves=0)], 1),
        (Goal(target_psnr=20.0), [_trial(psnr=math.inf, curves=0), _trial(1, psnr=math.inf, curves=0)], 1),
        (Goal(target_psnr=20.0), [_trial(psnr=-math.inf)], 512),
        (Goal(max_bytes=5_000, target_psnr=30.0), [_trial()], 49),
        (Goal(max_bytes=50_000, target_psnr=27.2), [_trial()], 200),
        (Goal(auto=True), [_trial(64, curves=60)], 64),
    ],
)
def test_the_next_number_of_paths_aims_at_the_bytes_and_the_psnr(goal: Goal, trials: list[Trial], count: float) -> None:
    assert next_count(goal, trials, 512) == count


def test_paths_are_doubled_while_that_pays() -> None:
    first = _trial(64, psnr=20.0)
    assert is_worth_doubling(Goal(auto=True), [first], 512)
    assert not is_worth_doubling(Goal(auto=True), [first], 127)
    assert is_worth_doubling(Goal(auto=True, max_bytes=first.bytes), [first], 512)
    assert not is_worth_doubling(Goal(auto=True, max_bytes=first.bytes - 1), [first], 512)
    paid, not_paid = _trial(128, psnr=21.0), _trial(128, psnr=20.9)
    assert is_worth_doubling(Goal(auto=True), [first, paid], 512)
    assert not is_worth_doubling(Goal(auto=True), [first, not_paid], 512)
    assert not is_worth_doubling(Goal(auto=True), [first, _trial(AUTO_CURVES_MAX, psnr=30.0)], CURVES_MAX)
    assert worthwhile_count([first]) == 64
    assert worthwhile_count([first, paid]) == 128
    assert worthwhile_count([first, not_paid]) == 64


def test_flat_art_is_not_doubled_for_gains_that_cannot_be_seen() -> None:
    emoji = [_trial(64, psnr=42.0), _trial(128, psnr=46.0)]
    assert not is_worth_doubling(Goal(auto=True), emoji[:1], 512)
    assert worthwhile_count(emoji) == 64
    unused = [_trial(64, curves=40, psnr=30.0), _trial(128, curves=60, psnr=32.0)]
    assert worthwhile_count(unused) == 64
    perfect = _trial(64, psnr=math.inf)
    assert worthwhile_count([perfect, _trial(128, psnr=math.inf)]) == 64


def test_the_facts_of_a_goal_are_one_line() -> None:
    goal = Goal(max_bytes=10_000, gzip=True, target_psnr=30)
    facts = make_facts(goal, [_trial(64, curves=60), _trial(90, psnr=29.0)], _trial(90, psnr=29.0))
    assert not facts["met"]
    assert facts["trials"][0] == {"curves": 60, "bytes": 10_000, "psnr": 25.0}
    line = "goal: 10,000 of 10,000 gzipped bytes; 30 dB not reached; fits made with 60, 90 curves"
    assert describe(facts) == line
    reached = make_facts(Goal(target_psnr=30.0), [_trial(psnr=30.1)], _trial(psnr=30.1))
    assert reached["met"] and describe(reached) == "goal: 30 dB reached; fits made with 100 curves"
    assert "as many curves as pay" in describe(make_facts(Goal(auto=True), [_trial()], _trial()))


# a model of fits: bytes linear in the paths, PSNR linear in their logarithm, both with noise


class Fitter:
    """Makes trials of a photo: a ``share`` of the paths is visible, and each doubling gains ``gain`` dB."""

    def __init__(self, seed: int, share: float, gain: float) -> None:
        self._random, self._share, self._gain = random.Random(seed), share, gain

    def trial(self, asked: int, eligible: bool = True) -> Trial:
        curves = max(1, round(self._share * asked))
        size = round(1500 + 130 * curves * (1 + self._random.gauss(0, 0.01)))
        psnr = 20.0 + self._gain * math.log2(curves / 64) + self._random.gauss(0, 0.05)
        return Trial(asked, curves, size, psnr if eligible else psnr - 0.8, eligible)


def _search(goal: Goal, fitter: Fitter, curves_max: int = CURVES_MAX) -> list[Trial]:
    """Search as `warpvec.vectorization.search.Search` does, without fits."""
    trials = [fitter.trial(min(PROBE_CURVES, curves_max), eligible=False)]
    trials.append(fitter.trial(next_count(goal, trials, curves_max)))
    outside_count = 0
    while not is_met(goal, trials, curves_max):
        count = next_count(goal, trials, curves_max)
        outside_count += not narrows_bracket(goal, trials, count)
        if outside_count > CORRECTIONS_MAX:
            break
        trials.append(fitter.trial(count))
    return trials


SHARES = (1.0, 0.97, 0.9, 0.7)


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("size", [3_000, 6_000, 20_000, 50_000, 200_000, 1_000_000])
def test_a_search_uses_the_bytes_and_stays_below(share: float, size: int) -> None:
    corrections = []
    for seed in range(100):
        trials = _search(Goal(max_bytes=size), Fitter(seed, share, 2.0))
        assert 0.95 * size <= trials[-1].bytes <= size
        corrections.append(len(trials) - 2)
    assert sum(corrections) / len(corrections) < 3.5


CURVES_TO_PSNR: dict[str, Callable[[int], float]] = {
    "photo": lambda count: 20 + 2 * math.log2(count / 64),
    "saturating": lambda count: 48 * (1 - math.exp(-count / 25)),
    "steep": lambda count: 10 + 6 * math.log2(count),
    "step": lambda count: 24.0 if count < 17 else 34 + 0.5 * math.log2(count / 17),
}


@pytest.mark.parametrize("target", [22.0, 26.0, 30.0])
@pytest.mark.parametrize("shape", CURVES_TO_PSNR)
def test_a_target_is_reached_within_a_quarter_decibel_or_four_percent_of_the_curves(shape: str, target: float) -> None:
    model, fits = CURVES_TO_PSNR[shape], []
    fewest = next(count for count in range(1, CURVES_MAX) if model(count) >= target)
    for seed in range(100):
        noise, goal = random.Random(seed), Goal(target_psnr=target)

        def trial(asked: int, loss: float = 0.0, noise: random.Random = noise) -> Trial:
            return _trial(asked, size=100 * asked, psnr=model(asked) + noise.gauss(0, 0.05) - loss, eligible=loss == 0)

        trials = [trial(PROBE_CURVES, loss=1.0)]
        trials.append(trial(next_count(goal, trials, CURVES_MAX)))
        while not is_met(goal, trials, CURVES_MAX) and not is_hopeless(goal, trials):
            trials.append(trial(next_count(goal, trials, CURVES_MAX)))
        result = trials[best_trial(goal, trials)]
        assert result.psnr >= target
        assert result.psnr <= target + 0.25 or result.asked <= 1.04 * fewest + 1
        fits.append(len(trials))
    assert max(fits) <= 2 + CORRECTIONS_MAX
    assert sum(fits) / len(fits) <= 7


def test_a_search_ends_with_the_most_paths_where_the_decibels_are_out_of_reach() -> None:
    for seed in range(20):
        goal, fitter = Goal(target_psnr=40.0), Fitter(seed, 0.9, 2.0)
        trials = _search(goal, fitter, 700)
        assert trials[-1].asked == 700
        assert not make_facts(goal, trials, trials[-1])["met"]


@pytest.mark.parametrize(("size", "target"), [(20_000, 30.0), (200_000, 25.0)])
def test_a_search_with_two_goals_ends_at_the_nearer_one(size: int, target: float) -> None:
    for seed in range(50):
        goal = Goal(max_bytes=size, target_psnr=target)
        trials = _search(goal, Fitter(seed, 0.97, 2.0))
        assert trials[-1].bytes <= size
        if size == 20_000:
            assert trials[-1].bytes >= 0.95 * size and trials[-1].psnr < target
        else:
            assert target <= trials[best_trial(goal, trials)].psnr <= target + 0.35


def test_the_result_is_the_smallest_file_that_reaches_the_target_within_the_bytes() -> None:
    goal = Goal(target_psnr=19.0, max_bytes=10_000)
    trials = [
        _trial(size=3_000, psnr=19.2, eligible=False),
        _trial(size=9_000, psnr=22.8),
        _trial(size=8_000, psnr=19.6),
        _trial(size=7_000, psnr=19.4),
        _trial(size=6_000, psnr=18.97),
        _trial(size=11_000, psnr=25.0),
    ]
    assert best_trial(goal, trials) == 3
    # No trial reaches it: the best one is kept, the smallest of equals.
    assert best_trial(Goal(target_psnr=30.0, max_bytes=10_000), trials) == 1
    assert best_trial(Goal(max_bytes=10_000), [_trial(size=9_000), _trial(size=8_000, psnr=25.001)]) == 1
    assert best_trial(goal, trials[:1]) == 0


def test_more_paths_that_gain_nothing_are_hopeless() -> None:
    goal = Goal(target_psnr=40.0)
    assert is_hopeless(goal, [_trial(64, psnr=30.0), _trial(1024, psnr=30.7)])
    assert not is_hopeless(goal, [_trial(64, psnr=30.0), _trial(1024, psnr=31.0)])
    assert not is_hopeless(goal, [_trial(1000, psnr=30.0), _trial(1200, psnr=30.0)])
    assert not is_hopeless(Goal(max_bytes=10_000), [_trial(64), _trial(1024)])
    assert not is_hopeless(goal, [_trial(64, psnr=41.0), _trial(8, psnr=20.0), _trial(16, psnr=20.0)])
