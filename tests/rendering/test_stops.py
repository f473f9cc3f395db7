"""Gradients of several stops: the reference, finite differences, resvg, and stops that are degenerate."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
import torch
from assertions import assert_grad_close, assert_grad_present, check_gradients
from backends import Backend
from compound import scene_of_loops
from exact_renderers import HEIGHT, WIDTH, in_float32, make_renderer
from paints import (
    STOP_VALUES,
    VALUES,
    painted,
    painted_scene,
    reference_image,
    stop_values_of,
    striped,
    striped_scene,
    with_stop_values,
)
from reference import mean_squared_error
from scenes import circle, rectangle
from sweep import sweep
from torch import Tensor

import warpvec
from warpvec.geometry.paints.registry import ELLIPTIC, FLAT, LINEAR, RADIAL
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import Stops
from warpvec.rendering.operator import _VALUES, _inputs
from warpvec.rendering.tile_renderer import Adjoints

NAMES = (*VALUES, *STOP_VALUES)

MIXED = (LINEAR, ELLIPTIC, FLAT, RADIAL, ELLIPTIC)


def leaves_of(scene: Scene) -> list[Tensor]:
    return [value.clone().requires_grad_() for value in stop_values_of(scene)]


def cotangent() -> Tensor:
    return torch.randn(HEIGHT, WIDTH, 3, dtype=torch.float64)


def check_adjoints(got: Adjoints, loss: Tensor, leaves: list[Tensor], tolerance: float = 1e-11) -> None:
    """Compare the adjoints with those of ``loss`` by autograd."""
    for name, want in zip(NAMES, torch.autograd.grad(loss, leaves, materialize_grads=True), strict=True):
        assert_grad_close(getattr(got, name), want, rtol=tolerance, atol=tolerance * 0.1, name=name)


def check_against_reference(scene: Scene, backend: Backend, **settings: Any) -> Adjoints:
    renderer, leaves, adj_image = make_renderer(backend, **settings), leaves_of(scene), cotangent()
    image = renderer.render(scene.to(backend.device)).cpu()
    want = reference_image(with_stop_values(scene, leaves), renderer)
    torch.testing.assert_close(image, want.detach(), rtol=0, atol=1e-12)
    got = renderer.adjoint(scene.to(backend.device), adj_image.to(backend.device))
    check_adjoints(got, (want * adj_image).sum(), leaves)
    return got


@sweep(("seed", "kinds"), [*enumerate([(LINEAR,), (RADIAL,), (ELLIPTIC,)]), *((k, MIXED) for k in range(2))])
def test_image_and_adjoints_are_those_of_the_reference(seed: int, kinds: tuple[int, ...], backend: Backend) -> None:
    got = check_against_reference(striped_scene(seed, 9, HEIGHT, WIDTH, kinds), backend)
    for name in ("inner_color", "offset", "stop_opacity", "geometry"):
        assert getattr(got, name).abs().max() > 1e-3, name


def opaque_stack() -> Scene:
    """Return paths under, between and over two that cover all; the lower one has a stop that lets light through."""
    loops = [[circle(x, 16.2, 13.4)] for x in (9.3, 25.1, 40.6)]
    cover, half = [rectangle(-20.3, -20.1, 70.2, 60.4)], [rectangle(15.2, -20.1, 70.2, 60.4)]
    kinds = (RADIAL, LINEAR, ELLIPTIC, RADIAL, FLAT)
    scene = striped(painted(scene_of_loops([loops[0], cover, loops[1], half, loops[2]]), kinds))
    opacity = torch.ones_like(scene.gradients.stops.opacity)
    opacity[1, 1:] = 0.5
    stops = replace(scene.gradients.stops, opacity=opacity)
    paints = replace(scene.gradients, stops=stops)
    return replace(scene, gradients=paints, opacity=torch.tensor([0.7, 1.0, 1.0, 1.0, 0.6], dtype=torch.float64))


def test_only_what_opaque_stops_hide_is_left_out(backend: Backend) -> None:
    scene, adj_image = opaque_stack().to(backend.device), cotangent().to(backend.device)
    check_against_reference(opaque_stack(), backend)
    all_drawn, few_drawn = (make_renderer(backend, transmittance_min=least) for least in (0.0, 1e-4))
    torch.testing.assert_close(few_drawn.render(scene), all_drawn.render(scene), rtol=0, atol=1e-15)
    want, got = all_drawn.adjoint(scene, adj_image), few_drawn.adjoint(scene, adj_image)
    for name in ("color", "background", "end_color", "inner_color", "offset", "breadth"):
        torch.testing.assert_close(getattr(got, name), getattr(want, name), rtol=1e-12, atol=1e-13)
    assert got.whole_color[0].all()  # seen through the translucent stop


@sweep("want_removal_cost", [False, True])
def test_a_fused_step_is_that_of_the_reference(want_removal_cost: bool, backend: Backend) -> None:
    scene, renderer = striped_scene(5, 6, HEIGHT, WIDTH), make_renderer(backend)
    target, leaves = torch.rand(HEIGHT, WIDTH, 3, dtype=torch.float64), leaves_of(scene)
    got = renderer.fit_step(scene.to(backend.device), renderer.prepare_target(target), want_removal_cost)
    loss = mean_squared_error(reference_image(with_stop_values(scene, leaves), renderer), target)
    check_adjoints(got, loss, leaves)
    torch.testing.assert_close(got.loss.cpu(), loss.detach(), rtol=1e-12, atol=0)
    if want_removal_cost:
        rests = [[other for other in range(len(scene)) if other != row] for row in range(len(scene))]
        errors = [mean_squared_error(reference_image(scene, renderer, rest), target) for rest in rests]
        torch.testing.assert_close(got.removal_cost.cpu(), torch.stack(errors) - loss.detach(), rtol=0, atol=1e-13)


NAN, INF = math.nan, math.inf
ODD_GEOMETRY: dict[str, tuple[int, tuple[float, float, float, float, float]]] = {
    "equal ends": (LINEAR, (20.3, 11.2, 20.3, 11.2, 0.0)),
    "radius 0": (RADIAL, (20.3, 11.2, 0.0, 0.0, 0.0)),
    "no axis": (ELLIPTIC, (20.3, 11.2, 0.0, 0.0, 5.0)),
    "no breadth": (ELLIPTIC, (20.3, 11.2, 5.0, 0.0, 0.0)),
    "an axis that is no number": (ELLIPTIC, (20.3, 11.2, NAN, 2.0, 4.0)),
    "an infinite breadth": (ELLIPTIC, (20.3, 11.2, 3.0, 2.0, INF)),
    "a thin ellipse": (ELLIPTIC, (24.2, 16.3, 21.0, 5.0, 0.02)),
    "centred on a pixel": (ELLIPTIC, (24.5, 16.5, 9.3, 2.0, 3.0)),
    "a radial one on a pixel": (RADIAL, (24.5, 16.5, 9.3, 0.0, 0.0)),
    "huge": (ELLIPTIC, (1e4, -2e4, 2.3e4, 1e4, 2e4)),
}


@sweep("name", ODD_GEOMETRY)
def test_an_odd_geometry_is_drawn_as_by_the_reference(name: str, backend: Backend) -> None:
    kind, geometry = ODD_GEOMETRY[name]
    scene = three_discs()
    paints = scene.gradients.map(Tensor.clone)
    numbers = torch.tensor(geometry, dtype=torch.float64)
    paints.kind[1], paints.geometry[1], paints.stops.breadth[1] = kind, numbers[:4], numbers[4]
    check_against_reference(replace(scene, gradients=paints), backend)


def three_discs() -> Scene:
    loops = [[circle(x, y, 12.3)] for x, y in ((15.1, 13.2), (24.7, 16.1), (35.4, 20.3))]
    return striped(painted(scene_of_loops(loops), (FLAT, LINEAR, RADIAL)))


ODD_OFFSETS = {
    "equal": (0.2, 0.5, 0.5, 0.9),
    "all equal": (0.4, 0.4, 0.4, 0.4),
    "out of order": (0.6, 0.2, 0.9, 0.3),
    "beyond the ends": (-0.5, 0.3, 1.2, 2.0),
    "all at the start": (0.0, 0.0, 0.0, 0.0),
    "all at the end": (1.0, 1.0, 1.0, 1.0),
    "close": (0.2, 0.5, 0.5 + 1e-8, 0.9),
}


@sweep("name", ODD_OFFSETS)
@sweep("kind", [LINEAR, ELLIPTIC])
def test_odd_offsets_are_drawn_as_by_the_reference(name: str, kind: int, backend: Backend) -> None:
    scene = three_discs()
    paints = scene.gradients.map(Tensor.clone)
    paints.kind[1], paints.stops.count[1] = kind, 4
    paints.stops.offset[1, :4] = torch.tensor(ODD_OFFSETS[name], dtype=torch.float64)
    if name == "close":  # no derivative, as for a jump: the reference has a huge one
        renderer = make_renderer(backend)
        image = renderer.render(replace(scene, gradients=paints).to(backend.device)).cpu()
        torch.testing.assert_close(image, reference_image(replace(scene, gradients=paints), renderer))
        return
    check_against_reference(replace(scene, gradients=paints), backend)


@sweep("kinds", [(LINEAR,), (RADIAL,), (LINEAR, RADIAL, FLAT)])
def test_two_opaque_stops_at_the_ends_are_the_gradient_without_stops(kinds: tuple[int, ...], backend: Backend) -> None:
    bare, renderer = painted_scene(3, 8, HEIGHT, WIDTH, kinds), make_renderer(backend)
    scene = replace(bare, gradients=replace(bare.gradients, stops=Stops.two(bare.color)))
    assert scene.gradients.without_plain_stops().stops is None
    bare, scene, adj_image = bare.to(backend.device), scene.to(backend.device), cotangent().to(backend.device)
    torch.testing.assert_close(renderer.render(scene), renderer.render(bare), rtol=0, atol=1e-13)
    got, want = renderer.adjoint(scene, adj_image), renderer.adjoint(bare, adj_image)
    for name in (*VALUES, "whole_color"):
        torch.testing.assert_close(getattr(got, name), getattr(want, name), rtol=1e-11, atol=1e-11)


@sweep("lane_width", [16, 1])
def test_the_number_of_threads_changes_no_bit(lane_width: int) -> None:
    scene, target = in_float32(striped_scene(4, 12, HEIGHT, WIDTH)), torch.rand(HEIGHT, WIDTH, 3)
    results = []
    for threads in (1, 2, 3):
        renderer = make_renderer(Backend("cpu", lane_width), torch.float32, threads=threads)
        step = renderer.fit_step(scene, renderer.prepare_target(target), True)
        results.append([renderer.render(scene), *(v for v in vars(step).values() if v is not None)])
    for other in results[1:]:
        assert all(map(torch.equal, results[0], other))


def test_float32_is_near_the_reference(backend: Backend) -> None:
    scene, adj_image = striped_scene(1, 8, HEIGHT, WIDTH), cotangent()
    renderer, leaves = make_renderer(backend, torch.float32), leaves_of(scene)
    got = renderer.adjoint(in_float32(scene).to(backend.device), adj_image.float().to(backend.device))
    want = reference_image(with_stop_values(scene, leaves), renderer)
    assert (renderer.render(in_float32(scene).to(backend.device)).cpu() - want).abs().max() < 1e-4
    gradients = torch.autograd.grad((want * adj_image).sum(), leaves)
    for name, gradient in zip(NAMES, gradients, strict=True):
        assert_grad_close(getattr(got, name), gradient, rtol=1e-3, atol=0, name=name)


def drawing(scene: Scene, height: int, width: int, alpha: bool = False) -> Any:
    """Return ``warpvec.render`` as a function of the ten tensors."""
    return lambda *values: warpvec.render(with_stop_values(scene, values), height, width, alpha=alpha)


@sweep("alpha", [False, True])
def test_gradcheck(alpha: bool) -> None:
    loops = [[circle(6.2, 4.6, 4.1, 2)], [circle(11.1, 3.7, 5.3, 3)]]
    scene = striped(painted(scene_of_loops(loops), (LINEAR, ELLIPTIC)))
    check_gradients(drawing(scene, 9, 18, alpha), leaves_of(scene))


@sweep("name", STOP_VALUES)
def test_a_value_of_the_stops_alone_may_ask_for_a_derivative(name: str) -> None:
    scene = striped_scene(4, 3, HEIGHT, WIDTH)
    values = stop_values_of(scene)
    place = NAMES.index(name)
    values[place] = values[place].clone().requires_grad_()
    warpvec.render(with_stop_values(scene, values), HEIGHT, WIDTH).square().sum().backward()
    assert_grad_present(values[place].grad, values[place].grad, name)


def test_opcheck() -> None:
    operators, image = torch.ops.warpvec, torch.rand(HEIGHT, WIDTH, 3, dtype=torch.float64)
    plain = _inputs(striped_scene(6, 3, HEIGHT, WIDTH))
    leaves = [*(value.clone().requires_grad_() for value in plain[:_VALUES]), *plain[_VALUES:]]
    torch.library.opcheck(operators.render.default, (leaves, 0, HEIGHT, WIDTH, "exact", 1, "{}"))
    torch.library.opcheck(operators.render_adjoint.default, (plain, image, 0, "exact", 1, "{}"))


def test_a_scene_with_stops_is_kept_by_everything_that_takes_it_apart() -> None:
    scene = striped_scene(2, 5, HEIGHT, WIDTH)
    want = warpvec.render(scene, HEIGHT, WIDTH)
    again = Scene.from_dict(scene.to_dict())
    parts = scene.prefix(2).joined(scene.select(torch.tensor([2, 3, 4])))
    for other in (again, parts, scene.copied(), scene.scaled(2.0).scaled(0.5), scene.moved(3.0, -2.0).moved(-3.0, 2.0)):
        torch.testing.assert_close(warpvec.render(other, HEIGHT, WIDTH), want, rtol=0, atol=1e-12)


def test_paths_with_stops_join_paths_without() -> None:
    bare, scene = painted_scene(1, 4, HEIGHT, WIDTH), striped_scene(2, 3, HEIGHT, WIDTH)
    both = bare.joined(scene)
    torch.testing.assert_close(
        warpvec.render(both.prefix(4), HEIGHT, WIDTH), warpvec.render(bare, HEIGHT, WIDTH), rtol=0, atol=1e-12
    )


def test_the_stops_have_an_entry_for_each_path() -> None:
    scene = striped_scene(2, 5, HEIGHT, WIDTH)
    with pytest.raises(warpvec.InputError, match=r"gradients.stops.offset must have shape \[5, 8\]"):
        replace(scene.gradients.stops, offset=torch.zeros(5, 3))
    with pytest.raises(warpvec.InputError, match="gradients.stops must have 5 entries"):
        replace(scene.gradients, stops=Stops.two(torch.zeros(4, 3)))
