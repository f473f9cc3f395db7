"""The splat renderer: fused step, removal costs, hidden paths, paths that are not finite, reproducible bits."""

from __future__ import annotations

import re
from dataclasses import fields

import pytest
import torch
import warp as wp
from assertions import assert_close_off_edges, assert_grad_close
from backends import SCALAR, Backend
from oracles import GRADIENTS, adjoint, cotangent, fit_step, precisions, render, target_image
from reference import mean_squared_error
from reference.splatting import Settings
from scenes import SceneTensors, circle, random_scene
from splat_oracles import (
    OPACITIES,
    layered,
    make_splat_renderer,
    min_margin,
    reference_gradients,
    reference_image,
    switches,
    with_switches,
)
from sweep import sweep
from torch import Tensor

from warpvec.errors import InputError
from warpvec.paper.splat import SplatRenderer

SMALL = Settings(samples=7, lines=2)

EXACT = 1e-11
"""Tolerance in float64: errors are below 1e-13, or 1e-11 for paths of 1e3 canvases and tangents of 1e-4 px."""


# The fused step


@sweep(("height", "width"), [(1, 1), (33, 50), (17, 1037)])
@switches
def test_fit_step_is_render_then_error_then_adjoint(
    height: int, width: int, interior: bool, covariance: bool, backend: Backend
) -> None:
    settings = with_switches(SMALL, interior, covariance)
    scene = random_scene(height, 12, height, width)
    renderer = make_splat_renderer(scene, settings, backend)
    difference = render(scene, renderer) - target_image(scene)
    want = adjoint(scene, renderer, 2 * difference / difference.numel())
    got = fit_step(scene, renderer)
    for name in GRADIENTS:
        assert_grad_close(getattr(got, name), getattr(want, name), rtol=1e-12, atol=1e-16, name=name)
    torch.testing.assert_close(got.loss, difference.square().mean(), rtol=1e-12, atol=0)
    assert got.removal_cost is None


def test_fit_step_in_single_precision(backend: Backend) -> None:
    scene = random_scene(4, 12, 33, 50)
    exact = fit_step(scene, make_splat_renderer(scene, SMALL), True)
    single = fit_step(scene, make_splat_renderer(scene, SMALL, backend, torch.float32), True)
    for name in (*GRADIENTS, "removal_cost"):
        assert_grad_close(getattr(single, name), getattr(exact, name), rtol=1e-3, atol=0.0, name=name)
    torch.testing.assert_close(single.loss.double(), exact.loss, rtol=1e-5, atol=0)


@sweep("path_count", [1, 12, 65])
def test_removal_cost_is_the_rise_of_the_loss_without_the_path(path_count: int, backend: Backend) -> None:
    scene = random_scene(path_count, path_count, 33, 40)
    check_removal_cost(scene, make_splat_renderer(scene, SMALL, backend))


@sweep("opacity", OPACITIES)
def test_removal_costs_of_any_opacity(opacity: tuple[float, ...]) -> None:
    scene = layered(4, 33, 40, *opacity)
    check_removal_cost(scene, make_splat_renderer(scene, SMALL))


def check_removal_cost(scene: SceneTensors, renderer: SplatRenderer) -> None:
    got = fit_step(scene, renderer, want_removal_cost=True).removal_cost
    target, error = target_image(scene), mean_squared_error(render(scene, renderer), target_image(scene))
    want = []
    for row in range(len(scene.points)):
        rest = [other for other in range(len(scene.points)) if other != row]
        left = scene._replace(points=scene.points[rest], color=scene.color[rest], opacity=scene.opacity[rest])
        want.append(mean_squared_error(render(left, renderer), target) - error)
    # Differences of losses of about 0.1, each a sum over the image.
    torch.testing.assert_close(got, torch.stack(want), rtol=1e-9, atol=1e-12)


@precisions
def test_asking_for_removal_costs_changes_nothing_else(backend: Backend, dtype: torch.dtype) -> None:
    scene = random_scene(6, 12, 33, 50)
    renderer = make_splat_renderer(scene, SMALL, backend, dtype)
    plain, asked = fit_step(scene, renderer), fit_step(scene, renderer, want_removal_cost=True)
    for name in (*GRADIENTS, "loss"):
        torch.testing.assert_close(getattr(asked, name), getattr(plain, name), rtol=1e-5, atol=1e-9)


