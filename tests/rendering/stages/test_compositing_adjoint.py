"""Adjoints of colour, opacity and background, the fused step, and the exact importance of a path."""

from __future__ import annotations

import numpy as np
import pytest
import torch
import warp as wp
from assertions import assert_grad_close, assert_grad_present, assert_same_direction
from oracles import (
    GRADIENTS,
    adjoint,
    chord_counts,
    cotangent,
    inputs,
    lane_widths,
    make_renderer,
    precisions,
    reference_gradients,
    render,
    target_image,
)
from reference import importance
from scenes import ZOO, SceneTensors, ZooCase, circle, degenerate_scene, random_scene, rectangle

from warpvec.kernels.compositing_adjoint import CANVAS_TERMS, TERMS, make_kernels
from warpvec.kernels.lanes import make_lanes
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.launch import Launcher
from warpvec.rendering.tile_renderer import Adjoints

PAINT = ("color", "opacity", "background")


def fit_step(scene: SceneTensors, renderer: ExactRenderer, removal_cost: bool = False) -> Adjoints:
    target = renderer.prepare_target(target_image(scene))
    return renderer.fit_step(*inputs(scene, renderer), target, removal_cost)


def check_paint(scene: SceneTensors, renderer: ExactRenderer, rtol: float) -> None:
    adj_image = cotangent(scene)
    got = adjoint(scene, renderer, adj_image)
    want = reference_gradients(scene, renderer, adj_image)
    for name in PAINT:
        assert_grad_close(getattr(got, name), want[name], rtol=rtol, atol=1e-14, name=name)
        assert_grad_present(getattr(got, name), want[name], name, floor=1e-4)
        assert_same_direction(getattr(got, name), want[name], 1 - rtol, name)


@pytest.mark.parametrize("path_count", [1, 2, 63, 64, 65])
@lane_widths
def test_paint_of_random_scenes(path_count: int, lane_width: int) -> None:
    scene = random_scene(path_count, path_count, 33, 31)
    check_paint(scene, make_renderer(scene, lane_width, threads=3), 1e-12)


@pytest.mark.parametrize(("height", "width"), [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (20, 16 * 65)])
@lane_widths
def test_paint_at_every_border(height: int, width: int, lane_width: int) -> None:
    scene = degenerate_scene(height, 9, height, width)
    check_paint(scene, make_renderer(scene, lane_width, threads=3), 1e-12)


@pytest.mark.parametrize("case", [c for c in ZOO if len(c.scene.points)], ids=lambda case: case.name)
@lane_widths
def test_paint_of_the_zoo(case: ZooCase, lane_width: int) -> None:
    # The lines of no area have gradients of rounding alone, of 1e-15, and paths of 1e6 px are placed to 1e-10.
    scene, renderer = case.scene, make_renderer(case.scene, lane_width)
    adj_image = cotangent(scene)
    got = adjoint(scene, renderer, adj_image)
    want = reference_gradients(scene, renderer, adj_image)
    reach = max(1.0, scene.points.abs().max().item() / 1e3)
    for name in PAINT:
        assert_grad_close(getattr(got, name), want[name], rtol=1e-12 * reach, atol=1e-13, name=name)


@lane_widths
@precisions
def test_two_covers_in_closed_form(lane_width: int, dtype: torch.dtype) -> None:
    scene = random_scene(2, 2, 18, 35)._replace(points=rectangle(-50, -50, 90, 90).expand(2, 12, 2).contiguous())
    scene = scene._replace(opacity=torch.tensor([0.75, 0.5], dtype=torch.float64))
    got = adjoint(scene, make_renderer(scene, lane_width, dtype), torch.ones(18, 35, 3))
    pixels = 18 * 35
    lower = 0.75 * scene.color[0] + 0.25 * scene.background
    opacity = torch.stack([0.5 * (scene.color[0] - scene.background).sum(), (scene.color[1] - lower).sum()])
    # A sum over the pixels of a tile column by column: float32 rounds it once an addend.
    rtol = 256 * torch.finfo(dtype).eps
    for value, want in [(got.color[0], 0.375), (got.color[1], 0.5), (got.background, 0.125)]:
        torch.testing.assert_close(
            value.double(), torch.full((3,), pixels * want, dtype=torch.float64), rtol=rtol, atol=0
        )
    torch.testing.assert_close(got.opacity.double(), pixels * opacity, rtol=rtol, atol=rtol * pixels)


@lane_widths
@pytest.mark.parametrize("threshold", [0.0, 1e-4])
def test_what_is_hidden_gets_exactly_zero(lane_width: int, threshold: float) -> None:
    scene = random_scene(4, 8, 33, 50)
    scene = scene._replace(points=torch.cat([scene.points[:7], circle(25.0, 16.0, 80.0)[None]]))
    scene = scene._replace(opacity=torch.cat([scene.opacity[:7], torch.ones(1).double()]))
    got = adjoint(scene, make_renderer(scene, lane_width, torch.float32, transmittance_min=threshold), cotangent(scene))
    for name in ("points", "color", "opacity"):
        assert not getattr(got, name)[:7].any(), name
    assert not got.background.any() and got.color[7].all()


@lane_widths
@precisions
def test_what_was_left_in_the_buffers_by_another_scene_does_not_count(lane_width: int, dtype: torch.dtype) -> None:
    shown, hidden = random_scene(4, 40, 33, 50), random_scene(5, 20, 33, 50)
    hidden = hidden._replace(points=torch.cat([hidden.points[:19], circle(25.0, 16.0, 80.0)[None]]))
    hidden = hidden._replace(opacity=torch.ones(20, dtype=torch.float64))
    renderer = make_renderer(shown, lane_width, dtype, transmittance_min=1e-4)
    adjoint(shown, renderer, cotangent(shown))
    got = adjoint(hidden, renderer, cotangent(hidden))
    want = adjoint(hidden, make_renderer(shown, lane_width, dtype, transmittance_min=1e-4), cotangent(hidden))
    for name in GRADIENTS:
        assert torch.equal(getattr(got, name), getattr(want, name)), name


