"""Transparent images: reading, reducing, drawing and comparing them; invisible colours never count."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from logo import GREEN, logo, over_matte
from PIL import Image
from scenes import random_scene, with_points

import warpvec
from warpvec.config.presets import make_config
from warpvec.fit.policies.registry import policy_class
from warpvec.fit.population import Population
from warpvec.fit.target import Target, blank_error, opaque_colors
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import ALPHA_MIN, premultiplied, straight
from warpvec.image.metrics import psnr, ssim
from warpvec.image.picture import reduce_image
from warpvec.image.read import read_image
from warpvec.image.write import write_png
from warpvec.svg.measure import draw, file_quality
from warpvec.svg.write import write_svg

RNG = np.random.default_rng(0)


def scene_of(seed, height, width):
    floats = (value.float() for value in random_scene(seed, 5, height, width)[:4])
    return Scene.uniform(*floats, generation=torch.zeros(5, dtype=torch.int64))


# Images.


def test_straight_colours_come_back_except_invisible_ones():
    image = RNG.random((5, 7, 4)).astype(np.float32)
    image[0, :3, 3] = (0.0, ALPHA_MIN / 2, 2 * ALPHA_MIN)
    want = image.copy()
    want[0, :2, :3] = 0.0
    np.testing.assert_allclose(straight(premultiplied(image)), want, atol=1e-6)
    tensor = torch.from_numpy(image)
    np.testing.assert_allclose(straight(premultiplied(tensor)), want, atol=1e-6)
    np.testing.assert_allclose(straight(np.array([[[0.6, -0.1, 1.2, 0.5]]])), [[[1.0, 0.0, 1.0, 0.5]]])


def test_alpha_is_kept_only_if_a_pixel_is_transparent():
    rgba = RNG.integers(0, 256, (4, 6, 4), dtype=np.uint8)
    rgba[0, 0, 3], rgba[1, 1, 3] = 0, 255
    pixels = read_image(rgba)
    assert pixels.dtype == np.float32
    assert (pixels[0, 0] == 0).all()
    np.testing.assert_allclose(pixels.reshape(-1, 4)[1:], rgba.reshape(-1, 4)[1:] / 255, atol=1e-7)
    grey = read_image(rgba[..., 2:])
    np.testing.assert_allclose(grey[1:], rgba[1:][..., [2, 2, 2, 3]] / 255, atol=1e-7)
    rgba[..., 3] = 255
    assert np.array_equal(read_image(rgba), read_image(rgba[..., :3]))
    assert read_image(rgba[..., 2:]).shape == (4, 6, 3)


def test_a_reduction_ignores_invisible_colours():
    # The image has one colour at every alpha, so the filter must not make another one.
    image = np.zeros((64, 48, 4), np.float32)
    image[10:40, 7:30] = (0.2, 0.8, 0.4, 1.0)
    image[30:44, 25:41] = (0.2, 0.8, 0.4, 0.3)
    small = reduce_image(image, 21)
    assert small.shape == (21, 16, 4)
    seen = small[..., 3] > ALPHA_MIN
    assert 0 < seen.sum() < seen.size
    np.testing.assert_allclose(small[seen][:, :3] - [0.2, 0.8, 0.4], 0.0, atol=0.02)
    opaque = reduce_image(np.ascontiguousarray(image[..., [3, 3, 3]]), 21)
    np.testing.assert_allclose(small[..., 3], opaque[..., 0], atol=1e-6)


def test_png_keeps_alpha(tmp_path: Path):
    image = read_image(logo())
    write_png(tmp_path / "logo.png", image)
    with Image.open(tmp_path / "logo.png") as written:
        assert written.mode == "RGBA"
    np.testing.assert_allclose(read_image(tmp_path / "logo.png"), image, atol=1e-6)


# Files and metrics.


def test_a_transparent_scene_has_no_rectangle():
    scene = replace(scene_of(2, 40, 56), transparent=True)
    svg = write_svg(scene, 56, 40)
    assert "<rect" not in svg
    assert "<rect" in write_svg(replace(scene, transparent=False), 56, 40)
    drawing = draw(svg, transparent=True) / 255
    assert drawing.shape == (40, 56, 4)
    assert drawing[..., 3].min() == 0
    # Over white resvg composites by itself and rounds at every path.
    assert np.abs(over_matte(drawing, 1.0) - draw(svg) / 255).max() < 4 / 255
    assert draw(svg, 112, 80, transparent=True).shape == (80, 112, 4)


def test_metrics_are_means_over_a_black_and_a_white_matte():
    a, b = RNG.random((2, 20, 30, 4))
    squares = [np.square(over_matte(a, matte) - over_matte(b, matte)).mean() for matte in (0.0, 1.0)]
    assert psnr(a, b) == pytest.approx(-10 * math.log10(np.mean(squares)))
    similarities = [ssim(over_matte(a, matte), over_matte(b, matte)) for matte in (0.0, 1.0)]
    assert ssim(a, b) == pytest.approx(np.mean(similarities))
    magenta, green = logo() / 255, logo(hidden=GREEN) / 255
    assert psnr(magenta, green) == math.inf
    assert ssim(magenta, green) == pytest.approx(1.0)


def test_file_quality_compares_alpha_too():
    photo = np.zeros((8, 8, 4), np.float32)
    photo[..., 3] = 0.5
    attributes = 'xmlns="http://www.w3.org/2000/svg" width="8" height="8"'
    empty = f"<svg {attributes}/>"
    assert file_quality(empty, photo)["psnr"] == pytest.approx(-10 * math.log10(0.25 / 2))
    veil = f'<svg {attributes}><path d="M0 0h8v8h-8z" fill-opacity=".5"/></svg>'
    assert file_quality(veil, photo)["psnr"] > 50


# The renderers.


@pytest.mark.parametrize("renderer", ["exact", "splat"])
def test_an_image_with_alpha_fits_any_matte(device: str, renderer: str):
    scene = scene_of(5, 33, 40).to(device)
    image = warpvec.render(scene, 33, 40, renderer=renderer, alpha=True)
    assert image.shape == (33, 40, 4)
    assert 0 <= image[..., 3].min() < 0.01 < 0.9 < image[..., 3].max() <= 1
    for matte in (scene.background, torch.tensor([0.9, 0.1, 0.4]).to(device)):
        want = warpvec.render(replace(scene, background=matte), 33, 40, renderer=renderer)
        torch.testing.assert_close(image[..., :3] + (1 - image[..., 3:]) * matte, want, rtol=0, atol=1e-5)


def test_alpha_is_differentiable():
    tensors = random_scene(4, 5, 33, 40)
    inputs = [value.clone().requires_grad_() for value in (tensors.points, tensors.color, tensors.opacity)]

    def alpha_sum(points, color, opacity):
        scene = Scene.uniform(points, color, opacity, tensors.background, torch.zeros(5, dtype=torch.int64))
        return (warpvec.render(scene, 33, 40, alpha=True) * weight).sum()

    weight = torch.rand(33, 40, 4, dtype=torch.float64) * torch.tensor([0.0, 0.0, 0.0, 1.0])
    alpha_sum(*inputs).backward()
    points, color, opacity = inputs
    assert color.grad.abs().max() < 1e-12
    for value, index in ((opacity, (2,)), (points, (3, 4, 1))):
        near = [[v.detach().clone() for v in inputs] for _ in range(2)]
        position = next(k for k, v in enumerate(inputs) if v is value)
        near[0][position][index] -= 1e-6
        near[1][position][index] += 1e-6
        want = (alpha_sum(*near[1]) - alpha_sum(*near[0])) / 2e-6
        assert value.grad[index].item() == pytest.approx(want.item(), rel=1e-3, abs=1e-6)


# The steps of a fit.


@pytest.mark.parametrize("renderer", ["exact", "splat"])
def test_a_step_has_the_mean_error_over_both_mattes(device: str, renderer: str):
    pixels, scene = torch.rand(40, 56, 4).to(device), scene_of(3, 40, 56).to(device)
    target = Target(pixels, make_config(renderer=renderer), device)
    adjoints = target.fit_step(scene, True)
    points, color, opacity = (v.clone().requires_grad_() for v in (scene.points, scene.color, scene.opacity))
    free = replace(with_points(scene, points), color=color, opacity=opacity)
    image = warpvec.render(free, 40, 56, renderer=renderer, alpha=True)
    error = image - premultiplied(pixels)
    # Over black the error is that of the premultiplied colours, over white also that of 1 - alpha.
    loss = (error[..., :3].square().mean() + (error[..., :3] - error[..., 3:]).square().mean()) / 2
    loss.backward()
    assert adjoints.loss.item() == pytest.approx(loss.item(), rel=1e-4)
    for got, want in (
        (adjoints.segments.view_as(points), points),
        (adjoints.color, color),
        (adjoints.opacity, opacity),
    ):
        torch.testing.assert_close(got, want.grad, rtol=1e-3, atol=1e-6)
    total = target.squared_error(scene).mean() / 3
    assert total.item() == pytest.approx(loss.item(), rel=1e-4)


def test_removal_costs_are_over_both_mattes():
    pixels, scene = torch.rand(40, 56, 4), scene_of(3, 40, 56)
    target = Target(pixels, make_config(), "cpu")
    step = target.fit_step(scene, True)
    for path in range(len(scene)):
        rest = scene.select(torch.arange(len(scene)) != path)
        gain = target.fit_step(rest, False).loss - step.loss
        assert step.removal_cost[path].item() == pytest.approx(gain.item(), rel=1e-3, abs=1e-6)


def test_invisible_pixels_have_no_error():
    target = torch.zeros(4, 6, 4)
    target[:2] = torch.tensor([1.0, 1.0, 1.0, 0.5])
    error = blank_error(target, torch.tensor([0.3, 0.3, 0.3]))
    assert (error[2:] == 0).all()
    torch.testing.assert_close(error[:2], torch.full((2, 6), 0.25 * 3 / 2))


def test_paint_around_a_shape_has_its_colour():
    target = torch.zeros(37, 50, 4)
    target[20:22, 30:33] = torch.tensor([0.9, 0.2, 0.1, 0.4])
    torch.testing.assert_close(opaque_colors(target), torch.tensor([0.9, 0.2, 0.1]).expand(37, 50, 3))
    assert opaque_colors(torch.zeros(3, 5, 4)).isfinite().all()
    opaque = torch.rand(3, 5, 3)
    assert opaque_colors(opaque) is opaque


@pytest.mark.parametrize("policy", ["scaffolding", "replacement"])
def test_new_paths_have_visible_colours(policy: str):
    target = torch.zeros(40, 56, 4)
    target[10:30, 10:40] = torch.tensor([0.9, 0.2, 0.1, 0.3])
    config = make_config("draft", policy=policy, curves=16, iterations=20, replace_gap=1, color_parameter="direct")
    maker = policy_class(policy)(target, config, 0)
    scene = maker.first_paths(torch.zeros(3))
    if policy == "replacement":
        population = Population(replace(scene, opacity=torch.full((16,), 0.01)), config, 28.0)
        for iteration in (11, 12):
            maker.update(population, iteration, 20, None, lambda _: blank_error(target, torch.zeros(3)))
        scene = population.scene.select(population.scene.generation > 0)
        assert len(scene)
    torch.testing.assert_close(scene.color, torch.tensor([0.9, 0.2, 0.1]).expand(len(scene), 3))
