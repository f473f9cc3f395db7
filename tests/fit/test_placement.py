"""Placement of new paths: the distribution of positions, and its edge cases."""

import math

import pytest
import torch
from scenes import seeded

from warpvec.fit.placement import BLUR_REACH, BLUR_SIGMA, _draw, sample_positions


def blurred(residual):
    """Blur by a dense sum of products."""
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
    """Count how often each pixel is drawn in ``repeats`` draws of ``count``."""
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
    hits = draw_pixels(residual, 1, 1500)
    # Chi-square per pixel has mean 1 and deviation sqrt(2 / 126) = 0.13; against the raw residual it is far larger.
    assert chi_square_per_pixel(hits, blurred(residual)) < 1.4
    assert chi_square_per_pixel(hits, residual + 1e-3) > 3.0


def test_distinct_draws_follow_drawing_one_by_one():
    # Two of three pixels: P(i and j) = p_i p_j / (1 - p_i) + p_j p_i / (1 - p_j).
    residual = torch.tensor([[9.0, 0.0, 0.0]], dtype=torch.float64)
    p = (blurred(residual) / blurred(residual).sum())[0].tolist()
    missing = [p[i] * p[j] * (1 / (1 - p[i]) + 1 / (1 - p[j])) for i, j in ((1, 2), (0, 2), (0, 1))]
    repeats = 1000
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


def test_positions_fill_their_pixels_in_random_order():
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
    # One at a time, because several would avoid each other's pixels.
    positions = torch.cat([sample_positions(residual, 1, generator) for _ in range(100)])
    offset = positions - torch.tensor([250.5, 120.5])
    assert offset.abs().max() <= BLUR_REACH * BLUR_SIGMA + 0.5
    assert offset.std(0).mean().item() == pytest.approx(BLUR_SIGMA, rel=0.2)


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_more_positions_than_pixels(value):
    positions = sample_positions(torch.full((2, 3), value), 600, seeded())
    counts = torch.unique(positions.floor(), dim=0, return_counts=True)[1]
    assert counts.shape == (6,)
    # 100 each, with a standard deviation of 9.
    assert (counts - 100).abs().max() < 40


def test_negative_and_non_finite_values_count_as_zero():
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
    weights = torch.zeros(2**24 + 5000)
    weights[2**24 + 4321] = weights[77] = 1.0
    assert set(_draw(weights, 20, seeded()).tolist()) == {77, 2**24 + 4321}


def test_the_same_positions_are_drawn_every_time(device: str) -> None:
    residual = torch.rand(700, 900, generator=torch.Generator().manual_seed(3)).to(device)
    found = [sample_positions(residual, 300, torch.Generator().manual_seed(1)) for _ in range(4)]
    assert all(torch.equal(positions, found[0]) for positions in found)
