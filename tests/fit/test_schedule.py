"""The schedule: populations, radii, learning rates, and when paths are recycled."""

import math

import pytest
import torch
from scenes import seeded

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.schedule import (
    RADIUS_MIN,
    inflation_count,
    inflation_steps,
    is_recycling,
    lr_factor,
    population,
    radius,
    recycling_radius,
)

# The population


def test_population_doubles_until_it_is_full():
    config = FitConfig(curves=1000)
    assert [population(k, config) for k in range(9)] == [16, 32, 64, 128, 256, 512, 1000, 1000, 1000]


def test_population_rounds_and_stays_full():
    config = FitConfig(growth=1.5, initial_curves=7, curves=40)
    # 7, 10.5, 15.75, 23.625, 35.4, 53.2: halves are rounded up.
    assert [population(k, config) for k in range(7)] == [7, 11, 16, 24, 35, 40, 40]
    assert population(10**9, FitConfig()) == 512
    assert population(0, FitConfig(initial_curves=32, curves=5)) == 5


@pytest.mark.parametrize(("curves", "count"), [(16, 0), (17, 1), (256, 4), (512, 5), (513, 6), (1024, 6)])
def test_inflation_count_of_the_paper(curves, count):
    # "4 times for 256 curves, 5 times for 512, 6 times for 1024".
    assert inflation_count(FitConfig(curves=curves)) == count


@pytest.mark.parametrize("growth", [1.01, 1.5, 3.0, 1e6])
@pytest.mark.parametrize("curves", [17, 512, 16 * 3**6])
def test_inflation_count_is_the_first_full_generation(growth, curves):
    config = FitConfig(growth=growth, curves=curves)
    count = inflation_count(config)
    assert population(count, config) == curves
    assert population(count - 1, config) < curves


def test_a_population_that_cannot_grow_is_refused():
    with pytest.raises(InputError, match="growth must be above 1"):
        inflation_count(FitConfig(growth=1.0))
    assert inflation_count(FitConfig(growth=1.0, curves=16)) == 0


def test_one_generation_starts_full():
    config = FitConfig(one_generation=True, curves=512)
    assert population(0, config) == 512
    assert inflation_count(config) == 0
    assert inflation_steps(config, 1500) == []


def test_a_literal_gap_may_outlast_the_run():
    config = make_config("paper", curves=512, inflation_gap=400, shorten_gap=False)
    assert inflation_steps(config, 1000) == [400, 800, 1200, 1600, 2000]
    assert inflation_steps(make_config("paper", curves=512, inflation_gap=400), 1000) == [100, 200, 300, 400, 500]


def test_inflation_steps_of_the_paper():
    assert inflation_steps(make_config("paper", curves=1024), 5000) == [100, 200, 300, 400, 500, 600]


@pytest.mark.parametrize("iterations", [1, 2, 7, 100, 299])
def test_a_short_run_is_full_at_half_time(iterations):
    steps = inflation_steps(FitConfig(curves=512), iterations)
    assert len(steps) == 5
    assert steps == sorted(steps)
    assert steps[-1] == iterations // 2


# The radius


def test_radius_halves_until_the_floor():
    # Half the longer side of 768x512 is 384, a quarter of that 96.
    config = FitConfig()
    assert [radius(k, config, 512, 768) for k in range(6)] == [96.0, 48.0, 24.0, 12.0, 6.0, 3.0]
    assert radius(0, config, 768, 512) == 96.0
    assert radius(7, config, 512, 768) == RADIUS_MIN
    assert radius(0, config, 1, 1) == RADIUS_MIN
    assert radius(3, FitConfig(radius_decay=1.0), 512, 768) == 96.0


def test_radius_floor_covers_the_pixel_under_the_centre():
    corners = torch.tensor([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]], dtype=torch.float64)
    centers = torch.rand(1000, 2, generator=seeded(), dtype=torch.float64)
    assert torch.cdist(centers, corners).max() <= RADIUS_MIN


def test_the_radius_of_one_generation_is_that_of_the_last():
    config = FitConfig(curves=512)
    one = FitConfig(curves=512, one_generation=True)
    assert radius(0, one, 512, 768) == radius(inflation_count(config), config, 512, 768) == 3.0


def test_recycled_paths_cover_their_share_of_the_canvas():
    area = 512 * math.pi * recycling_radius(FitConfig(curves=512), 512, 768) ** 2
    assert area == pytest.approx(0.3 * 512 * 768)
    assert recycling_radius(FitConfig(curves=256), 256, 384) == pytest.approx(6.05, rel=0.01)
    assert recycling_radius(FitConfig(curves=1024), 8, 8) == RADIUS_MIN


# The learning rate


def test_cosine_decay_runs_from_one_to_lr_final():
    config = FitConfig(lr_final=0.02)
    assert lr_factor(0, config, 1001) == 1.0
    assert lr_factor(500, config, 1001) == pytest.approx(0.51)
    assert lr_factor(250, config, 1001) == pytest.approx(0.02 + 0.98 * (0.5 + math.sqrt(0.125)))
    assert lr_factor(1000, config, 1001) == pytest.approx(0.02)
    assert lr_factor(2000, config, 1001) == pytest.approx(0.02)
    assert lr_factor(0, config, 1) == 1.0


def test_constant_rate_and_scale():
    assert lr_factor(700, FitConfig(lr_decay="constant", lr_scale=3.0), 1000) == 3.0
    assert lr_factor(0, FitConfig(lr_scale=0.5), 1000) == 0.5


def test_steps_of_bezier_splatting():
    config = FitConfig(lr_decay="steps", lr_scale=2.0)
    # 1 for the first 5000 iterations, then 0.5 to 6000, 0.2 to 9000 and 0.1 to the end; the first iteration is 0.
    factors = [lr_factor(iteration, config, 10_000) / 2 for iteration in range(10_000)]
    assert factors == [1.0] * 5000 + [0.5] * 1000 + [0.2] * 3000 + [0.1] * 1000
    assert [lr_factor(iteration, config, 4) for iteration in range(4)] == [2.0, 2.0, 1.0, 0.4]


# Recycling


def test_recycling_starts_at_full_population_and_ends_in_time():
    # All paths are there at 250; then a recycling every 50 iterations until 70 % of 1500.
    config = FitConfig(curves=512, inflation_gap=50, recycle_gap=50, recycle_until=0.7)
    due = [iteration for iteration in range(1500) if is_recycling(iteration, config, 1500)]
    assert due == list(range(300, 1051, 50))


def test_recycling_of_one_generation_starts_at_once():
    due = [
        iteration
        for iteration in range(100)
        if is_recycling(iteration, FitConfig(one_generation=True, recycle_gap=30), 100)
    ]
    assert due == [30, 60]
