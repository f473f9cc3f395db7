"""The schedule against closed forms, and the sampling of positions against the distribution it promises."""

import math

import pytest
import torch

from warpvec.config import FitConfig, make_config
from warpvec.errors import InputError
from warpvec.schedule import (
    BLUR_REACH,
    BLUR_SIGMA,
    RADIUS_MIN,
    inflation_count,
    inflation_steps,
    is_recycling,
    lr_factor,
    population,
    radius,
    recycling_radius,
    replacement_due,
    sample_positions,
)


def seeded(seed=0):
    return torch.Generator().manual_seed(seed)


# The population


def test_population_doubles_until_it_is_full():
    config = FitConfig(curves=1000)
    assert [population(k, config) for k in range(9)] == [16, 32, 64, 128, 256, 512, 1000, 1000, 1000]


@pytest.mark.parametrize("growth", [1.01, 1.1, 1.5, math.e, 3.0, 100.0])
@pytest.mark.parametrize(("initial", "curves"), [(16, 512), (1, 3), (7, 1000), (16, 16), (32, 5)])
def test_population_is_the_rounded_power_capped(growth, initial, curves):
    config = FitConfig(growth=growth, initial_curves=initial, curves=curves)
    for k in range(40):
        assert population(k, config) == min(int(initial * growth**k + 0.5), curves), k


def test_population_after_very_many_inflations_is_full():
    assert population(10**9, FitConfig()) == 512


@pytest.mark.parametrize(("curves", "count"), [(16, 0), (17, 1), (256, 4), (512, 5), (513, 6), (1024, 6)])
def test_inflation_count_of_the_paper(curves, count):
    # "4 times for 256 curves, 5 times for 512, 6 times for 1024".
    assert inflation_count(FitConfig(curves=curves)) == count


@pytest.mark.parametrize("growth", [1.01, 1.1, 1.5, 2.0, 3.0, 1e6])
@pytest.mark.parametrize("curves", [17, 100, 512, 2048, 16 * 3**9])
def test_inflation_count_is_the_first_full_generation(growth, curves):
    config = FitConfig(growth=growth, curves=curves)
    count = inflation_count(config)
    assert population(count, config) == curves
    assert population(count - 1, config) < curves


def test_a_population_that_cannot_grow_is_told():
    with pytest.raises(InputError, match="growth must be more than 1"):
        inflation_count(FitConfig(growth=1.0))
    assert inflation_count(FitConfig(growth=1.0, curves=16)) == 0


def test_flat_starts_full():
    config = FitConfig(flat=True, curves=512)
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


def test_flat_radius_is_that_of_the_last_generation():
    config = FitConfig(curves=512)
    flat = FitConfig(curves=512, flat=True)
    assert radius(0, flat, 512, 768) == radius(inflation_count(config), config, 512, 768) == 3.0


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
    # 1 in iterations 1 to 5000, then 0.5 to 6000, 0.2 to 9000 and 0.1 to the end; the first iteration is 0 here.
    factors = [lr_factor(iteration, config, 10_000) / 2 for iteration in range(10_000)]
    assert factors == [1.0] * 5000 + [0.5] * 1000 + [0.2] * 3000 + [0.1] * 1000
    assert [lr_factor(iteration, config, 4) for iteration in range(4)] == [2.0, 2.0, 1.0, 0.4]


# Replacement


def due_after(config, iterations, what):
    return [k for k in range(1, iterations + 1) if replacement_due(k, config, iterations) == what]


def test_replacement_of_bezier_splatting():
    config = FitConfig(policy="replacement")
    assert due_after(config, 10_000, "removal") == list(range(1500, 9000, 1000))
    assert set(range(2000, 9001, 1000)) <= set(due_after(config, 10_000, "addition"))


@pytest.mark.parametrize("iterations", [1, 400, 1500, 2500, 9999])
@pytest.mark.parametrize("gap", [1, 7, 100, 500])
def test_every_removal_is_followed_by_an_addition_in_time(iterations, gap):
    config = FitConfig(policy="replacement", replace_gap=gap)
    additions = set(due_after(config, iterations, "addition"))
    for removal in due_after(config, iterations, "removal"):
        assert removal >= 0.1 * iterations
        assert removal + gap in additions
        assert removal + gap < 0.92 * iterations


# Recycling


def test_recycling_starts_at_full_population_and_ends_in_time():
    # Full at 250, then every 50 iterations until 70 % of 1500.
    config = FitConfig(curves=512, inflation_gap=50, recycle_gap=50, recycle_until=0.7)
    due = [iteration for iteration in range(1500) if is_recycling(iteration, config, 1500)]
    assert due == list(range(300, 1051, 50))


def test_recycling_of_a_flat_fit_starts_at_once():
    due = [iteration for iteration in range(100) if is_recycling(iteration, FitConfig(flat=True, recycle_gap=30), 100)]
    assert due == [30, 60]


def test_recycling_can_be_switched_off():
    assert not any(is_recycling(iteration, FitConfig(recycle_gap=0), 1500) for iteration in range(1500))


# Positions


def blurred(residual):
    """The blur as a dense sum of products, for comparison."""
    height, width = residual.shape
    reach = 3 * int(BLUR_SIGMA)
    kernel = [math.exp(-0.5 * (d / BLUR_SIGMA) ** 2) for d in range(-reach, reach + 1)]
    out = torch.zeros_like(residual)
    for dy, ky in enumerate(kernel, -reach):
        for dx, kx in enumerate(kernel, -reach):
            rows = (torch.arange(height) + dy).clamp(0, height - 1)
            columns = (torch.arange(width) + dx).clamp(0, width - 1)
            out += ky * kx * residual[rows][:, columns]
    return out / sum(kernel) ** 2


