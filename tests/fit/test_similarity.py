"""The term of the loss for structural similarity, and the shift of the target that stands for it."""

from __future__ import annotations

from copy import deepcopy

import pytest
import torch
from torch import Tensor

from warpvec.config.presets import make_config
from warpvec.fit.loop import fit
from warpvec.fit.similarity import ScaleSimilarity, Similarity
from warpvec.fit.state import Saving, State
from warpvec.image.metrics import SSIM_WINDOW, ssim
from warpvec.rendering.draw import draw_pixels

WEIGHT = 0.7


def weighted_similarity(image: Tensor, target: Tensor, scale_count: int) -> float:
    """Return the measured SSIM of the means of the channels, summed over windows and scales, over the pixels there."""
    gray, wanted = (each.mean(2, keepdim=True) for each in (image, target))
    total, pixels = 0.0, float(image[..., 0].numel())
    for _ in range(scale_count):
        height, width = gray.shape[:2]
        window_count = max(height - SSIM_WINDOW + 1, 1) * max(width - SSIM_WINDOW + 1, 1)
        total += window_count * ssim(gray.numpy(), wanted.numpy()) / pixels
        gray, wanted, pixels = halved(gray), halved(wanted), pixels / 4.0
    return WEIGHT * total


def halved(gray: Tensor) -> Tensor:
    """Return ``gray`` [h, w, 1] of half the size, by means of four pixels."""
    height, width = gray.shape[0] // 2, gray.shape[1] // 2
    squares = gray[: 2 * height, : 2 * width].reshape(height, 2, width, 2, 1)
    return squares.mean((1, 3))


@pytest.mark.parametrize(
    ("height", "width", "path_count", "scale_count"),
    [(120, 112, 2, 5), (60, 70, 2, 4), (60, 70, 100, 2), (16, 24, 1, 2), (13, 13, 1, 1), (4, 11, 1, 1)],
)
def test_the_shift_has_the_adjoint_of_measured_similarity(
    height: int, width: int, path_count: int, scale_count: int
) -> None:
    generator = torch.Generator().manual_seed(height)
    target = 0.3 + 0.4 * torch.rand(height, width, 3, generator=generator, dtype=torch.float64)
    image = (target + 0.1 * torch.randn(target.shape, generator=generator, dtype=torch.float64)).clamp(0.0, 1.0)
    # The adjoint of the squared error against a target that is shifted by s has -2 s / (3 h w) beside that without.
    adjoint = (
        2.0
        / (3 * height * width)
        * Similarity(target, path_count).shift(image, torch.tensor(WEIGHT, dtype=torch.float64))
    )
    step = 1e-5
    for row, column, channel in [(0, 0, 0), (height - 1, width - 1, 1), (height // 2, 3, 2)]:
        moved = [image.clone(), image.clone()]
        for sign, each in zip((1.0, -1.0), moved, strict=True):
            each[row, column, channel] += sign * step
        high, low = (weighted_similarity(each, target, scale_count) for each in moved)
        assert float(adjoint[row, column]) == pytest.approx((high - low) / (2.0 * step), rel=1e-5, abs=1e-10)


@pytest.mark.parametrize(("height", "width"), [(7, 7), (16, 9), (23, 40), (4, 11), (55, 130)])
def test_the_kernel_does_what_torch_does(height: int, width: int) -> None:
    generator = torch.Generator().manual_seed(width)
    target, image = torch.rand(2, height, width, generator=generator)
    similarity, weight = ScaleSimilarity(target), torch.tensor(WEIGHT)
    found, wanted = similarity.shift(image, weight), similarity.shift_by_torch(image, weight)
    torch.testing.assert_close(found, wanted, rtol=1e-4, atol=1e-5 * float(wanted.abs().max()))


def textured(height: int, width: int) -> Tensor:
    """Return a picture of two faint textures, whose low contrast the squared error hardly sees."""
    y, x = torch.meshgrid(torch.arange(height) + 0.5, torch.arange(width) + 0.5, indexing="ij")
    faint = 0.5 + 0.06 * torch.sin(0.9 * x) * torch.sin(0.7 * y)
    strong = torch.where((x - 0.7 * width).square() + (y - 0.5 * height).square() < 120.0, 0.9, 0.0)
    return torch.stack([torch.maximum(faint, strong), faint, faint], 2)


def test_a_fit_with_the_term_is_more_similar() -> None:
    target = textured(48, 64)
    settings = {"curves": 24, "iterations": 200, "threads": 1, "device": "cpu", "mode": "photo"}
    scenes = [fit(target, make_config(ssim_weight=weight, **settings)).scene for weight in (0.0, 1.0)]
    without, with_term = (
        ssim(draw_pixels(scene, 48, 64).astype("float64"), target.double().numpy()) for scene in scenes
    )
    assert with_term > without + 0.02


def test_the_reported_loss_is_the_squared_error_alone() -> None:
    target = textured(32, 32)
    # The paths stay as they are, so the loss is the same unless it contains the term.
    resting = {"curves": 8, "iterations": 60, "lr_scale": 0.0, "recycle_gap": 0}
    configs = [make_config(threads=1, device="cpu", ssim_weight=weight, **resting) for weight in (0.0, 20.0)]
    without, with_term = (fit(target, config).history[-1]["psnr"] for config in configs)
    assert with_term == without


@pytest.mark.parametrize("channels", [3, 4])
def test_a_fit_resumes_between_two_shifts(channels: int) -> None:
    photo = torch.cat([textured(32, 40), textured(32, 40)[..., :1]], 2)[..., :channels]
    config = make_config(curves=8, iterations=90, threads=1, device="cpu", mode="photo")
    kept: list[State] = []
    whole = fit(photo, config, saving=Saving(40, lambda state: kept.append(deepcopy(state)))).scene
    resumed = fit(photo, config, resume=kept[0]).scene
    torch.testing.assert_close(resumed.to_dict(), whole.to_dict(), rtol=0.0, atol=0.0)
