"""What a fit draws on: reduced targets, and adjoints in pixels of the full size."""

from __future__ import annotations

import pytest
import torch
from scenes import random_scene

from warpvec.config.presets import make_config
from warpvec.fit.loop import fit
from warpvec.fit.target import Target, reduced
from warpvec.geometry.scene import Scene


def scene_of(seed: int, height: int, width: int) -> Scene:
    tensors = random_scene(seed, 5, height, width)
    floats = (tensors.points, tensors.color, tensors.opacity, tensors.background)
    return Scene(*(value.float() for value in floats), generation=torch.zeros(5, dtype=torch.int64))


def test_reduced_is_the_mean_of_squares_that_the_border_may_cut() -> None:
    image = torch.rand(5, 7, 3, dtype=torch.float64)
    got = reduced(image, 2)
    assert got.shape == (3, 4, 3)
    for row in range(3):
        for column in range(4):
            block = image[2 * row : 2 * row + 2, 2 * column : 2 * column + 2]
            torch.testing.assert_close(got[row, column], block.mean((0, 1)))
    assert reduced(image, 1) is image


@pytest.mark.parametrize("renderer", ["exact", "splat"])
def test_points_adjoint_is_in_pixels_of_the_full_size(renderer: str) -> None:
    target, scene, config = torch.rand(40, 56, 3), scene_of(3, 40, 56), make_config(renderer=renderer)
    adjoints = Target(target, config, "cpu", 2).fit_step(scene, False)
    small = Target(reduced(target, 2), config, "cpu").fit_step(scene.scaled(0.5), False)
    torch.testing.assert_close(adjoints.points, small.points / 2, rtol=1e-6, atol=0)
    torch.testing.assert_close(adjoints.color, small.color, rtol=0, atol=0)
    torch.testing.assert_close(adjoints.loss, small.loss, rtol=0, atol=0)


def test_error_of_a_reduced_canvas_is_that_of_its_own_pixels() -> None:
    target, scene = torch.rand(20, 30, 3), scene_of(1, 20, 30)
    canvas = Target(target, make_config(), "cpu", 2)
    error = canvas.squared_error(scene)
    assert error.shape == (10, 15)
    torch.testing.assert_close(error.mean() / 3, canvas.fit_step(scene, False).loss, rtol=1e-4, atol=0)


def test_a_coarse_start_ends_at_full_size() -> None:
    target = torch.rand(48, 64, 3)
    settings = {"curves": 24, "iterations": 60, "inflation_gap": 5, "recycle_gap": 10, "device": "cpu"}
    seen: list[tuple[int, float]] = []
    coarse = fit(target, make_config(coarse_until=0.5, **settings), lambda p: seen.append((p.iteration, p.psnr)))
    full = fit(target, make_config(**settings))
    # Noise averages out in the coarse target: its errors are far smaller, until the full size shows them all.
    assert seen[29][1] > seen[30][1] + 1
    assert seen[-1][1] == pytest.approx(full.history[-1]["psnr"], abs=1.0)
    again = fit(target, make_config(coarse_until=0.5, threads=1, **settings))
    assert torch.equal(again.scene.points, coarse.scene.points)
