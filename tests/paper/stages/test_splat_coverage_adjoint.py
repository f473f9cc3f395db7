"""Sums over the pixels of each Gaussian: closed forms, cut and clip, and paths that cover one another."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from assertions import assert_grad_close, assert_grad_present
from backends import Backend
from oracles import adjoint, cotangent, precisions
from reference.splatting import Settings, gaussians, path_alpha, peak
from scenes import SceneTensors, circle
from splat_oracles import (
    check_gradients,
    in_the_middle,
    make_splat_renderer,
    off_the_band,
    reference_gradients,
    white,
    white_wild,
    wild_path,
)
from sweep import sweep
from torch import Tensor

from warpvec.rendering.tile_renderer import Adjoints

SMALL = Settings(samples=5, lines=2)

SIZES = [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (33, 31), (16, 130), (130, 16)]


def pull(
    scene: SceneTensors, settings: Settings, backend: Backend, adj_coverage: Tensor, dtype: torch.dtype = torch.float64
) -> Adjoints:
    """Return the adjoints for dL/d(coverage) [h, w] of a scene of white paths on black."""
    renderer = make_splat_renderer(scene, settings, backend, dtype)
    return adjoint(scene, renderer, adj_coverage.double()[..., None].expand(-1, -1, 3) / 3)


def tilt(height: int, width: int) -> Tensor:
    """Return a smooth dL/d(coverage) [h, w] without symmetry."""
    y, x = torch.meshgrid(torch.arange(height).double(), torch.arange(width).double(), indexing="ij")
    return 0.3 + 0.07 * x - 0.05 * y + 0.002 * x * y


@pytest.mark.slow
@sweep(("height", "width"), SIZES)
def test_a_path_at_every_border(height: int, width: int, backend: Backend) -> None:
    settings = replace(SMALL, covariance_gradient=True)
    scene = off_the_band(settings, white_wild, height, height, width, 0.7)
    check_gradients(scene, settings, make_splat_renderer(scene, settings, backend), 1e-11)


@sweep("opacity", [0.005, 0.3, 0.95, 0.9989])
@precisions
def test_opacity_of_a_point_in_closed_form(opacity: float, backend: Backend, dtype: torch.dtype) -> None:
    # 20 Gaussians with their peak at the only pixel cover it by 1 - (1 - o)^20.
    scene = white(circle(0.5, 0.5, 0.0), opacity, 1, 1)
    got = pull(scene, SMALL, backend, torch.ones(1, 1), dtype).opacity.double()
    want = torch.tensor([20 * (1 - opacity) ** 19], dtype=torch.float64)
    rtol = 1e-11 if dtype == torch.float64 else 2e-4 / (1 - opacity) ** 0.5
    torch.testing.assert_close(got, want, rtol=rtol, atol=1e-25)


@sweep("opacity", [0.0, 0.0039, 0.9991, 1.0])
@precisions
def test_what_is_dropped_or_clipped_has_exactly_no_gradient(
    opacity: float, backend: Backend, dtype: torch.dtype
) -> None:
    scene = white(circle(0.5, 0.5, 0.0), opacity, 1, 1)
    got = pull(scene, replace(SMALL, covariance_gradient=True), backend, torch.ones(1, 1), dtype)
    assert not got.points.any() and not got.opacity.any()


def test_a_clipped_gaussian_leaves_those_beside_it_their_gradient(backend: Backend) -> None:
    scene = white(circle(20.5, 16.5, 2.1), 1.0, 33, 40)
    values = peak(gaussians(scene.points, SMALL), 0, scene.opacity, 33, 40)
    assert (values > 0.999).any() and ((values > 0.1) & (values < 0.999)).any()
    check_gradients(scene, SMALL, make_splat_renderer(scene, SMALL, backend), 1e-11)


@sweep("offset", [(0.2, 0.0), (0.0, -0.3), (0.15, 0.25)])
def test_the_position_of_a_point_in_closed_form(offset: tuple[float, float], backend: Backend) -> None:
    # All 20 centres are at distance d from the pixel centre; the derivative of alpha = o exp(-q / 2) is alpha S^-1 d.
    opacity, (dx, dy) = 0.4, offset
    scene = white(circle(0.5 - dx, 0.5 - dy, 0.0), opacity, 1, 1)
    d = torch.tensor([dx, dy], dtype=torch.float64)
    side = torch.tensor([0.3, 0.75], dtype=torch.float64)
    line = torch.tensor([0.01, 0.01], dtype=torch.float64)  # which reaches no pixel centre
    a, b = (opacity * torch.exp(-0.5 * (d / sigma).square().sum()) for sigma in (side, line))
    clear = (1 - a) ** 10 * (1 - b) ** 10
    want = clear * 10 * (a / (1 - a) * d / side**2 + b / (1 - b) * d / line**2)
    got = pull(scene, SMALL, backend, torch.ones(1, 1)).points[0].sum(0)
    torch.testing.assert_close(got, want, rtol=1e-11, atol=1e-13)


@sweep("opacity", [0.5, 1.0])
def test_the_released_adjoint_divides_by_a_hundredth_and_goes_on_where_alpha_is_clipped(
    opacity: float, backend: Backend
) -> None:
    # The ten boundary centres of the scene above; the lines' Gaussians reach no pixel centre.
    scene, d = white(circle(0.5, 0.45, 0.0), opacity, 1, 1), torch.tensor([0.0, 0.05], dtype=torch.float64)
    side = torch.tensor([0.3, 0.75], dtype=torch.float64)
    a = opacity * torch.exp(-0.5 * (d / side).square().sum())
    passed = (1 - a.clamp(max=0.999)) ** 10
    want = 10 * passed * a / (1 - a.clamp(max=0.99)) * d / side**2
    renderer = make_splat_renderer(scene, SMALL, backend, released_adjoint=True)
    got = adjoint(scene, renderer, torch.ones(1, 1, 3, dtype=torch.float64) / 3).points[0].sum(0)
    torch.testing.assert_close(got[1], want[1], rtol=1e-9, atol=0)


@precisions
def test_brightness_on_the_right_pulls_a_path_to_the_right(backend: Backend, dtype: torch.dtype) -> None:
    # The path is nearly symmetric about a row of pixel centres, so almost nothing pulls it up or down.
    scene, settings = white(circle(24.5, 16.5, 12.0), 0.6, 33, 50), Settings(8, 4)
    x = torch.arange(-24, 26, dtype=torch.float64).expand(33, 50)
    got = pull(scene, settings, backend, x, dtype).points[0].sum(0)
    # Moving it by 1 px gains its covered area. The steps at the cut, about 7 %, have no derivative.
    area = path_alpha(gaussians(scene.points, settings), scene.opacity, 33, 50).sum().item()
    assert got[0].item() == pytest.approx(area, rel=0.1)
    assert abs(got[1].item()) < 1e-2 * area


def test_a_path_off_the_canvas_has_no_gradient(backend: Backend) -> None:
    for x, y in ((-60.0, 16.0), (120.0, 16.0), (24.0, -60.0), (24.0, 99.0), (1e6, 1e6)):
        got = pull(white(circle(x, y, 8.0), 0.9, 33, 50), SMALL, backend, torch.ones(33, 50))
        assert not got.points.any() and not got.opacity.any() and not got.color.any()


def test_each_covered_pixel_counts_once(backend: Backend) -> None:
    # The parts of the canvas add up; pixels of other tiles or beyond the canvas must add nothing.
    scene = off_the_band(SMALL, white_wild, 3, 20, 35, 0.7)
    whole = reference_gradients(scene, SMALL, cotangent(scene))
    total = torch.zeros_like(scene.points)
    for rows, columns in ((slice(0, 16), slice(0, 16)), (slice(16, 20), slice(0, 16)), (slice(0, 20), slice(16, 35))):
        part = torch.zeros(20, 35, 3, dtype=torch.float64)
        part[rows, columns] = cotangent(scene)[rows, columns]
        got = adjoint(scene, make_splat_renderer(scene, SMALL, backend), part)
        want = reference_gradients(scene, SMALL, part)
        assert_grad_close(got.points, want["points"], rtol=1e-11, atol=1e-13, name="points of a part")
        total += got.points
    assert_grad_close(total, whole["points"], rtol=1e-11, atol=1e-13, name="points")


def test_the_path_above_dims_the_gradient_of_the_one_below(backend: Backend) -> None:
    # The same white path twice on black covers 1 - (1 - a)^2, so both have the gradient of one, times 1 - a.
    path = wild_path(6, 33, 40)
    scene = white(path, 0.5, 33, 40)
    twice = scene._replace(points=path.expand(2, 12, 2).contiguous(), color=torch.ones(2, 3).double())
    twice = twice._replace(opacity=torch.full((2,), 0.5, dtype=torch.float64))
    weight = tilt(33, 40)
    clear = 1 - path_alpha(gaussians(scene.points, SMALL), scene.opacity, 33, 40)[0]
    want = pull(scene, SMALL, backend, weight * clear)
    got = pull(twice, SMALL, backend, weight)
    for row in (0, 1):
        torch.testing.assert_close(got.points[row], want.points[0], rtol=1e-9, atol=1e-11)
        torch.testing.assert_close(got.opacity[row], want.opacity[0], rtol=1e-9, atol=1e-11)


@pytest.mark.slow
@sweep("opacity", [0.2, 0.9, 1.0])
def test_deep_stacks_of_gaussians_in_one_path(opacity: float, backend: Backend) -> None:
    # A default path of 8 px has some 400 Gaussians over a pixel; their transmittance is below 1e-30.
    settings = Settings(covariance_gradient=True)
    scene = white(circle(20.4, 16.3, 8.0), opacity, 33, 40)
    check_gradients(scene, settings, make_splat_renderer(scene, settings, backend), 1e-10)


@sweep("covariance", [True, False])
def test_single_precision(covariance: bool, backend: Backend) -> None:
    settings = Settings(20, 9, covariance_gradient=covariance)
    scene = white_wild(3, 60, 70, 0.6)
    got = pull(scene, settings, backend, tilt(60, 70), torch.float32)
    want = pull(scene, settings, backend, tilt(60, 70))
    for name in ("points", "color", "opacity", "background"):
        assert_grad_close(getattr(got, name), getattr(want, name), rtol=2e-4, atol=0.0, name=name)
        assert_grad_present(getattr(got, name), getattr(want, name), name, floor=1e-2)


@sweep(("samples", "lines"), [(9, 5), (8, 3)])
def test_colors_answer_less_for_what_gaussians_in_the_middle_add(samples: int, lines: int, backend: Backend) -> None:
    settings = Settings(samples, lines, color_falloff=True)
    scene = off_the_band(settings, in_the_middle, 3, 4, 33, 40)
    check_gradients(scene, settings, make_splat_renderer(scene, settings, backend), 1e-10)
    plain = reference_gradients(scene, replace(settings, color_falloff=False), cotangent(scene))
    weak = reference_gradients(scene, settings, cotangent(scene))
    assert (weak["color"] - plain["color"]).norm() > 0.02 * plain["color"].norm()
