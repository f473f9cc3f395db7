"""When the search of a photo ends, and the next number of paths to try."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import pytest
from trials import trial

from warpvec.goals.goal import SEARCHED_CURVES_MAX, Goal, make_goal
from warpvec.goals.search import Trial, best_trial, make_facts
from warpvec.modes.next_count import (
    AUTO_CURVES_MAX,
    STEP_UP_MAX,
    is_hopeless,
    is_met,
    is_worth_doubling,
    narrows_bracket,
    next_count,
    worthwhile_count,
)
from warpvec.modes.path_count import CORRECTIONS_MAX, PROBE_CURVES

# the end of a search


@pytest.mark.parametrize(
    ("goal", "last", "met"),
    [
        (make_goal(max_bytes=10_000), trial(size=10_000), True),
        (make_goal(max_bytes=10_000), trial(size=10_001), False),
        (make_goal(max_bytes=10_000), trial(size=9_500), True),
        (make_goal(max_bytes=10_000), trial(size=9_499), False),
        (make_goal(max_bytes=10_000), trial(size=10_000, eligible=False), False),
        (make_goal(max_bytes=10_000), trial(512, size=100), True),  # as many paths as may be
        (make_goal(max_bytes=10_000), trial(512, size=10_001), False),
        (make_goal(target_psnr=25.0), trial(psnr=25.0), True),
        (make_goal(target_psnr=25.0), trial(psnr=24.99), False),
        (make_goal(target_psnr=25.0), trial(psnr=25.25), True),
        (make_goal(target_psnr=25.0), trial(psnr=25.26), False),
        (make_goal(target_psnr=25.0), trial(psnr=40.0, curves=1), True),  # there are no fewer
        (make_goal(target_psnr=25.0), trial(psnr=math.inf, curves=0), True),
        (make_goal(target_psnr=25.0), trial(512, psnr=20.0), True),
        (make_goal(target_psnr=25.0), trial(psnr=25.1, eligible=False), False),
        (make_goal(max_bytes=10_000, target_psnr=25.0), trial(size=5_000, psnr=25.1), True),
        (make_goal(max_bytes=10_000, target_psnr=25.0), trial(size=9_800, psnr=20.0), True),  # the bytes stop it
        (make_goal(max_bytes=10_000, target_psnr=25.0), trial(size=5_000, psnr=20.0), False),
        (make_goal(max_bytes=10_000, target_psnr=25.0), trial(size=9_800, psnr=26.0), False),
        (make_goal(max_bytes=10_000, target_psnr=25.0), trial(size=10_001, psnr=25.1), False),
    ],
)
def test_a_search_ends_when_no_other_number_of_paths_would_be_better(goal: Goal, last: Trial, met: bool) -> None:
    assert is_met(goal, [last], 512) is met


# the next number of paths


@pytest.mark.parametrize(
    ("goal", "trials", "count"),
    [
        (make_goal(max_bytes=20_000), [trial()], 196),
        (make_goal(max_bytes=5_000), [trial()], 49),
        (
            make_goal(max_bytes=20_000),
            [trial(curves=90)],
            196,
        ),  # a tenth of those asked for is invisible again
        (make_goal(max_bytes=20_000), [trial(curves=0, size=1_500)], 26),  # but paths do not help where none is seen
        (make_goal(max_bytes=10**9), [trial(10)], 10 * STEP_UP_MAX),
        (make_goal(max_bytes=10**9), [trial(300)], 512),
        (make_goal(max_bytes=1), [trial()], 1),
        (make_goal(max_bytes=1), [trial(1)], 1),
        (make_goal(target_psnr=24.9), [trial(psnr=25.0, eligible=False)], 101),  # aimed at 0.1 dB above
        (make_goal(target_psnr=27.2), [trial(psnr=25.0)], 200),  # 2.3 dB a doubling
        (make_goal(target_psnr=28.9), [trial(50, psnr=23.0), trial(psnr=25.0)], 400),  # 2 dB, as it turned out
        (make_goal(target_psnr=28.9), [trial(50, psnr=25.0), trial(psnr=25.0)], 512),  # at least 0.8
        (make_goal(target_psnr=32.9), [trial(50, psnr=15.0), trial(psnr=25.0)], 400),  # at most 4
        (make_goal(target_psnr=27.2), [trial(98, psnr=20.0), trial(psnr=25.0)], 200),  # too near to tell
        (make_goal(target_psnr=25.0), [trial(psnr=25.09)], 101),
        (make_goal(target_psnr=20.0), [trial(2, psnr=20.11)], 1),
        (make_goal(target_psnr=20.0), [trial(psnr=math.inf, curves=0)], 1),
        (make_goal(target_psnr=20.0), [trial(psnr=math.inf, curves=0), trial(1, psnr=math.inf, curves=0)], 1),
        (make_goal(target_psnr=20.0), [trial(psnr=-math.inf)], 512),
        (make_goal(max_bytes=5_000, target_psnr=30.0), [trial()], 49),
        (make_goal(max_bytes=50_000, target_psnr=27.2), [trial()], 200),
        (make_goal(auto=True), [trial(64, curves=60)], 64),
    ],
)
def test_the_next_number_of_paths_aims_at_the_bytes_and_the_psnr(goal: Goal, trials: list[Trial], count: float) -> None:
    assert next_count(goal, trials, 512) == count


def test_paths_are_doubled_while_that_pays() -> None:
    first = trial(64, psnr=20.0)
    assert is_worth_doubling(make_goal(auto=True), [first], 512)
    assert not is_worth_doubling(make_goal(auto=True), [first], 127)
    assert is_worth_doubling(make_goal(auto=True, max_bytes=first.bytes), [first], 512)
    assert not is_worth_doubling(make_goal(auto=True, max_bytes=first.bytes - 1), [first], 512)
    paid, not_paid = trial(128, psnr=21.0), trial(128, psnr=20.9)
    assert is_worth_doubling(make_goal(auto=True), [first, paid], 512)
    assert not is_worth_doubling(make_goal(auto=True), [first, not_paid], 512)
    assert not is_worth_doubling(make_goal(auto=True), [first, trial(AUTO_CURVES_MAX, psnr=30.0)], SEARCHED_CURVES_MAX)
    assert worthwhile_count([first]) == 64
    assert worthwhile_count([first, paid]) == 128
    assert worthwhile_count([first, not_paid]) == 64


def test_flat_art_is_not_doubled_for_gains_that_cannot_be_seen() -> None:
    emoji = [trial(64, psnr=42.0), trial(128, psnr=46.0)]
    assert not is_worth_doubling(make_goal(auto=True), emoji[:1], 512)
    assert worthwhile_count(emoji) == 64
    unused = [trial(64, curves=40, psnr=30.0), trial(128, curves=60, psnr=32.0)]
    assert worthwhile_count(unused) == 64
    perfect = trial(64, psnr=math.inf)
    assert worthwhile_count([perfect, trial(128, psnr=math.inf)]) == 64


# a model of fits: bytes linear in the paths, PSNR linear in their logarithm, both with noise


class Fitter:
    """Makes trials of a photo: a ``share`` of the paths is visible, and each doubling gains ``gain`` dB."""

    def __init__(self, seed: int, share: float, gain: float) -> None:
        self._random, self._share, self._gain = random.Random(seed), share, gain

    def made(self, asked: int, eligible: bool = True) -> Trial:
        curves = max(1, round(self._share * asked))
        size = round(1500 + 130 * curves * (1 + self._random.gauss(0, 0.01)))
        psnr = 20.0 + self._gain * math.log2(curves / 64) + self._random.gauss(0, 0.05)
        return trial(asked, size, psnr if eligible else psnr - 0.8, curves, eligible)


def _search(goal: Goal, fitter: Fitter, curves_max: int = SEARCHED_CURVES_MAX) -> list[Trial]:
    """Search as `warpvec.modes.path_count.PathCount` does, without fits."""
    trials = [fitter.made(min(PROBE_CURVES, curves_max), eligible=False)]
    trials.append(fitter.made(next_count(goal, trials, curves_max)))
    outside_count = 0
    while not is_met(goal, trials, curves_max):
        count = next_count(goal, trials, curves_max)
        outside_count += not narrows_bracket(goal, trials, count)
        if outside_count > CORRECTIONS_MAX:
            break
        trials.append(fitter.made(count))
    return trials


SHARES = (1.0, 0.97, 0.9, 0.7)


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("size", [3_000, 6_000, 20_000, 50_000, 200_000, 1_000_000])
def test_a_search_uses_the_bytes_and_stays_below(share: float, size: int) -> None:
    corrections = []
    for seed in range(100):
        trials = _search(make_goal(max_bytes=size), Fitter(seed, share, 2.0))
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
    fewest = next(count for count in range(1, SEARCHED_CURVES_MAX) if model(count) >= target)
    for seed in range(100):
        noise, goal = random.Random(seed), make_goal(target_psnr=target)

        def made(asked: int, loss: float = 0.0, noise: random.Random = noise) -> Trial:
            return trial(asked, size=100 * asked, psnr=model(asked) + noise.gauss(0, 0.05) - loss, eligible=loss == 0)

        trials = [made(PROBE_CURVES, loss=1.0)]
        trials.append(made(next_count(goal, trials, SEARCHED_CURVES_MAX)))
        while not is_met(goal, trials, SEARCHED_CURVES_MAX) and not is_hopeless(goal, trials):
            trials.append(made(next_count(goal, trials, SEARCHED_CURVES_MAX)))
        result = trials[best_trial(goal, trials)]
        assert result.psnr >= target
        assert result.psnr <= target + 0.25 or result.asked <= 1.04 * fewest + 1
        fits.append(len(trials))
    assert max(fits) <= 2 + CORRECTIONS_MAX
    assert sum(fits) / len(fits) <= 7


def test_a_search_ends_with_the_most_paths_where_the_decibels_are_out_of_reach() -> None:
    for seed in range(20):
        goal, fitter = make_goal(target_psnr=40.0), Fitter(seed, 0.9, 2.0)
        trials = _search(goal, fitter, 700)
        assert trials[-1].asked == 700
        assert not make_facts(goal, trials, trials[-1])["met"]


@pytest.mark.parametrize(("size", "target"), [(20_000, 30.0), (200_000, 25.0)])
def test_a_search_with_two_goals_ends_at_the_nearer_one(size: int, target: float) -> None:
    for seed in range(50):
        goal = make_goal(max_bytes=size, target_psnr=target)
        trials = _search(goal, Fitter(seed, 0.97, 2.0))
        assert trials[-1].bytes <= size
        if size == 20_000:
            assert trials[-1].bytes >= 0.95 * size and trials[-1].psnr < target
        else:
            assert target <= trials[best_trial(goal, trials)].psnr <= target + 0.35


def test_the_result_is_the_smallest_file_that_reaches_the_target_within_the_bytes() -> None:
    goal = make_goal(target_psnr=19.0, max_bytes=10_000)
    trials = [
        trial(size=3_000, psnr=19.2, eligible=False),
        trial(size=9_000, psnr=22.8),
        trial(size=8_000, psnr=19.6),
        trial(size=7_000, psnr=19.4),
        trial(size=6_000, psnr=18.97),
        trial(size=11_000, psnr=25.0),
    ]
    assert best_trial(goal, trials) == 3
    # No trial reaches it: the best one is kept, the smallest of equals.
    assert best_trial(make_goal(target_psnr=30.0, max_bytes=10_000), trials) == 1
    assert best_trial(make_goal(max_bytes=10_000), [trial(size=9_000), trial(size=8_000, psnr=25.001)]) == 1
    assert best_trial(goal, trials[:1]) == 0


def test_more_paths_that_gain_nothing_are_hopeless() -> None:
    goal = make_goal(target_psnr=40.0)
    assert is_hopeless(goal, [trial(64, psnr=30.0), trial(1024, psnr=30.7)])
    assert not is_hopeless(goal, [trial(64, psnr=30.0), trial(1024, psnr=31.0)])
    assert not is_hopeless(goal, [trial(1000, psnr=30.0), trial(1200, psnr=30.0)])
    assert not is_hopeless(make_goal(max_bytes=10_000), [trial(64), trial(1024)])
    assert not is_hopeless(goal, [trial(64, psnr=41.0), trial(8, psnr=20.0), trial(16, psnr=20.0)])