def test_the_defaults_are_the_papers() -> None:
    scene = random_scene(2, 3, 20, 24)
    default = SplatRenderer(20, 24, dtype=torch.float64, lane_width=16, transmittance_min=0.0)
    spelled = make_splat_renderer(scene, Settings(64, 40, 3, interior_gradient=True, covariance_gradient=False))
    assert torch.equal(render(scene, default), render(scene, spelled))
    assert torch.equal(
        adjoint(scene, default, cotangent(scene)).points, adjoint(scene, spelled, cotangent(scene)).points
    )


# What is hidden, what is not finite, what was there before


def covered(seed: int, height: int = 33, width: int = 40) -> SceneTensors:
    """Return a random scene of 6 paths under four opaque covers, with two paths above them."""
    scene = random_scene(seed, 12, height, width)
    cover = circle(0.5 * width, 16.0, 45.0).expand(4, 12, 2)
    over = torch.stack([circle(12.0, 16.0, 5.0), circle(28.0, 16.0, 6.0)])
    opacity = torch.cat([scene.opacity[:6], torch.ones(4), scene.opacity[10:]])
    return scene._replace(points=torch.cat([scene.points[:6], cover, over]), opacity=opacity)


@sweep(("height", "width"), [(32, 48), (33, 40), (31, 33)])
def test_skipping_what_is_hidden_changes_next_to_nothing(height: int, width: int, backend: Backend) -> None:
    # Pixels of a cut tile that lie off the canvas must not keep the tile going.
    scene, settings = covered(1, height, width), Settings(24, 12)
    full, cut = (make_splat_renderer(scene, settings, backend, transmittance_min=least) for least in (0.0, 1e-4))
    torch.testing.assert_close(render(scene, cut), render(scene, full), rtol=0, atol=1e-4)
    adj_image = cotangent(scene)
    got, want = adjoint(scene, cut, adj_image), adjoint(scene, full, adj_image)
    for name in ("points", "color", "opacity"):
        visible = getattr(want, name)[6:]
        # The colour behind the last visible cover contributes 1e-4 to the gradient of that cover.
        assert_grad_close(getattr(got, name)[6:], visible, rtol=1e-2, atol=0.0, name=name)
        assert_grad_close(getattr(got, name)[10:], visible[4:], rtol=1e-3, atol=0.0, name=name)
    if backend != SCALAR:  # scalar lanes on the CPU see one pixel and not its tile, so they skip nothing
        assert not any(getattr(got, name)[:6].any() for name in ("points", "color", "opacity"))
        assert all(getattr(want, name)[:6].any() for name in ("points", "color", "opacity"))


@precisions
def test_what_is_in_the_buffers_of_hidden_pairs_is_not_read(backend: Backend, dtype: torch.dtype) -> None:
    scene, settings = covered(3), Settings(24, 12, covariance_gradient=True)
    renderer = make_splat_renderer(scene, settings, backend, dtype, transmittance_min=1e-4)
    want = adjoint(scene, renderer, cotangent(scene))
    for buffer in (renderer._coverage._slot_transmittance, renderer._coverage.slot_coverage):
        wp.to_torch(buffer).fill_(torch.nan)
    got = adjoint(scene, renderer, cotangent(scene))
    for name in GRADIENTS:
        assert torch.equal(getattr(got, name), getattr(want, name)), name


@sweep("value", [torch.nan, -torch.inf])
@sweep("point", [0, 4])
@sweep("covariance", [True, False])
@precisions
def test_a_path_that_is_not_finite_is_as_if_absent(
    value: float, point: int, covariance: bool, backend: Backend, dtype: torch.dtype
) -> None:
    settings = with_switches(SMALL, True, covariance)
    scene = random_scene(3, 4, 33, 50)
    points = scene.points.clone()
    points[1, point] = value
    broken, others = scene._replace(points=points), [0, 2, 3]
    rest = scene._replace(points=scene.points[others], color=scene.color[others], opacity=scene.opacity[others])
    renderer, adj_image = make_splat_renderer(scene, settings, backend, dtype), cotangent(scene)
    assert torch.equal(render(broken, renderer), render(rest, renderer))
    got, want = adjoint(broken, renderer, adj_image), adjoint(rest, renderer, adj_image)
    for name in ("points", "color", "opacity"):
        assert not getattr(got, name)[1].any(), name
        assert torch.equal(getattr(got, name)[others], getattr(want, name)), name
    assert torch.equal(got.background, want.background)