def draw_pixels(residual, count, repeats):
    """How often each pixel was drawn in ``repeats`` draws of ``count``."""
    hits = torch.zeros(residual.shape, dtype=torch.float64)
    generator = seeded(3)
    for _ in range(repeats):
        x, y = sample_positions(residual, count, generator).floor().long().unbind(1)
        hits.index_put_((y, x), torch.ones(count, dtype=torch.float64), accumulate=True)
    return hits


def chi_square_per_pixel(hits, probability):
    expected = probability / probability.sum() * hits.sum()
    return ((hits - expected).square() / expected).mean().item()


def test_single_draws_follow_the_blurred_residual():
    residual = torch.rand(9, 14, generator=seeded(), dtype=torch.float64) ** 4
    residual[2, 3] = 20.0
    hits = draw_pixels(residual, 1, 6000)
    # Chi-square per pixel has mean 1 and deviation sqrt(2 / 126) = 0.13; for the raw residual far more.
    assert chi_square_per_pixel(hits, blurred(residual)) < 1.4
    assert chi_square_per_pixel(hits, residual + 1e-3) > 3.0


def test_distinct_draws_follow_drawing_one_by_one():
    # Two of three pixels: P(i and j) = p_i p_j / (1 - p_i) + p_j p_i / (1 - p_j).
    residual = torch.tensor([[9.0, 0.0, 0.0]], dtype=torch.float64)
    p = (blurred(residual) / blurred(residual).sum())[0].tolist()
    missing = [p[i] * p[j] * (1 / (1 - p[i]) + 1 / (1 - p[j])) for i, j in ((1, 2), (0, 2), (0, 1))]
    repeats = 3000
    hits = draw_pixels(residual, 2, repeats)[0]
    expected = repeats * (1 - torch.tensor(missing, dtype=torch.float64))
    assert sum(missing) == pytest.approx(1.0)
    assert ((hits - expected).abs() < 4 * math.sqrt(repeats * 0.25)).all()
    assert hits[0] - hits[2] > 0.5 * (expected[0] - expected[2])


@pytest.mark.parametrize("shape", [(40, 60), (1, 5000), (5000, 1), (3, 1024)])
def test_pixels_are_distinct_and_positions_inside(shape):
    height, width = shape
    positions = sample_positions(torch.rand(shape, generator=seeded()), 500, seeded())
    pixels = positions.floor().long()
    assert positions.shape == (500, 2)
    assert positions.dtype == torch.float32
    assert len(torch.unique(pixels, dim=0)) == 500
    assert (pixels >= 0).all()
    assert (pixels < torch.tensor([width, height])).all()


def test_positions_fill_their_pixels_and_come_in_no_order():
    positions = sample_positions(torch.zeros(50, 50, dtype=torch.float64), 2500, seeded())
    inside = positions - positions.floor()
    # The mean of 2500 uniform values has a deviation of 0.0058.
    torch.testing.assert_close(inside.mean(0), torch.full((2,), 0.5, dtype=torch.float64), rtol=0, atol=0.025)
    assert inside.min() < 0.01
    assert inside.max() > 0.99
    rank = torch.arange(2500, dtype=torch.float64)
    assert torch.corrcoef(torch.stack([rank, positions[:, 1]]))[0, 1].abs() < 0.1


def test_an_image_without_residual_is_sampled_evenly():
    hits = draw_pixels(torch.zeros(10, 20), 20, 300)
    assert chi_square_per_pixel(hits, torch.ones(10, 20, dtype=torch.float64)) < 1.3


def test_all_pixels_are_drawn_once_even_where_the_residual_is_zero():
    residual = torch.zeros(30, 40)
    residual[4, 5] = 1.0
    pixels = sample_positions(residual, 1200, seeded()).floor()
    assert len(torch.unique(pixels, dim=0)) == 1200


def test_positions_stay_near_a_single_error():
    residual = torch.zeros(300, 400)
    residual[120, 250] = 1e-12
    generator = seeded()
    # One at a time: several would keep out of each other's pixels.
    positions = torch.cat([sample_positions(residual, 1, generator) for _ in range(100)])
    offset = positions - torch.tensor([250.5, 120.5])
    assert offset.abs().max() <= BLUR_REACH * BLUR_SIGMA + 0.5
    assert offset.std(0).mean().item() == pytest.approx(BLUR_SIGMA, rel=0.2)


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_more_positions_than_pixels(value):
    positions = sample_positions(torch.full((2, 3), value), 600, seeded())
    counts = torch.unique(positions.floor(), dim=0, return_counts=True)[1]
    assert counts.shape == (6,)
    # 100 each, with a deviation of 9.
    assert (counts - 100).abs().max() < 40


def test_values_that_are_no_residual_count_as_zero():
    residual = torch.zeros(60, 60)
    residual[30, 30] = 1.0
    residual[5, 5], residual[5, 50], residual[50, 5] = math.nan, math.inf, -1.0
    positions = sample_positions(residual, 30, seeded())
    assert (positions - 30.5).abs().max() <= 6.5


def test_the_seed_decides():
    residual = torch.rand(40, 60, generator=seeded())
    first, again = (sample_positions(residual, 64, seeded(7)) for _ in range(2))
    torch.testing.assert_close(first, again, rtol=0, atol=0)
    assert not torch.equal(first, sample_positions(residual, 64, seeded(8)))


def test_no_positions():
    assert sample_positions(torch.ones(4, 4), 0, seeded()).shape == (0, 2)


def test_more_pixels_than_multinomial_takes():
    residual = torch.zeros(4100, 4100)
    residual[4000, 4050] = 1.0
    positions = sample_positions(residual, 8, seeded())
    assert (positions - torch.tensor([4050.5, 4000.5])).abs().max() <= 6.5
