"""Soft paths: the reference, finite differences, the lanes of a GPU, and what a scene without any pays."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from assertions import assert_grad_close, assert_grad_present, check_gradients
from backends import Backend
from exact_renderers import HEIGHT, WIDTH, in_float32, make_renderer
from softness import VALUES, reference_image, soft_scene, values_of, with_values
from sweep import sweep

import warpvec
from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.rendering.draw import draw_exactly


@sweep("seed", range(2))
def test_image_and_adjoints_are_those_of_the_reference(seed: int, backend: Backend) -> None:
    scene, renderer = soft_scene(seed, HEIGHT, WIDTH), make_renderer(backend)
    leaves = [value.clone().requires_grad_() for value in values_of(scene)]
    adj_image = torch.randn(HEIGHT, WIDTH, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(seed))
    image = renderer.render(scene.to(backend.device)).cpu()
    want = reference_image(with_values(scene, leaves), renderer)
    torch.testing.assert_close(image, want.detach(), rtol=0, atol=1e-11)
    got = renderer.adjoint(scene.to(backend.device), adj_image.to(backend.device))
    for name, gradient in zip(VALUES, torch.autograd.grad((want * adj_image).sum(), leaves), strict=True):
        assert_grad_close(getattr(got, name), gradient, rtol=1e-9, atol=1e-10, name=name)
        assert_grad_present(getattr(got, name), gradient, name)


def test_float32_is_near_float64(backend: Backend) -> None:
    scene = soft_scene(4, HEIGHT, WIDTH)
    image = make_renderer(backend, torch.float32).render(in_float32(scene).to(backend.device)).cpu()
    off = (image - make_renderer().render(scene)).abs().amax(-1)
    assert off.quantile(0.99) < 1e-3 and off.mean() < 1e-4


def test_gradcheck() -> None:
    scene = soft_scene(1, 14, 19, (0.0, 0.7, 1.9, 3.1))
    leaves = [value.clone().requires_grad_() for value in values_of(scene)]
    check_gradients(lambda *values: warpvec.render(with_values(scene, values), 14, 19), leaves, one_by_one=True)


def test_paths_that_are_sharp_cost_nothing_and_change_nothing(backend: Backend) -> None:
    scene = in_float32(soft_scene(2, HEIGHT, WIDTH, (0.0,) * 5)).to(backend.device)
    renderer, target = make_renderer(backend, torch.float32), torch.rand(HEIGHT, WIDTH, 3)
    got, want = (
        renderer.fit_step(each, renderer.prepare_target(target), True)
        for each in (scene, replace(scene, softness=None))
    )
    assert not got.softness.any() and want.softness is None
    for name in ("segments", "color", "opacity", "canvas_sums", "removal_cost"):
        assert torch.equal(getattr(got, name), getattr(want, name))


def test_each_background_has_the_image_and_the_adjoints_of_a_scene_over_it(backend: Backend) -> None:
    scene, renderer = soft_scene(6, HEIGHT, WIDTH).to(backend.device), make_renderer(backend)
    backgrounds = torch.rand(2, 3, dtype=torch.float64, device=backend.device)
    adj_images = torch.randn(2, HEIGHT, WIDTH, 3, dtype=torch.float64, device=backend.device)
    images = list(renderer.render_over(scene, list(backgrounds)))
    references = [renderer.prepare_target(adj_image) for adj_image in adj_images]
    adjoints = list(renderer.adjoints_over(scene, zip(references, backgrounds, strict=True)))
    for background, adj_image, image, got in zip(backgrounds, adj_images, images, adjoints, strict=True):
        over = replace(scene, background=background)
        assert torch.equal(image, renderer.render(over))
        want = renderer.adjoint(over, adj_image)
        for name in ("segments", "color", "opacity", "softness"):
            assert torch.equal(getattr(got, name), getattr(want, name))


def test_the_number_of_threads_and_the_scene_before_change_no_bit() -> None:
    scene, target, results = in_float32(soft_scene(3, HEIGHT, WIDTH)), torch.rand(HEIGHT, WIDTH, 3), []
    for threads in (1, 2, 3):
        renderer = make_renderer(dtype=torch.float32, threads=threads)
        if threads > 1:  # one of a wider margin
            renderer.render(replace(scene, softness=Softness(torch.full((5,), 20.0))))
        step = renderer.fit_step(scene, renderer.prepare_target(target), True)
        results.append([renderer.render(scene), *(v for v in vars(step).values() if v is not None)])
    for other in results[1:]:
        assert all(map(torch.equal, results[0], other))


def test_a_band_of_a_drawing_has_the_blur_of_what_lies_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = in_float32(soft_scene(5, HEIGHT, WIDTH))
    whole = draw_exactly(scene, HEIGHT, WIDTH, 1)
    monkeypatch.setattr("warpvec.rendering.draw.BAND_PIXELS", 10 * WIDTH)
    torch.testing.assert_close(draw_exactly(scene, HEIGHT, WIDTH, 1), whole, rtol=0, atol=1e-5)


def test_the_renderer_of_the_paper_refuses_soft_paths() -> None:
    scene = Scene.uniform(torch.rand(1, 12, 2), *map(torch.rand, ((1, 3), (1,), (3,))), torch.zeros(1).long())
    with pytest.raises(InputError, match="must have sharp paths"):
        warpvec.render(replace(scene, softness=Softness(torch.ones(1))), 16, 16, renderer="splat")


def test_layers_that_take_too_much_memory_are_refused() -> None:
    scene = in_float32(soft_scene(0, HEIGHT, WIDTH)).select(torch.full((2000,), 3))
    wide = replace(scene, softness=Softness(torch.full((2000,), 240.0)))
    with pytest.raises(InputError, match="layers of at most"):
        draw_exactly(wide, HEIGHT, WIDTH, 1)
