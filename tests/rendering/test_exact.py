"""The exact renderer against the reference: images and gradients, degenerate paths, reproducible bits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import torch
from assertions import (
    assert_close_off_edges,
    assert_grad_close,
    assert_grad_present,
    assert_same_direction,
    finite_difference,
)
from backends import Backend
from oracles import (
    GRADIENTS,
    adjoint,
    cotangent,
    inputs,
    make_renderer,
    precisions,
    reference_gradients,
    reference_image,
    render,
    target_image,
)
from scenes import ZOO, SceneTensors, ZooCase, circle, degenerate_scene, figure_eight, random_scene
from sweep import sweep
from torch import Tensor

from warpvec.rendering.exact import ExactRenderer

SIZES = [(1, 1), (15, 16), (16, 17), (17, 15), (31, 33), (33, 31), (40, 1), (16, 130)]

EXACT = 1e-11
"""Tolerance in float64; the worst error seen is 5e-15, or 2e-11 for paths of 1e6 px, which get a larger tolerance."""

DIFFERENTIABLE = [case for case in ZOO if case.differentiable]
KINKED = [case for case in ZOO if not case.differentiable]

Maker = Callable[..., SceneTensors]


def reach(scene: SceneTensors) -> float:
    """Return the largest coordinate in thousands of pixels, at least 1: rounding moves edges in proportion to it."""
    return max(1.0, scene.points.abs().max().item() / 1e3) if len(scene.points) else 1.0


def check_image(scene: SceneTensors, renderer: ExactRenderer) -> None:
    image = render(scene, renderer)
    torch.testing.assert_close(image, reference_image(scene, renderer), rtol=0, atol=EXACT * reach(scene))


def check_gradients(scene: SceneTensors, renderer: ExactRenderer, rtol: float) -> None:
    adj_image = cotangent(scene)
    got = adjoint(scene, renderer, adj_image)
    want = reference_gradients(scene, renderer, adj_image)
    for name in GRADIENTS:
        # Sums that nearly cancel keep the rounding error of their addends, which are of order 1.
        assert_grad_close(getattr(got, name), want[name], rtol=rtol, atol=1e-13, name=name)
        assert_grad_present(getattr(got, name), want[name], name, floor=max(1e-6, 10 * rtol))
        if want[name].numel():
            assert_same_direction(getattr(got, name), want[name], 1 - rtol, name)


@sweep(("height", "width"), SIZES)
@sweep("make", [random_scene, degenerate_scene])
def test_image_at_every_border(make: Maker, height: int, width: int, backend: Backend) -> None:
    scene = make(height + width, 9, height, width)
    check_image(scene, make_renderer(scene, backend))


@sweep(("path_count", "segment_count"), [(0, 4), (1, 4), (2, 4), (63, 4), (64, 4), (65, 4), (9, 2), (9, 3), (65, 7)])
def test_image_of_any_number_of_paths_and_segments(path_count: int, segment_count: int) -> None:
    scene = random_scene(path_count, path_count, 33, 40, segment_count)
    check_image(scene, make_renderer(scene, threads=3))


@sweep("case", ZOO)
def test_image_of_the_zoo(case: ZooCase, backend: Backend) -> None:
    check_image(case.scene, make_renderer(case.scene, backend))


@sweep(("height", "width"), SIZES)
def test_gradients_at_every_border(height: int, width: int, backend: Backend) -> None:
    scene = random_scene(height + width, 9, height, width)
    check_gradients(scene, make_renderer(scene, backend), 1e-12)


@sweep("segment_count", [2, 3, 7])
def test_gradients_of_any_number_of_segments(segment_count: int) -> None:
    scene = random_scene(segment_count, 20, 33, 50, segment_count)
    check_gradients(scene, make_renderer(scene), 1e-12)


@sweep("seed", range(3))
def test_gradients_of_nearly_degenerate_paths(seed: int, backend: Backend) -> None:
    # An exactly degenerate path may be at a kink without a gradient; a millionth of a pixel away it has one.
    scene = degenerate_scene(seed, 9, 33, 50)
    scene = scene._replace(points=scene.points + 1e-6 * torch.randn_like(scene.points))
    # If an edge nearly lies in a row, its crossing is accurate to 1e-16 * 1e6, and less where paths are huge.
    check_gradients(scene, make_renderer(scene, backend), 1e-7)


@sweep("case", DIFFERENTIABLE)
def test_gradients_of_the_zoo(case: ZooCase, backend: Backend) -> None:
    check_gradients(case.scene, make_renderer(case.scene, backend), 1e-12 * reach(case.scene))


@sweep("case", KINKED)
@precisions
def test_gradients_at_a_kink_are_finite_and_bounded(case: ZooCase, backend: Backend, dtype: torch.dtype) -> None:
    scene, adj_image = case.scene, cotangent(case.scene)
    got = adjoint(scene, make_renderer(scene, backend, dtype), adj_image)
    # Moving a point by 1 px sweeps at most 1 square pixel per pixel of the path's length.
    length = (scene.points.roll(-1, 1) - scene.points).norm(dim=-1).sum()
    assert all(getattr(got, name).isfinite().all() for name in GRADIENTS)
    assert got.points.abs().max() <= length * adj_image.abs().sum(-1).max()


@sweep("make", [random_scene, degenerate_scene])
def test_finite_differences(make: Maker, backend: Backend) -> None:
    scene = make(17, 4, 20, 35)
    scene = scene._replace(points=scene.points + 1e-2 * torch.randn_like(scene.points))
    renderer, adj_image = make_renderer(scene, backend), cotangent(scene)
    got = adjoint(scene, renderer, adj_image)
    near = (scene.points.abs().amax((1, 2)) < 500).nonzero()[:, 0].tolist()
    entries = {
        "points": [24 * row + entry for row in near for entry in (0, 5, 10, 15, 20)],
        "color": range(0, 12, 2),
        "opacity": range(4),
        "background": range(3),
    }
    assert len(near) > 1
    for name, some in entries.items():
        move = functional(scene, renderer, adj_image, name)
        want = finite_difference(move, getattr(scene, name), 1e-6, some)
        # The image is quadratic in an edge's move, with kinks at pixel borders: the error is 1e-6 of the curvature.
        assert_grad_close(getattr(got, name).flatten()[list(some)], want, rtol=1e-5, atol=1e-7, name=name)


def functional(
    scene: SceneTensors, renderer: ExactRenderer, adj_image: Tensor, name: str
) -> Callable[[Tensor], Tensor]:
    """Return <image, adj_image> as a function of one input."""
    return lambda value: (render(scene._replace(**{name: value}), renderer) * adj_image).sum()


@sweep("reverse", [False, True])
def test_each_lobe_of_a_figure_eight_grows_outward(reverse: bool, backend: Backend) -> None:
    eight = figure_eight(6.3, 5.2, 41.7, 27.9)
    path = torch.cat([eight[:1], eight[1:].flip(0)]) if reverse else eight
    scene = random_scene(1, 1, 33, 50)._replace(points=path[None], opacity=torch.ones(1).double())
    scene = scene._replace(color=torch.ones(1, 3).double(), background=torch.zeros(3).double())
    renderer = make_renderer(scene, backend)
    brighter = torch.ones(33, 50, 3, dtype=torch.float64)
    got = adjoint(scene, renderer, brighter).points[0, ::3, 0]
    want = finite_difference(functional(scene, renderer, brighter, "points"), scene.points, 1e-6, range(0, 24, 6))
    torch.testing.assert_close(got, want, rtol=1e-5, atol=1e-7)
    # Outward is left for the anchors on the left and right for those on the right, for either winding of the lobe.
    assert (got * (path[::3, 0] - 24.0) > 0).all()


def test_inside_a_double_loop_more_winding_covers_no_more(backend: Backend) -> None:
    # One circle inside another, both run in the same direction: the winding is 2 inside the inner circle and 1 around
    # it, so its edge is invisible.
    outer, inner = circle(24.0, 16.0, 14.2), circle(24.0, 16.0, 6.1)
    start, other = outer[:1], inner[:1]
    there = torch.cat([start, start + (other - start) / 3, start + 2 * (other - start) / 3])
    back = torch.cat([other, other + (start - other) / 3, other + 2 * (start - other) / 3])
    path = torch.cat([outer, there, inner, back])
    scene = random_scene(1, 1, 33, 50)._replace(points=path[None])
    got = adjoint(scene, make_renderer(scene, backend), cotangent(scene)).points[0]
    inner_rows = range(16, 27)
    # The bridge between the circles crosses the ring of winding 1, where its two edges cancel.
    assert got[list(inner_rows)].abs().max() < 1e-12
    assert got[1:12].norm(dim=1).min() > 1e-3


@sweep("value", [torch.nan, torch.inf, -torch.inf, 1e8, -1e30])
@sweep("point", [3, 4])
@precisions
def test_a_path_that_is_not_finite_is_as_if_absent(
    value: float, point: int, backend: Backend, dtype: torch.dtype
) -> None:
    scene = random_scene(3, 4, 33, 50)
    points = scene.points.clone()
    points[1, point] = value
    broken, others = scene._replace(points=points), [0, 2, 3]
    rest = scene._replace(points=scene.points[others], color=scene.color[others], opacity=scene.opacity[others])
    renderer, adj_image = make_renderer(scene, backend, dtype), cotangent(scene)
    assert torch.equal(render(broken, renderer), render(rest, renderer))
    got, want = adjoint(broken, renderer, adj_image), adjoint(rest, renderer, adj_image)
    for name in ("points", "color", "opacity"):
        assert not getattr(got, name)[1].any(), name
        assert torch.equal(getattr(got, name)[others], getattr(want, name)), name
    assert torch.equal(got.background, want.background)


@precisions
@sweep("tiny", [1e-40, 1e-310])
def test_denormal_coordinates_count_as_zero(tiny: float, backend: Backend, dtype: torch.dtype) -> None:
    # Dividing by a denormal gives infinity, and infinity times a distance of zero is NaN.
    scene = random_scene(3, 1, 33, 50)
    points = circle(9.0, 9.0, 9.0)
    points[6, 0], points[5, 0], points[7, 0] = 0.0, tiny, -tiny
    points[8:10] = torch.tensor([[tiny, tiny], [0.0, tiny]], dtype=torch.float64)
    scene = scene._replace(points=points[None])
    flat = scene._replace(points=torch.where(points.abs() < 1e-30, 0.0, points)[None])
    renderer = make_renderer(scene, backend, dtype)
    torch.testing.assert_close(render(scene, renderer), render(flat, renderer), rtol=0, atol=8 * torch.finfo(dtype).eps)
    assert all(getattr(adjoint(scene, renderer, cotangent(scene)), name).isfinite().all() for name in GRADIENTS)


def test_one_renderer_serves_scenes_that_grow_and_shrink(backend: Backend) -> None:
    scenes = [
        random_scene(n, n, 33, 50, segments) for n, segments in [(1, 2), (20, 7), (3, 4), (45, 3), (0, 4), (2, 7)]
    ]
    # A path as large as a hundred canvases has the maximum number of chords.
    scenes.insert(3, scenes[2]._replace(points=3e3 * scenes[2].points))
    renderer = make_renderer(scenes[0], backend)
    for scene in scenes:
        check_image(scene, renderer)
        check_gradients(scene, renderer, 1e-11 * reach(scene))


@sweep(("height", "width"), [(33, 50), (16, 2100), (2100, 16)])
def test_any_number_of_threads_gives_the_same_bits_and_so_does_a_second_call(height: int, width: int) -> None:
    scene = random_scene(height, 150, height, width)
    runs = [everything(scene, make_renderer(scene, Backend(), torch.float32, threads=threads)) for threads in (1, 2, 3)]
    renderer = make_renderer(scene, Backend(), torch.float32, threads=2)
    runs += [everything(scene, renderer), everything(scene, renderer)]
    for run in runs[1:]:
        for name, value in run.items():
            assert torch.equal(value, runs[0][name]), name


def everything(scene: SceneTensors, renderer: ExactRenderer) -> dict[str, Tensor]:
    """Return everything that a renderer computes."""
    got = adjoint(scene, renderer, cotangent(scene))
    step = renderer.fit_step(inputs(scene, renderer), renderer.prepare_target(target_image(scene)), True)
    found = {"image": render(scene, renderer)}
    found |= {f"adjoint {name}": getattr(got, name) for name in GRADIENTS}
    values = {field.name: getattr(step, field.name) for field in fields(step)}
    return found | {f"step {name}": value for name, value in values.items() if value is not None}


@sweep("seed", range(3))
def test_float32_agrees_with_float64(seed: int, device: str) -> None:
    scene = random_scene(seed, 200, 300, 400)
    single = make_renderer(scene, Backend(device), torch.float32)
    double, adj_image = make_renderer(scene), cotangent(scene)
    # A vertex at 400 px is accurate to 3e-5 px, which changes a pixel's coverage by as much, and by 5e-5 for several
    # paths (the worst seen). If a count of chords differs by one, an edge may move by part of the chord tolerance.
    assert_close_off_edges(
        render(scene, single).cpu().double(),
        render(scene, double),
        atol=1e-4,
        outlier_share=1e-3,
        outlier_atol=0.05,
    )
    got, want = adjoint(scene, single, adj_image), adjoint(scene, double, adj_image)
    for name in GRADIENTS:
        assert_grad_close(getattr(got, name), getattr(want, name), rtol=2e-4, atol=0.0, name=name)
