"""Adjoints of colour, opacity and background, the fused step, and exact removal costs."""

from __future__ import annotations

import numpy as np
import pytest
import torch
import warp as wp
from assertions import assert_grad_close, assert_grad_present, assert_same_direction
from backends import VECTOR, Backend
from oracles import (
    GRADIENTS,
    adjoint,
    chord_counts,
    cotangent,
    fit_step,
    inputs,
    make_renderer,
    precisions,
    reference_gradients,
    render,
    target_image,
)
from reference import removal_cost
from scenes import ZOO, SceneTensors, ZooCase, circle, degenerate_scene, random_scene, rectangle
from sweep import sweep

from warpvec.errors import InputError
from warpvec.kernels.compositing_adjoint import CANVAS_TERMS, TERMS, make_kernels
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.launch import Buffers, Launcher

PAINT = ("color", "opacity", "background")


def check_paint(scene: SceneTensors, renderer: ExactRenderer, rtol: float) -> None:
    adj_image = cotangent(scene)
    got = adjoint(scene, renderer, adj_image)
    want = reference_gradients(scene, renderer, adj_image)
    for name in PAINT:
        assert_grad_close(getattr(got, name), want[name], rtol=rtol, atol=1e-14, name=name)
        assert_grad_present(getattr(got, name), want[name], name, floor=1e-4)
        assert_same_direction(getattr(got, name), want[name], 1 - rtol, name)


@sweep("path_count", [1, 2, 63, 64, 65])
def test_paint_of_random_scenes(path_count: int, backend: Backend) -> None:
    scene = random_scene(path_count, path_count, 33, 31)
    check_paint(scene, make_renderer(scene, backend, threads=3), 1e-12)


@sweep(("height", "width"), [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (20, 16 * 33)])
def test_paint_at_every_border(height: int, width: int, backend: Backend) -> None:
    scene = degenerate_scene(height, 5 if width > 500 else 9, height, width)
    check_paint(scene, make_renderer(scene, backend, threads=3), 1e-12)


@sweep("case", [c for c in ZOO if len(c.scene.points)])
def test_paint_of_the_zoo(case: ZooCase, backend: Backend) -> None:
    # Lines without area have gradients of pure rounding, about 1e-15, and paths of 1e6 px are accurate to 1e-10.
    scene, renderer = case.scene, make_renderer(case.scene, backend)
    adj_image = cotangent(scene)
    got = adjoint(scene, renderer, adj_image)
    want = reference_gradients(scene, renderer, adj_image)
    reach = max(1.0, scene.points.abs().max().item() / 1e3)
    for name in PAINT:
        assert_grad_close(getattr(got, name), want[name], rtol=1e-12 * reach, atol=1e-13, name=name)


@precisions
def test_two_covers_in_closed_form(backend: Backend, dtype: torch.dtype) -> None:
    scene = random_scene(2, 2, 18, 35)._replace(points=rectangle(-50, -50, 90, 90).expand(2, 12, 2).contiguous())
    scene = scene._replace(opacity=torch.tensor([0.75, 0.5], dtype=torch.float64))
    got = adjoint(scene, make_renderer(scene, backend, dtype), torch.ones(18, 35, 3))
    pixels = 18 * 35
    lower = 0.75 * scene.color[0] + 0.25 * scene.background
    opacity = torch.stack([0.5 * (scene.color[0] - scene.background).sum(), (scene.color[1] - lower).sum()])
    # The sum over the pixels of a tile rounds once per addend in float32.
    rtol = 256 * torch.finfo(dtype).eps
    for value, want in [(got.color[0], 0.375), (got.color[1], 0.5), (got.background, 0.125)]:
        torch.testing.assert_close(
            value.double(), torch.full((3,), pixels * want, dtype=torch.float64), rtol=rtol, atol=0
        )
    torch.testing.assert_close(got.opacity.double(), pixels * opacity, rtol=rtol, atol=rtol * pixels)


@sweep("threshold", [0.0, 1e-4])
def test_what_is_hidden_gets_exactly_zero(backend: Backend, threshold: float) -> None:
    scene = random_scene(4, 8, 33, 50)
    scene = scene._replace(points=torch.cat([scene.points[:7], circle(25.0, 16.0, 80.0)[None]]))
    scene = scene._replace(opacity=torch.cat([scene.opacity[:7], torch.ones(1).double()]))
    got = adjoint(scene, make_renderer(scene, backend, torch.float32, transmittance_min=threshold), cotangent(scene))
    for name in ("points", "color", "opacity"):
        assert not getattr(got, name)[:7].any(), name
    assert not got.background.any() and got.color[7].all()


