"""The target of a fit: losses and adjoints over mattes, visible areas, and the colours of transparent pixels."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from scenes import random_scene

from warpvec.config.presets import make_config
from warpvec.fit.target import Target, blank_error, blurred_step, halved, opaque_colors
from warpvec.geometry.scene import Scene
from warpvec.image.gaussian_blur import GaussianBlur
from warpvec.rendering.exact import ExactRenderer

HEIGHT, WIDTH = 40, 56


def scene_of(seed: int) -> Scene:
    tensors = random_scene(seed, 5, HEIGHT, WIDTH)
    floats = (tensors.points, tensors.color, tensors.opacity, tensors.background)
    return Scene.uniform(*(value.float() for value in floats), generation=torch.zeros(5, dtype=torch.int64))


@pytest.mark.parametrize("renderer", ["exact", "splat"])
def test_a_transparent_image_is_compared_over_both_mattes(renderer: str) -> None:
    image, scene, config = torch.rand(HEIGHT, WIDTH, 4), scene_of(3), make_config(renderer=renderer)
    target = Target(image, config, "cpu")
    found = target.fit_step(scene, True)
    over_mattes = []
    for matte in (0.0, 1.0):
        pixels = image[..., :3] * image[..., 3:] + (1.0 - image[..., 3:]) * matte
        over_mattes.append((Target(pixels, config, "cpu"), replace(scene, background=torch.full((3,), matte))))
    steps = [single.fit_step(over, True) for single, over in over_mattes]
    for name in ("loss", "segments", "color", "opacity", "removal_cost"):
        expected = torch.stack([getattr(step, name) for step in steps]).mean(0)
        torch.testing.assert_close(getattr(found, name), expected, rtol=1e-5, atol=1e-8, msg=name)
    errors = [single.squared_error(over) for single, over in over_mattes]
    torch.testing.assert_close(target.squared_error(scene), torch.stack(errors).mean(0))
    torch.testing.assert_close(target.squared_error(scene).mean() / 3, found.loss, rtol=1e-4, atol=0)


def test_the_adjoint_of_a_blurred_step_equals_finite_differences() -> None:
    tensors = random_scene(4, 3, 24, 30)
    scene = Scene.uniform(
        tensors.points, tensors.color, tensors.opacity, tensors.background,
        generation=torch.zeros(3, dtype=torch.int64),
    )  # fmt: skip
    renderer, blur = ExactRenderer(24, 30, dtype=torch.float64), GaussianBlur(1.2)
    pixels = torch.rand(24, 30, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(5))

    def loss(some: Scene) -> float:
        return float((blur(renderer.render(some)) - pixels).square().mean())

    step = blurred_step(renderer, scene, pixels, blur)
    assert float(step.loss) == pytest.approx(loss(scene), rel=1e-12)
    for name in ("segments", "color", "opacity", "background"):
        values = getattr(scene, name)
        move = 1e-6 * torch.randn(values.shape, dtype=torch.float64, generator=torch.Generator().manual_seed(6))
        rise = loss(replace(scene, **{name: values + move})) - loss(replace(scene, **{name: values - move}))
        assert float((getattr(step, name) * move).sum()) == pytest.approx(rise / 2.0, rel=1e-5), name


def test_a_blurred_target_is_explained_by_the_sharp_scene() -> None:
    scene, config = scene_of(3), make_config()
    sharp = ExactRenderer(HEIGHT, WIDTH).render(scene)
    target = Target(GaussianBlur(1.5)(sharp), config, "cpu", 1.5)
    assert float(target.squared_error(scene).max()) < 1e-9
    assert float(target.fit_step(scene, False).loss) < 1e-9


@pytest.mark.parametrize("channels", [3, 4])
def test_the_error_of_a_blank_canvas_is_that_of_a_scene_without_paths(channels: int) -> None:
    image, scene = torch.rand(HEIGHT, WIDTH, channels), scene_of(3).select(torch.zeros(5, dtype=torch.bool))
    expected = Target(image, make_config(), "cpu").squared_error(scene)
    torch.testing.assert_close(blank_error(image, scene.background), expected)


def test_visible_areas_share_each_pixel_among_the_paths_and_the_canvas() -> None:
    target = Target(torch.rand(HEIGHT, WIDTH, 3), make_config(), "cpu")
    assert float(target.visible_areas(scene_of(1)).sum()) == pytest.approx(HEIGHT * WIDTH, rel=1e-3)


def test_halved_averages_squares_that_the_border_may_cut() -> None:
    image = torch.rand(5, 7, 3, dtype=torch.float64)
    found = halved(image)
    assert found.shape == (3, 4, 3)
    for row in range(3):
        for column in range(4):
            block = image[2 * row : 2 * row + 2, 2 * column : 2 * column + 2]
            torch.testing.assert_close(found[row, column], block.mean((0, 1)))


def test_transparent_pixels_take_the_colours_around_them() -> None:
    image = torch.zeros(33, 40, 4)
    image[..., :3] = torch.tensor([1.0, 0.0, 1.0])  # hidden
    image[:, :10] = torch.tensor([0.1, 0.6, 0.2, 1.0])
    image[:, -10:] = torch.tensor([0.8, 0.3, 0.4, 0.5])
    colors = opaque_colors(image)
    torch.testing.assert_close(colors[:, :10], image[:, :10, :3])
    torch.testing.assert_close(colors[:, -10:], image[:, -10:, :3])
    # No trace of the hidden colour: every colour is a blend of the two that are visible.
    blend = (colors - image[0, 0, :3]) / (image[0, -1, :3] - image[0, 0, :3])
    torch.testing.assert_close(blend, blend[..., :1].expand_as(blend), atol=1e-5, rtol=0)
    assert blend.min() >= -1e-5 and blend.max() <= 1.0 + 1e-5
    assert torch.equal(opaque_colors(image[..., :3]), image[..., :3])
