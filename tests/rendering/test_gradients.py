"""Gradient paints: the reference, resvg, finite differences, and gradients that are degenerate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from assertions import assert_grad_close, assert_grad_present, check_gradients
from backends import Backend
from compound import scene_of_loops
from exact_renderers import HEIGHT, WIDTH, in_float32, make_renderer
from paints import VALUES, painted, painted_scene, reference_image, values_of, with_values
from reference import mean_squared_error
from scenes import blob_scene, circle, rectangle
from sweep import sweep
from torch import Tensor

import warpvec
from warpvec.geometry.paints.kind import RAMP_EXTENT_MIN
from warpvec.geometry.paints.registry import FLAT, LINEAR, RADIAL
from warpvec.geometry.scene import Scene
from warpvec.rendering.operator import _inputs
from warpvec.rendering.tile_renderer import Adjoints
from warpvec.svg.measure import draw
from warpvec.svg.quantize import quantize
from warpvec.svg.write import write_svg


def leaves_of(scene: Scene) -> list[Tensor]:
    return [value.clone().requires_grad_() for value in values_of(scene)]


def cotangent() -> Tensor:
    return torch.randn(HEIGHT, WIDTH, 3, dtype=torch.float64)


def check_adjoints(got: Adjoints, loss: Tensor, leaves: list[Tensor], tolerance: float = 1e-11) -> None:
    """Compare the adjoints with those of ``loss`` by autograd."""
    for name, want in zip(VALUES, torch.autograd.grad(loss, leaves, materialize_grads=True), strict=True):
        assert_grad_close(getattr(got, name), want, rtol=tolerance, atol=tolerance * 0.1, name=name)
        assert_grad_present(getattr(got, name), want, name)


def check_against_reference(scene: Scene, backend: Backend, **settings: Any) -> None:
    renderer, leaves, adj_image = make_renderer(backend, **settings), leaves_of(scene), cotangent()
    image = renderer.render(scene.to(backend.device)).cpu()
    want = reference_image(with_values(scene, leaves), renderer)
    torch.testing.assert_close(image, want.detach(), rtol=0, atol=1e-12)
    got = renderer.adjoint(scene.to(backend.device), adj_image.to(backend.device))
    check_adjoints(got, (want * adj_image).sum(), leaves)


MIXED = (LINEAR, RADIAL, FLAT, RADIAL, LINEAR)


@sweep(("seed", "kinds"), [*enumerate([(LINEAR,), (RADIAL,)]), *((k, MIXED) for k in range(2))])
def test_image_and_adjoints_are_those_of_the_reference(seed: int, kinds: tuple[int, ...], backend: Backend) -> None:
    check_against_reference(painted_scene(seed, 9, HEIGHT, WIDTH, kinds), backend)


def opaque_stack() -> Scene:
    """Return paths under, between and over two opaque ones with gradients that hide all below them."""
    loops = [[circle(x, 16.2, 13.4)] for x in (9.3, 25.1, 40.6)]
    cover, half = [rectangle(-20.3, -20.1, 70.2, 60.4)], [rectangle(15.2, -20.1, 70.2, 60.4)]
    scene = painted(scene_of_loops([loops[0], cover, loops[1], half, loops[2]]), (RADIAL, LINEAR, LINEAR, RADIAL, FLAT))
    return replace(scene, opacity=torch.tensor([0.7, 1.0, 1.0, 1.0, 0.6], dtype=torch.float64))


def test_what_opaque_gradients_hide_has_no_derivative(backend: Backend) -> None:
    check_against_reference(opaque_stack(), backend)


def test_what_is_not_drawn_behind_opaque_gradients_changes_no_other_derivative(backend: Backend) -> None:
    scene, adj_image = opaque_stack().to(backend.device), cotangent().to(backend.device)
    all_drawn, few_drawn = (make_renderer(backend, transmittance_min=least) for least in (0.0, 1e-4))
    torch.testing.assert_close(few_drawn.render(scene), all_drawn.render(scene), rtol=0, atol=1e-15)
    few_drawn.adjoint(painted_scene(1, 20, HEIGHT, WIDTH).to(backend.device), adj_image)  # fills the buffers
    want, got = all_drawn.adjoint(scene, adj_image), few_drawn.adjoint(scene, adj_image)
    for name in ("color", "background", "end_color", "geometry"):
        torch.testing.assert_close(getattr(got, name), getattr(want, name), rtol=1e-12, atol=1e-13)
    assert not got.geometry[0].any() and got.geometry[3].any()


@sweep("want_removal_cost", [False, True])
@pytest.mark.parametrize("make", [lambda: painted_scene(5, 6, HEIGHT, WIDTH), opaque_stack], ids=["random", "opaque"])
def test_a_fused_step_is_that_of_the_reference(
    make: Callable[[], Scene], want_removal_cost: bool, backend: Backend
) -> None:
    scene, renderer = make(), make_renderer(backend)
    target, leaves = torch.rand(HEIGHT, WIDTH, 3, dtype=torch.float64), leaves_of(make())
    got = renderer.fit_step(scene.to(backend.device), renderer.prepare_target(target), want_removal_cost)
    drawn = with_values(scene, leaves)
    loss = mean_squared_error(reference_image(drawn, renderer), target)
    check_adjoints(got, loss, leaves)
    torch.testing.assert_close(got.loss.cpu(), loss.detach(), rtol=1e-12, atol=0)
    if want_removal_cost:
        rests = [[other for other in range(len(scene)) if other != row] for row in range(len(scene))]
        errors = [mean_squared_error(reference_image(scene, renderer, rest), target) for rest in rests]
        torch.testing.assert_close(got.removal_cost.cpu(), torch.stack(errors) - loss.detach(), rtol=0, atol=1e-13)
    else:
        assert got.removal_cost is None


NAN, INF = math.nan, math.inf
DEGENERATE: dict[str, tuple[int, tuple[float, float, float, float]]] = {
    "equal ends": (LINEAR, (20.3, 11.2, 20.3, 11.2)),
    "ends closer than any pixel": (LINEAR, (20.3, 11.2, 20.3 + 0.7 * RAMP_EXTENT_MIN, 11.2 + 0.7 * RAMP_EXTENT_MIN)),
    "an end that is no number": (LINEAR, (20.3, NAN, 30.0, 11.2)),
    "an infinite end": (LINEAR, (20.3, 11.2, INF, 11.2)),
    "both ends infinite": (LINEAR, (INF, 1.0, INF, 11.2)),
    "longer than any number": (LINEAR, (-1e300, 1.0, 1e300, 11.2)),
    "radius 0": (RADIAL, (20.3, 11.2, 0.0, 0.0)),
    "a negative radius": (RADIAL, (20.3, 11.2, -5.0, 0.0)),
    "a small radius about a pixel's centre": (RADIAL, (20.5, 11.5, 0.99 * RAMP_EXTENT_MIN, 0.0)),
    "a radius that is no number": (RADIAL, (20.3, 11.2, NAN, 0.0)),
    "an infinite radius": (RADIAL, (20.3, 11.2, INF, 0.0)),
    "a centre that is no number": (RADIAL, (NAN, 11.2, 5.0, 0.0)),
    "an infinite centre": (RADIAL, (20.3, -INF, 5.0, 0.0)),
}


def with_gradient(kind: int, geometry: tuple[float, ...]) -> Scene:
    """Return a scene of three overlapping paths; the middle one has this gradient, the last one a usual one."""
    loops = [[circle(x, y, 12.3)] for x, y in ((15.1, 13.2), (24.7, 16.1), (35.4, 20.3))]
    scene = painted(scene_of_loops(loops), (FLAT, LINEAR, RADIAL))
    paints = scene.gradients.map(Tensor.clone)
    paints.kind[1], paints.geometry[1] = kind, torch.tensor(geometry, dtype=torch.float64)
    return replace(scene, gradients=paints)


@sweep("name", DEGENERATE)
def test_a_degenerate_gradient_is_a_flat_path_of_its_end_colour(name: str, backend: Backend) -> None:
    scene, renderer = with_gradient(*DEGENERATE[name]), make_renderer(backend)
    assert scene.gradients.is_degenerate().tolist() == [False, True, False]
    paints, color = scene.gradients.map(Tensor.clone), scene.color.clone()
    paints.kind[1], paints.geometry[1], color[1] = FLAT, 0.0, paints.end_color[1]
    flat = replace(scene, color=color, gradients=paints).to(backend.device)
    scene, adj_image = scene.to(backend.device), cotangent().to(backend.device)
    torch.testing.assert_close(renderer.render(scene), renderer.render(flat), rtol=0, atol=1e-15)
    got, want = (renderer.adjoint(each, adj_image) for each in (scene, flat))
    assert not got.geometry[1].any() and not want.geometry[1].any() and got.geometry[2].any()
    assert got.color[1].abs().max() < 1e-12
    torch.testing.assert_close(got.end_color[1], want.color[1], rtol=1e-12, atol=0)
    for each in ("segments", "opacity", "background"):
        torch.testing.assert_close(getattr(got, each), getattr(want, each), rtol=1e-10, atol=1e-12)


EXTREME: dict[str, tuple[int, tuple[float, float, float, float]]] = {
    "shorter than a pixel": (LINEAR, (24.2, 16.3, 24.6, 16.9)),
    "as short as can be": (LINEAR, (24.2, 16.3, 24.2 + 1.1 * RAMP_EXTENT_MIN, 16.3)),
    "huge": (LINEAR, (-1e6, -3e6, 2e6, 1e6)),
    "clamped everywhere": (LINEAR, (70.2, 60.1, 90.3, 80.4)),
    "vertical": (LINEAR, (24.2, 6.3, 24.2, 26.1)),
    "a small disk": (RADIAL, (24.2, 16.3, 1.1 * RAMP_EXTENT_MIN, 0.0)),
    "a huge disk": (RADIAL, (24.2, 16.3, 1e6, 0.0)),
    "a far centre": (RADIAL, (1e5, -2e5, 2.3e5, 0.0)),
    "centred on a pixel": (RADIAL, (24.5, 16.5, 9.3, 0.0)),
    "centred beside a pixel's centre": (RADIAL, (24.5 + 3e-5, 16.5 - 2e-5, 9.3, 0.0)),
}


@sweep("name", EXTREME)
def test_an_extreme_gradient_is_drawn_as_by_the_reference(name: str, backend: Backend) -> None:
    check_against_reference(with_gradient(*EXTREME[name]), backend)


def test_gradients_of_flat_paths_alone_change_no_bit(backend: Backend) -> None:
    scene, renderer = painted_scene(3, 8, HEIGHT, WIDTH, (FLAT,)).to(backend.device), make_renderer(backend)
    target, bare = renderer.prepare_target(torch.rand(HEIGHT, WIDTH, 3)), replace(scene, gradients=None)
    assert torch.equal(renderer.render(scene), renderer.render(bare))
    got, want = renderer.fit_step(scene, target, True), renderer.fit_step(bare, target, True)
    assert not got.geometry.any() and not got.end_color.any() and want.geometry is None
    for name in ("segments", "color", "opacity", "canvas_sums", "removal_cost"):
        assert torch.equal(getattr(got, name), getattr(want, name)), name


@sweep("lane_width", [16, 1])
def test_the_number_of_threads_changes_no_bit(lane_width: int) -> None:
    scene, target = painted_scene(4, 12, HEIGHT, WIDTH), torch.rand(HEIGHT, WIDTH, 3)
    results = []
    for threads in (1, 2, 3):
        renderer = make_renderer(Backend("cpu", lane_width), torch.float32, threads=threads)
        step = renderer.fit_step(in_float32(scene), renderer.prepare_target(target), True)
        results.append([renderer.render(in_float32(scene)), *(v for v in vars(step).values() if v is not None)])
    for other in results[1:]:
        assert all(map(torch.equal, results[0], other))


@sweep("seed", range(2))
def test_float32_is_near_the_reference(seed: int, backend: Backend) -> None:
    scene = painted(uniform_blobs(seed, 8), (LINEAR, RADIAL), seed)
    renderer, leaves, adj_image = make_renderer(backend, torch.float32), leaves_of(scene), cotangent()
    got = renderer.adjoint(in_float32(scene).to(backend.device), adj_image.float().to(backend.device))
    want = reference_image(with_values(scene, leaves), renderer)
    assert (renderer.render(in_float32(scene).to(backend.device)).cpu() - want).abs().max() < 1e-5
    gradients = torch.autograd.grad((want * adj_image).sum(), leaves)
    for name, gradient in zip(VALUES, gradients, strict=True):
        assert_grad_close(getattr(got, name), gradient, rtol=1e-4, atol=0, name=name)


def uniform_blobs(seed: int, count: int, height: int = HEIGHT, width: int = WIDTH) -> Scene:
    tensors = blob_scene(seed, count, height, width)
    return Scene.uniform(*tensors[:4], torch.zeros(count, dtype=torch.int64))


def drawing(scene: Scene, height: int, width: int, alpha: bool = False) -> Callable[..., Tensor]:
    """Return ``warpvec.render`` as a function of the six tensors."""
    return lambda *values: warpvec.render(with_values(scene, values), height, width, alpha=alpha)


@sweep("alpha", [False, True])
def test_gradcheck(alpha: bool) -> None:
    scene = painted(scene_of_loops([[circle(6.2, 4.6, 4.1, 2)], [circle(11.1, 3.7, 5.3, 3)]]), (LINEAR, RADIAL))
    check_gradients(drawing(scene, 9, 18, alpha), leaves_of(scene))


@sweep("name", VALUES[4:])
def test_a_value_of_the_gradients_alone_may_ask_for_a_derivative(name: str) -> None:
    scene = painted_scene(4, 3, HEIGHT, WIDTH)
    leaf = getattr(scene.gradients, name).clone().requires_grad_()
    drawn = replace(scene, gradients=replace(scene.gradients, **{name: leaf}))
    warpvec.render(drawn, HEIGHT, WIDTH).square().sum().backward()
    assert leaf.grad.shape == leaf.shape and leaf.grad[:2].any(1).all()


def test_opcheck() -> None:
    operators, image = torch.ops.warpvec, torch.rand(HEIGHT, WIDTH, 3, dtype=torch.float64)
    plain = _inputs(painted_scene(6, 3, HEIGHT, WIDTH))
    leaves = [*(value.clone().requires_grad_() for value in plain[:6]), *plain[6:]]
    torch.library.opcheck(operators.render.default, (leaves, 0, HEIGHT, WIDTH, "exact", 1, "{}"))
    torch.library.opcheck(operators.render_adjoint.default, (plain, image, 0, "exact", 1, "{}"))


# torch.compile imports what torch has deprecated.
@pytest.mark.filterwarnings("ignore::DeprecationWarning:torch")
@sweep("alpha", [False, True])
def test_it_compiles_without_a_graph_break(alpha: bool) -> None:
    scene = painted_scene(6, 4, HEIGHT, WIDTH)
    leaves, plain = leaves_of(scene), drawing(scene, HEIGHT, WIDTH, alpha)
    want = plain(*leaves)
    got = torch.compile(drawing(scene, HEIGHT, WIDTH, alpha), fullgraph=True, backend="aot_eager")(*leaves)
    torch.testing.assert_close(got, want)
    gradients = [torch.autograd.grad(image.square().sum(), leaves, materialize_grads=True) for image in (got, want)]
    torch.testing.assert_close(*gradients)


@sweep("kinds", [(LINEAR,), (RADIAL,), (LINEAR, RADIAL)])
def test_resvg_draws_the_same_gradients(kinds: tuple[int, ...]) -> None:
    values = []
    for seed in range(3):
        scene = quantize(in_float32(painted(uniform_blobs(seed, 100, 192, 240), kinds, seed)), 2)
        image = warpvec.render(scene, 192, 240).numpy()
        drawn = draw(write_svg(scene, 240, 192), 240, 192) / 255.0
        values.append(-10.0 * math.log10(float(np.square(image - drawn).mean())))
    assert np.mean(values) > 45.0, values