@pytest.mark.parametrize(("height", "width"), [(1, 1), (33, 50), (17, 1037)])
@lane_widths
@precisions
def test_fit_step_is_render_then_error_then_adjoint(
    height: int, width: int, lane_width: int, dtype: torch.dtype
) -> None:
    scene = random_scene(height, 12, height, width)
    renderer = make_renderer(scene, lane_width, dtype)
    difference = render(scene, renderer) - target_image(scene).to(dtype)
    want = adjoint(scene, renderer, 2 * difference / difference.numel())
    got = fit_step(scene, renderer)
    # Both run the same sums on image adjoints that differ by a rounding; sums of both signs magnify it.
    rtol = 100 * torch.finfo(dtype).eps
    for name in GRADIENTS:
        assert_grad_close(getattr(got, name), getattr(want, name), rtol=rtol, atol=0.0, name=name)
    # The squares of a tile are added in the precision of the lanes.
    torch.testing.assert_close(got.loss.double(), difference.double().square().mean(), rtol=rtol, atol=0)
    assert got.removal_cost is None


@lane_widths
@precisions
def test_asking_for_removal_changes_nothing_else(lane_width: int, dtype: torch.dtype) -> None:
    scene = random_scene(6, 12, 33, 50)
    renderer = make_renderer(scene, lane_width, dtype)
    plain, asked = fit_step(scene, renderer), fit_step(scene, renderer, removal_cost=True)
    for name in (*GRADIENTS, "loss"):
        torch.testing.assert_close(getattr(asked, name), getattr(plain, name), rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("path_count", [1, 12, 65])
@lane_widths
def test_removal_is_what_rendering_without_the_path_loses(path_count: int, lane_width: int) -> None:
    scene = random_scene(path_count, path_count, 33, 50)
    check_removal(scene, lane_width)


@pytest.mark.parametrize("case", [c for c in ZOO if len(c.scene.points)], ids=lambda case: case.name)
def test_removal_in_the_zoo(case: ZooCase) -> None:
    check_removal(case.scene, 16)


def check_removal(scene: SceneTensors, lane_width: int) -> None:
    renderer = make_renderer(scene, lane_width)
    got = fit_step(scene, renderer, removal_cost=True).removal_cost
    counts = chord_counts(renderer._flattening, scene.points)
    want = importance(*scene[:4], target_image(scene), counts)
    # Differences of losses of about 0.1, each a sum over the image.
    torch.testing.assert_close(got, want, rtol=1e-9, atol=1e-11)


@lane_widths
def test_removal_in_float32(lane_width: int) -> None:
    scene = random_scene(8, 40, 60, 70)
    exact = fit_step(scene, make_renderer(scene), removal_cost=True).removal_cost
    single = fit_step(scene, make_renderer(scene, lane_width, torch.float32), removal_cost=True).removal_cost
    # It is the difference of two sums of the size of the largest entry.
    assert (single.double() - exact).abs().max() < 1e-5 * exact.abs().max()


@lane_widths
def test_a_deep_stack(lane_width: int) -> None:
    scene = random_scene(10, 300, 16, 20)
    check_paint_close(scene, make_renderer(scene, lane_width))


def check_paint_close(scene: SceneTensors, renderer: ExactRenderer) -> None:
    adj_image = cotangent(scene)
    got, want = adjoint(scene, renderer, adj_image), reference_gradients(scene, renderer, adj_image)
    for name in PAINT:
        assert_grad_close(getattr(got, name), want[name], rtol=1e-12, atol=1e-14, name=name)


@lane_widths
def test_opaque_paths_do_not_divide_by_zero(lane_width: int) -> None:
    # Recovering what lies behind from the image would divide by 1 - alpha.
    scene = random_scene(11, 20, 33, 50)._replace(opacity=torch.ones(20, dtype=torch.float64))
    check_paint_close(scene, make_renderer(scene, lane_width))


@pytest.mark.parametrize("row_count", [1, 31, 32, 33, 4095, 4096, 4097, 8 * 1536 + 5])
@lane_widths
@precisions
def test_sums_over_all_tiles(row_count: int, lane_width: int, dtype: torch.dtype) -> None:
    lanes = make_lanes(lane_width, wp.dtype_from_torch(dtype))
    stage, launch = make_kernels(lanes, True, False), Launcher("cpu", 1)
    rows = torch.randn(row_count, TERMS, dtype=dtype)
    groups = wp.full((lanes.canvas_reducers, CANVAS_TERMS), np.nan, dtype=wp.float64, device="cpu")
    sums = torch.full((CANVAS_TERMS,), torch.nan, dtype=dtype)
    launch(stage.gather_tiles, lanes.canvas_threads, [wp.from_torch(rows), row_count, groups])
    capacity = [launch.capacity.overflow, launch.capacity.dropped_steps, launch.capacity.fits]
    launch(stage.gather_canvas, CANVAS_TERMS, [groups, lanes.dtype(0.5), *capacity, wp.from_torch(sums)])
    want = rows.double().sum(0)[:CANVAS_TERMS] * torch.tensor([1.0, 1.0, 1.0, 0.5])
    torch.testing.assert_close(sums.double(), want, rtol=torch.finfo(dtype).eps, atol=1e-12)