@precisions
def test_what_was_left_in_the_buffers_by_another_scene_does_not_count(backend: Backend, dtype: torch.dtype) -> None:
    shown, hidden = random_scene(4, 40, 33, 50), random_scene(5, 20, 33, 50)
    hidden = hidden._replace(points=torch.cat([hidden.points[:19], circle(25.0, 16.0, 80.0)[None]]))
    hidden = hidden._replace(opacity=torch.ones(20, dtype=torch.float64))
    renderer = make_renderer(shown, backend, dtype, transmittance_min=1e-4)
    adjoint(shown, renderer, cotangent(shown))
    got = adjoint(hidden, renderer, cotangent(hidden))
    want = adjoint(hidden, make_renderer(shown, backend, dtype, transmittance_min=1e-4), cotangent(hidden))
    for name in GRADIENTS:
        assert torch.equal(getattr(got, name), getattr(want, name)), name


@sweep(("height", "width"), [(1, 1), (33, 50), (17, 1037)])
@precisions
def test_fit_step_is_render_then_error_then_adjoint(
    height: int, width: int, backend: Backend, dtype: torch.dtype
) -> None:
    scene = random_scene(height, 12, height, width)
    renderer = make_renderer(scene, backend, dtype)
    difference = render(scene, renderer) - target_image(scene).to(dtype)
    want = adjoint(scene, renderer, 2 * difference / difference.numel())
    got = fit_step(scene, renderer)
    # Both add the same terms, with image adjoints that differ by rounding; cancellation magnifies that.
    rtol = 100 * torch.finfo(dtype).eps
    for name in GRADIENTS:
        assert_grad_close(getattr(got, name), getattr(want, name), rtol=rtol, atol=0.0, name=name)
    # The squared errors of a tile are added in the precision of the lanes.
    torch.testing.assert_close(got.loss.double(), difference.double().square().mean(), rtol=rtol, atol=0)
    assert got.removal_cost is None


@precisions
def test_asking_for_removal_costs_changes_nothing_else(backend: Backend, dtype: torch.dtype) -> None:
    scene = random_scene(6, 12, 33, 50)
    renderer = make_renderer(scene, backend, dtype)
    plain, asked = fit_step(scene, renderer), fit_step(scene, renderer, want_removal_cost=True)
    for name in (*GRADIENTS, "loss"):
        torch.testing.assert_close(getattr(asked, name), getattr(plain, name), rtol=1e-5, atol=1e-9)


@sweep("path_count", [1, 12, 65])
def test_removal_cost_is_the_rise_of_the_loss_without_the_path(path_count: int, backend: Backend) -> None:
    scene = random_scene(path_count, path_count, 33, 50)
    check_removal_cost(scene, backend)


@sweep("case", [c for c in ZOO if len(c.scene.points)])
def test_removal_costs_of_the_zoo(case: ZooCase) -> None:
    check_removal_cost(case.scene, VECTOR)


def check_removal_cost(scene: SceneTensors, backend: Backend) -> None:
    renderer = make_renderer(scene, backend)
    got = fit_step(scene, renderer, want_removal_cost=True).removal_cost
    counts = chord_counts(renderer._flattening, scene.points)
    want = removal_cost(*scene[:4], target_image(scene), counts)
    # The cost is a difference of losses of about 0.1, each a sum over the image.
    torch.testing.assert_close(got, want, rtol=1e-9, atol=1e-11)


def test_removal_costs_in_float32(backend: Backend) -> None:
    scene = random_scene(8, 40, 60, 70)
    exact = fit_step(scene, make_renderer(scene), want_removal_cost=True).removal_cost
    single = fit_step(scene, make_renderer(scene, backend, torch.float32), want_removal_cost=True).removal_cost
    # The cost is a difference of two sums as large as the largest entry.
    assert (single.double() - exact).abs().max() < 1e-5 * exact.abs().max()


def test_a_deep_stack(backend: Backend) -> None:
    scene = random_scene(10, 120, 16, 20)
    check_paint_close(scene, make_renderer(scene, backend))


def check_paint_close(scene: SceneTensors, renderer: ExactRenderer) -> None:
    adj_image = cotangent(scene)
    got, want = adjoint(scene, renderer, adj_image), reference_gradients(scene, renderer, adj_image)
    for name in PAINT:
        assert_grad_close(getattr(got, name), want[name], rtol=1e-12, atol=1e-14, name=name)


