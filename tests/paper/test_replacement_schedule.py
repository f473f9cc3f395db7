"""When the policy "replacement" removes and adds paths."""

import pytest

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.paper.replacement_schedule import replacement_due


def due_after(config, iterations, what):
    return [k for k in range(1, iterations + 1) if replacement_due(k, config, iterations) == what]


def test_replacement_of_bezier_splatting():
    config = FitConfig(policy="replacement", iterations=10_000)
    assert due_after(config, 10_000, "removal") == list(range(1500, 9000, 1000))
    assert set(range(2000, 9001, 1000)) <= set(due_after(config, 10_000, "addition"))


@pytest.mark.parametrize("iterations", [1, 400, 2500])
@pytest.mark.parametrize("gap", [1, 7, 500])
def test_every_removal_is_followed_by_an_addition_in_time(iterations, gap):
    config = FitConfig(policy="replacement", replace_gap=gap, iterations=iterations, shorten_gap=False)
    additions = set(due_after(config, iterations, "addition"))
    for removal in due_after(config, iterations, "removal"):
        assert removal >= 0.1 * iterations
        assert removal + gap in additions
        assert removal + gap < 0.92 * iterations


@pytest.mark.parametrize("iterations", [20, 200, 300, 1000, 1500])
def test_a_short_run_replaces_as_often_as_a_long_one(iterations):
    config = make_config("bezier-splatting", iterations=iterations)
    assert len(due_after(config, iterations, "removal")) == 8
    literal = make_config("bezier-splatting", iterations=iterations, shorten_gap=False)
    assert len(due_after(literal, iterations, "removal")) == (1 if iterations == 1500 else 0)
