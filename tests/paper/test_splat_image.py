"""The image of the splat renderer against the reference: sizes, counts, degenerate paths, opacities."""

from __future__ import annotations

from collections.abc import Callable

import torch
from backends import Backend
from oracles import adjoint, cotangent, render
from reference.splatting import Settings
from scenes import ZOO, SceneTensors, ZooCase, degenerate_scene, random_scene
from splat_oracles import (
    OPACITIES,
    check_gradients,
    check_image,
    in_the_middle,
    layered,
    loop_scene,
    make_splat_renderer,
    off_the_band,
)
from sweep import sweep

SIZES = [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (33, 31), (20, 528)]

SHAPES = [(3, 2), (3, 3), (3, 5), (2, 2), (5, 2)]
"""Degree and number of pieces, beside the usual 3 and 4."""

SMALL = Settings(samples=7, lines=2)

EXACT = 1e-11
"""Tolerance in float64: errors are below 1e-13, or 1e-11 for paths of 1e3 canvases and tangents of 1e-4 px."""

Maker = Callable[..., SceneTensors]


@sweep(("height", "width"), SIZES)
@sweep("make", [random_scene, degenerate_scene])
def test_image_at_every_border(make: Maker, height: int, width: int, backend: Backend) -> None:
    scene = off_the_band(SMALL, make, height + width, 9, height, width)
    check_image(scene, SMALL, make_splat_renderer(scene, SMALL, backend), EXACT)


@sweep("path_count", [0, 1, 2, 63, 64, 65])
def test_image_of_any_number_of_paths(path_count: int, backend: Backend) -> None:
    settings = Settings(4, 1)
    scene = off_the_band(settings, random_scene, path_count, path_count, 33, 40)
    check_image(scene, settings, make_splat_renderer(scene, settings, backend, threads=3), EXACT)


@sweep(("degree", "pieces"), SHAPES)
def test_image_of_any_degree_and_number_of_pieces(degree: int, pieces: int, backend: Backend) -> None:
    settings = Settings(11, 3, degree)
    scene = off_the_band(settings, loop_scene, degree, 8, 33, 40, degree, pieces)
    check_image(scene, settings, make_splat_renderer(scene, settings, backend), EXACT)


@sweep(("samples", "lines"), [(2, 1), (3, 5), (15, 2), (16, 1), (17, 5), (33, 2)])
def test_image_of_any_number_of_samples_and_lines(samples: int, lines: int, backend: Backend) -> None:
    settings = Settings(samples, lines)
    scene = off_the_band(settings, random_scene, samples, 6, 33, 40)
    check_image(scene, settings, make_splat_renderer(scene, settings, backend), EXACT)


def test_image_and_gradients_of_the_default_numbers_of_samples_and_lines(backend: Backend) -> None:
    settings = Settings(covariance_gradient=True)
    scene = off_the_band(settings, in_the_middle, 3, 3, 20, 24)
    renderer = make_splat_renderer(scene, settings, backend)
    check_image(scene, settings, renderer, EXACT)
    check_gradients(scene, settings, renderer, 1e-10)


@sweep("case", ZOO)
def test_image_of_the_zoo(case: ZooCase, backend: Backend) -> None:
    # The zoo is moved slightly, because its symmetry puts alphas and clamps exactly at their thresholds.
    settings = Settings(6, 2)
    scene = case.scene._replace(points=case.scene.points + 1e-3 * torch.randn(2, dtype=torch.float64))
    reach = max(1.0, scene.points.abs().max().item() / 1e3) if len(scene.points) else 1.0
    check_image(scene, settings, make_splat_renderer(scene, settings, backend), EXACT * reach)


@sweep("opacity", OPACITIES)
def test_image_and_gradients_of_any_opacity(opacity: tuple[float, ...], backend: Backend) -> None:
    scene = off_the_band(SMALL, layered, 4, 33, 40, *opacity)
    renderer = make_splat_renderer(scene, SMALL, backend)
    check_image(scene, SMALL, renderer, EXACT)
    check_gradients(scene, SMALL, renderer, 1e-10)
    got = adjoint(scene, renderer, cotangent(scene))
    hidden = scene.opacity < 1 / 255
    assert not any(getattr(got, name)[hidden].any() for name in ("points", "color", "opacity"))


def test_no_paths(backend: Backend) -> None:
    scene = random_scene(1, 0, 17, 33)
    renderer = make_splat_renderer(scene, SMALL, backend)
    assert torch.equal(render(scene, renderer), scene.background.expand(17, 33, 3))
    adj_image = cotangent(scene)
    got = adjoint(scene, renderer, adj_image)
    torch.testing.assert_close(got.background, adj_image.sum((0, 1)), rtol=1e-12, atol=1e-12)
    assert got.points.shape == (0, 12, 2) and got.opacity.shape == (0,) and got.color.shape == (0, 3)