def test_opaque_paths_do_not_divide_by_zero(backend: Backend) -> None:
    # Recovering the colour behind a path from the image would divide by 1 - alpha.
    scene = random_scene(11, 20, 33, 50)._replace(opacity=torch.ones(20, dtype=torch.float64))
    check_paint_close(scene, make_renderer(scene, backend))


@sweep("row_count", [1, 31, 32, 33, 4095, 4096, 4097, 8 * 1536 + 5])
@precisions
def test_sums_over_all_tiles(row_count: int, backend: Backend, dtype: torch.dtype) -> None:
    lanes, device = make_lanes(backend.lane_width, wp.dtype_from_torch(dtype)), backend.device
    stage, launch = make_kernels(lanes, True, False), Launcher(device, 1)
    rows = torch.randn(row_count, TERMS, dtype=dtype, device=device)
    groups = wp.full((lanes.canvas_reducers, CANVAS_TERMS), np.nan, dtype=wp.float64, device=device)
    sums = torch.full((CANVAS_TERMS,), torch.nan, dtype=dtype, device=device)
    launch(stage.gather_tiles, lanes.canvas_threads, [wp.from_torch(rows), row_count, groups])
    capacity = [launch.capacity.overflow, launch.capacity.dropped_steps, launch.capacity.fits]
    launch(stage.gather_canvas, CANVAS_TERMS, [groups, lanes.dtype(0.5), *capacity, wp.from_torch(sums)])
    want = rows.cpu().double().sum(0)[:CANVAS_TERMS] * torch.tensor([1.0, 1.0, 1.0, 0.5])
    torch.testing.assert_close(sums.cpu().double(), want, rtol=torch.finfo(dtype).eps, atol=1e-12)


@pytest.mark.parametrize("part", [1, 3, 10])
@pytest.mark.parametrize("error", [RuntimeError("Failed to allocate"), InputError("scene", "is too large")], ids=str)
@pytest.mark.parametrize("backend", ["scalar", "cuda"], indirect=True)
def test_a_stack_without_memory_for_all_tiles_serves_some_at_a_time(
    part: int, error: Exception, backend: Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, entries = random_scene(12, 60, 60, 70), []
    whole, cut = make_renderer(scene, backend, threads=3), make_renderer(scene, backend, threads=3)
    want = fit_step(scene, whole, want_removal_cost=True)
    hits = whole._binning.tile_first_hit.numpy()[: whole.grid.count + 1]
    memory = max(int(np.diff(hits).max()) + 1, int(hits[-1]) // part)
    get = Buffers.get

    def get_stack(self: Buffers, name: str, shape: int | tuple[int, ...], dtype: object) -> wp.array:
        if name == "stack":
            assert isinstance(shape, int)
            entries.append(shape // (3 * TILE * TILE))
            if entries[-1] > memory:
                raise error
        return get(self, name, shape, dtype)

    monkeypatch.setattr(Buffers, "get", get_stack)
    for _ in range(2):
        got = fit_step(scene, cut, want_removal_cost=True)
        for name in (*GRADIENTS, "loss", "removal_cost"):
            assert torch.equal(getattr(got, name), getattr(want, name)), name
    assert entries[0] > memory >= entries[-1] and entries[-2:] == [entries[-1]] * 2  # it tries no more in vain
    memory = 2
    with pytest.raises(type(error)):
        fit_step(scene, make_renderer(scene, backend), want_removal_cost=True)


@precisions
def test_a_shift_moves_the_target_of_the_adjoints_and_not_of_the_loss(backend: Backend, dtype: torch.dtype) -> None:
    scene = random_scene(7, 12, 33, 50)
    renderer = make_renderer(scene, backend, dtype)
    target, drawn = target_image(scene), inputs(scene, renderer)
    shift = 0.2 * torch.randn(target.shape[:2], generator=torch.Generator().manual_seed(1), dtype=target.dtype)
    prepared = renderer.prepare_target(target, torch.ones_like(shift))
    renderer.change_shift(prepared, shift)
    plain = renderer.fit_step(drawn, renderer.prepare_target(target), True)
    want = renderer.fit_step(drawn, renderer.prepare_target(target + shift[..., None]), True)
    got = renderer.fit_step(drawn, prepared, True)
    assert torch.equal(got.loss, plain.loss)
    rtol = 100 * torch.finfo(dtype).eps
    for name in ("segments", "color", "opacity", "background", "removal_cost"):
        assert_grad_close(getattr(got, name).cpu(), getattr(want, name).cpu(), rtol=rtol, atol=0.0, name=name)
