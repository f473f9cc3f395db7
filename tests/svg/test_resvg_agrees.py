"""The exact renderer against resvg's drawing of the file.

resvg (tiny-skia) does not integrate area. It counts 4 x 4 samples per pixel, and whole columns of samples fall in or
out together along a steep edge. One edge is therefore off by up to 1/8 in the coverage of a pixel that it crosses, two
edges by up to 1/4. resvg also flattens curves into coarser pieces and splits them at the canvas border, which moves a
further sample or two; the worst error seen for smooth paths is 0.21. So the tests allow two edges' worth, 1/4, for one
path in one pixel. Paths that cross themselves differ for a second reason, only in the pixel of the crossing: the mean
winding of lobes of opposite sign cancels there, and the mean of 0 and 2 counts as fully covered.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest
import torch
from drawn import EIGHT_BIT, ONE_EDGE, ONE_PATH, SAMPLES, antialiasing_bound, exact_and_drawn
from scenes import SceneTensors, blob_scene, circle, figure_eight, random_scene, rectangle
from torch import Tensor

from warpvec.image.metrics import psnr
from warpvec.kernels.constants import CHORD_TOLERANCE

HEIGHT, WIDTH = 512, 768


def black_on_white(*paths: Tensor, size: int = 64) -> SceneTensors:
    count = len(paths)
    color, white = torch.zeros(count, 3, dtype=torch.float64), torch.ones(3, dtype=torch.float64)
    return SceneTensors(torch.stack(paths), color, torch.ones(count, dtype=torch.float64), white, size, size)


def uniform(generator: np.random.Generator, low: float, high: float) -> float:
    """Return a random coordinate with two decimals."""
    return round(generator.uniform(low, high), 2)


def covered_samples(low: float, high: float, size: int = 64) -> Tensor:
    """Return the fraction of each pixel's samples, at (k + 1/2) / 4, that lie in an interval."""
    sample = (torch.arange(size * SAMPLES, dtype=torch.float64) + 0.5) / SAMPLES
    return ((low <= sample) & (sample < high)).double().reshape(size, SAMPLES).mean(1)


def test_resvg_counts_four_by_four_samples() -> None:
    generator, worst = np.random.default_rng(0), 0.0
    for _ in range(40):
        left, top = uniform(generator, 1, 20), uniform(generator, 1, 20)
        right, bottom = uniform(generator, 22, 60), uniform(generator, 22, 60)
        exact, drawn = exact_and_drawn(black_on_white(rectangle(left, top, right, bottom)))
        samples = 1 - covered_samples(top, bottom)[:, None] * covered_samples(left, right)
        assert (drawn[..., 0] - samples).abs().max() <= EIGHT_BIT
        worst = max(worst, (drawn - exact).abs().max().item())
    # Corners have two edges; 0.23 is possible.
    assert ONE_EDGE < worst < ONE_PATH


def test_one_arc_is_off_by_half_a_row_of_samples() -> None:
    generator, errors = np.random.default_rng(1), []
    for _ in range(60):
        path = circle(uniform(generator, 28, 36), uniform(generator, 28, 36), uniform(generator, 3, 25))
        exact, drawn = exact_and_drawn(black_on_white(path))
        errors.append((exact - drawn).abs().max().item())
    # Our vertices are off by up to 2/3 of the tolerance; 0.01 is for resvg's coordinates in 1/256 px and its 8 bits.
    assert max(errors) <= ONE_EDGE + 2 / 3 * CHORD_TOLERANCE + 0.01


@pytest.mark.parametrize("seed", range(2))
def test_single_blobs_stay_within_the_allowance_of_one_path(seed: int) -> None:
    for number in range(60):
        blob = blob_scene(1000 * seed + number, 1, 64, 64).points[0]
        exact, drawn = exact_and_drawn(black_on_white(blob))
        error = (exact - drawn).abs().amax(-1)
        partial = (exact > 0) & (exact < 1)
        assert error.max() <= ONE_PATH
        # Only pixels at narrow tips, at the canvas border and on resvg's coarser pieces exceed the error of one edge.
        assert (error > ONE_EDGE + 0.01).sum() <= max(2, 0.02 * partial.sum())


@functools.cache
def blobs(seed: int) -> tuple[SceneTensors, Tensor, Tensor]:
    scene = blob_scene(seed, 200, HEIGHT, WIDTH)
    return (scene, *exact_and_drawn(scene))


@pytest.mark.parametrize("seed", range(3))
def test_scenes_of_200_paths_agree_to_45_db(seed: int) -> None:
    _, exact, drawn = blobs(seed)
    assert psnr(exact.numpy(), drawn.numpy()) >= 45


def test_no_pixel_is_farther_off_than_antialiasing_explains() -> None:
    scene, exact, drawn = blobs(0)
    error, bound = (exact - drawn).abs(), antialiasing_bound(scene)
    assert (error <= bound).all(), f"{(error > bound).any(-1).sum()} pixels, by up to {(error - bound).max():.4f}"
    # The bound is not trivial: where no path has an edge it is only rounding, 1/255 of each path above. At the median
    # that is six paths (0.0235), and a pixel with one edge more would have 0.125.
    assert bound.median() < 12 * EIGHT_BIT < ONE_EDGE


@pytest.mark.parametrize("seed", range(2))
def test_scenes_that_cross_themselves_agree_to_45_db(seed: int) -> None:
    exact, drawn = exact_and_drawn(random_scene(seed, 200, HEIGHT, WIDTH))
    assert psnr(exact.numpy(), drawn.numpy()) >= 45


def test_a_crossing_differs_in_its_own_pixel_alone() -> None:
    # The lobes meet in the centre of pixel (32, 32). Its parts of winding +1 and -1 are equal, and 0.4 is covered.
    exact, drawn = exact_and_drawn(black_on_white(figure_eight(12.5, 16.5, 52.5, 48.5)))
    error = (exact - drawn).abs().amax(-1)
    assert exact[32, 32, 0] == pytest.approx(1) and drawn[32, 32, 0] < 0.8
    error[32, 32] = 0
    assert error.max() <= ONE_PATH