def test_one_renderer_serves_scenes_that_grow_and_shrink(backend: Backend) -> None:
    settings = Settings(5, 2, covariance_gradient=True)
    scenes = [random_scene(n, n, 33, 40, pieces) for n, pieces in [(1, 2), (30, 7), (3, 4), (60, 3), (0, 4), (2, 7)]]
    scenes.insert(3, scenes[2]._replace(points=3e3 * scenes[2].points))
    renderer = make_splat_renderer(scenes[0], settings, backend)
    for scene in scenes:
        assert min_margin(scene, settings) > 1e-10
        torch.testing.assert_close(render(scene, renderer), reference_image(scene, settings), rtol=0, atol=1e-9)
        got, want = adjoint(scene, renderer, cotangent(scene)), reference_gradients(scene, settings, cotangent(scene))
        for name in GRADIENTS:
            assert_grad_close(getattr(got, name), want[name], rtol=1e-8, atol=1e-9, name=name)


@precisions
def test_what_was_left_in_the_buffers_by_another_scene_does_not_count(backend: Backend, dtype: torch.dtype) -> None:
    settings = Settings(24, 12, covariance_gradient=True)
    scene, other = covered(2), random_scene(4, 40, 33, 40)
    used = make_splat_renderer(scene, settings, backend, dtype, transmittance_min=1e-4)
    adjoint(other, used, cotangent(other))
    fresh = make_splat_renderer(scene, settings, backend, dtype, transmittance_min=1e-4)
    got, want = (adjoint(scene, renderer, cotangent(scene)) for renderer in (used, fresh))
    for name in GRADIENTS:
        assert torch.equal(getattr(got, name), getattr(want, name)), name


@sweep(("height", "width"), [(33, 50), (16, 500), (500, 16)])
@sweep("covariance", [True, False])
def test_any_number_of_threads_gives_the_same_bits_and_so_does_a_second_call(
    height: int, width: int, covariance: bool
) -> None:
    settings = with_switches(Settings(17, 5), True, covariance)
    scene = random_scene(height, 70, height, width)
    runs = [
        everything(scene, make_splat_renderer(scene, settings, Backend(), torch.float32, threads=n)) for n in (1, 2, 3)
    ]
    renderer = make_splat_renderer(scene, settings, Backend(), torch.float32, threads=2)
    runs += [everything(scene, renderer), everything(scene, renderer)]
    for run in runs[1:]:
        for name, value in run.items():
            assert torch.equal(value, runs[0][name]), name


def everything(scene: SceneTensors, renderer: SplatRenderer) -> dict[str, Tensor]:
    """Return everything that a renderer computes."""
    got, step = adjoint(scene, renderer, cotangent(scene)), fit_step(scene, renderer, True)
    found = {"image": render(scene, renderer)}
    found |= {f"adjoint {name}": getattr(got, name) for name in GRADIENTS}
    return found | {f"step {field.name}": getattr(step, field.name) for field in fields(step)}


@sweep("seed", range(2))
def test_single_precision_agrees_with_double(seed: int, device: str) -> None:
    settings = Settings(32, 12)
    scene = random_scene(seed, 60, 150, 200)
    single = make_splat_renderer(scene, settings, Backend(device), torch.float32)
    double, adj_image = make_splat_renderer(scene, settings), cotangent(scene)
    # An alpha that rounding moves across the cut changes by 1 / 255.
    image = render(scene, single).cpu().double()
    assert_close_off_edges(image, render(scene, double), atol=1e-4, outlier_share=1e-3, outlier_atol=0.01)
    got, want = adjoint(scene, single, adj_image), adjoint(scene, double, adj_image)
    for name in GRADIENTS:
        assert_grad_close(getattr(got, name), getattr(want, name), rtol=2e-3, atol=0.0, name=name)


# What is given


def test_memory_in_another_order_is_read_and_written_as_well() -> None:
    scene = random_scene(5, 6, 33, 40)
    renderer = make_splat_renderer(scene, SMALL)
    want = adjoint(scene, renderer, cotangent(scene))
    turned = scene._replace(points=scene.points.transpose(0, 1).contiguous().transpose(0, 1))
    got = adjoint(turned, renderer, cotangent(scene))
    assert not turned.points.is_contiguous()
    assert torch.equal(got.points, want.points)


@sweep(
    ("point_count", "message"),
    [(3, "at least 2 curves of degree 3 a path, got 3 points"), (8, "S at least 1, for degree 3, got [2, 8, 2]")],
)
def test_a_path_needs_two_whole_pieces(point_count: int, message: str) -> None:
    scene = random_scene(1, 2, 20, 20)
    with pytest.raises(InputError, match=re.escape(message)):
        render(scene._replace(points=scene.points[:, :point_count]), make_splat_renderer(scene, SMALL))
