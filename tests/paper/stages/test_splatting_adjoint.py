"""Gradients of the splat renderer under every switch, by autograd of the reference and by finite differences.

No alpha and no standard deviation of a scene is so near a cut, clip or clamp that rounding, or a step of the finite
differences, moves it across.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from assertions import assert_grad_close, finite_difference
from backends import VECTOR, Backend
from oracles import GRADIENTS, adjoint, cotangent, precisions, render
from reference.splatting import Settings
from scenes import ZOO, SceneTensors, ZooCase, circle, degenerate_scene, random_scene
from splat_oracles import (
    check_gradients,
    decisions,
    in_the_middle,
    loop_scene,
    make_splat_renderer,
    off_the_band,
    reference_gradients,
    switches,
    with_switches,
)
from sweep import sweep
from torch import Tensor

from warpvec.paper.splat import SplatRenderer

SIZES = [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (33, 31), (20, 528)]

SMALL = Settings(samples=7, lines=2)

STEP = 1e-6
"""Step of finite differences, in pixels or in units of colour and opacity."""

Maker = Callable[..., SceneTensors]


# Gradients against autograd


@sweep("covariance", [True, False])
@sweep(("height", "width"), SIZES)
def test_gradients_at_every_border(height: int, width: int, covariance: bool, backend: Backend) -> None:
    settings = with_switches(Settings(5, 2), True, covariance)
    scene = off_the_band(settings, random_scene, height * width, 8, height, width)
    check_gradients(scene, settings, make_splat_renderer(scene, settings, backend), 1e-10)


@pytest.mark.slow
@switches
@sweep("path_count", [1, 2, 63, 64, 65])
def test_gradients_of_any_number_of_paths(path_count: int, interior: bool, covariance: bool) -> None:
    settings = with_switches(Settings(4, 1), interior, covariance)
    scene = off_the_band(settings, random_scene, path_count, path_count, 33, 31)
    check_gradients(scene, settings, make_splat_renderer(scene, settings, threads=3), 1e-10)


@sweep("seed", range(2))
@switches
def test_gradients_of_degenerate_paths(seed: int, interior: bool, covariance: bool, backend: Backend) -> None:
    settings = with_switches(SMALL, interior, covariance)
    scene = off_the_band(settings, degenerate_scene, seed, 8, 33, 40)
    # Rounding separates coinciding sides in a random direction. Clamps hide that, except for huge paths.
    check_gradients(scene, settings, make_splat_renderer(scene, settings, backend), 1e-9)


@pytest.mark.slow
@sweep("case", [case for case in ZOO if len(case.scene.points)])
@switches
def test_gradients_of_the_zoo(case: ZooCase, interior: bool, covariance: bool) -> None:
    settings = with_switches(Settings(6, 2), interior, covariance)
    scene = case.scene._replace(points=case.scene.points + 1e-3 * torch.randn(2, dtype=torch.float64))
    # The direction of a tangent of 1e-4 px at 32 px is accurate to 1e-10.
    reach = max(1.0, scene.points.abs().max().item() / 1e3)
    check_gradients(scene, settings, make_splat_renderer(scene, settings), 1e-9 * reach)


@sweep("covariance", [True, False])
def test_gradients_in_single_precision(covariance: bool, backend: Backend) -> None:
    settings = with_switches(Settings(16, 6), True, covariance)
    scene = off_the_band(settings, random_scene, 11, 10, 60, 70)
    adj_image = cotangent(scene)
    got = adjoint(scene, make_splat_renderer(scene, settings, backend, torch.float32), adj_image)
    want = reference_gradients(scene, settings, adj_image)
    for name in GRADIENTS:
        assert_grad_close(getattr(got, name), want[name], rtol=1e-3, atol=0.0, name=name)


# Gradients against finite differences


def functional(
    scene: SceneTensors, renderer: SplatRenderer, adj_image: Tensor, name: str
) -> Callable[[Tensor], Tensor]:
    """Return <image, adj_image> as a function of one input."""
    return lambda value: (render(scene._replace(**{name: value}), renderer) * adj_image).sum()


def stays_smooth(scene: SceneTensors, settings: Settings, name: str, move: Tensor) -> bool:
    """Return whether no alpha crosses the cut or the clip, and no standard deviation a clamp, within the step."""
    value = getattr(scene, name)
    ends = [decisions(scene._replace(**{name: value + sign * move}), settings) for sign in (-1, 1)]
    return torch.equal(*ends)


def check_directions(scene: SceneTensors, settings: Settings, name: str, moves: list[Tensor], backend: Backend) -> None:
    """Compare the adjoint with the central difference along each of ``moves`` that is smooth; most must be."""
    renderer, adj_image = make_splat_renderer(scene, settings, backend), cotangent(scene)
    got = getattr(adjoint(scene, renderer, adj_image), name)
    f, value = functional(scene, renderer, adj_image, name), getattr(scene, name)
    smooth = torch.stack([move for move in moves if stays_smooth(scene, settings, name, STEP * move)])
    assert len(smooth) > len(moves) / 2, f"{len(smooth)} of {len(moves)} moves cross no threshold"
    still = torch.zeros(len(smooth), dtype=torch.float64)
    want = finite_difference(lambda by: f(value + torch.tensordot(by, smooth, 1)), still, STEP)
    # The tolerance is the rounding error of a sum of 1e3 addends, divided by the step.
    assert_grad_close((smooth * got).flatten(1).sum(1), want, rtol=1e-6, atol=1e-6, name=name)


@sweep("make", [random_scene, in_the_middle])
@sweep("degree", [3, 5])
def test_finite_differences_of_the_points(make: Maker, degree: int, backend: Backend) -> None:
    settings = Settings(6, 2, degree, covariance_gradient=True)
    scene = make(5, 3, 24, 28)
    if degree == 5:
        scene = scene._replace(points=loop_scene(5, 3, 24, 28, 5).points)
    entries = torch.eye(scene.points.numel(), dtype=torch.float64)[::4]
    moves = [entry.reshape(scene.points.shape) for entry in entries]
    check_directions(scene, settings, "points", moves, backend)


def test_finite_differences_of_moving_a_path(backend: Backend) -> None:
    # No covariance changes when a whole path moves, so its gradient may be off.
    settings = Settings(6, 2)
    scene = in_the_middle(6, 5, 24, 28)
    moves = []
    for row in range(5):
        for axis in range(2):
            move = torch.zeros_like(scene.points)
            move[row, :, axis] = 1
            moves.append(move)
    check_directions(scene, settings, "points", moves, backend)


@switches
@sweep("name", ["color", "opacity", "background"])
def test_finite_differences_of_the_paint(name: str, interior: bool, covariance: bool) -> None:
    settings = with_switches(Settings(6, 2), interior, covariance)
    scene = in_the_middle(7, 5, 24, 28)
    value = getattr(scene, name)
    moves = [entry.reshape(value.shape) for entry in torch.eye(value.numel(), dtype=torch.float64)]
    check_directions(scene, settings, name, moves, VECTOR)


# Degenerate paths that cannot be compared


@sweep("value", [1e8, -3e38])
@switches
@precisions
def test_a_path_that_runs_far_out_has_finite_gradients(
    value: float, interior: bool, covariance: bool, backend: Backend, dtype: torch.dtype
) -> None:
    settings = with_switches(SMALL, interior, covariance)
    scene = random_scene(3, 4, 33, 50)
    scene.points[1, 4] = value
    renderer = make_splat_renderer(scene, settings, backend, dtype)
    assert render(scene, renderer).isfinite().all()
    got = adjoint(scene, renderer, cotangent(scene))
    assert all(getattr(got, name).isfinite().all() for name in GRADIENTS)


@switches
@precisions
def test_gradients_of_collapsed_paths_are_finite(
    interior: bool, covariance: bool, backend: Backend, dtype: torch.dtype
) -> None:
    settings = with_switches(Settings(), interior, covariance)
    dots = [circle(7.5, 9.5, radius) for radius in (0.0, 1e-30, 1e-7, 1e-6, 1e-3)]
    lines = [circle(20.0, 16.0, 5.0) * torch.tensor([1.0, scale]) for scale in (0.0, 1e-8)]
    scene = random_scene(1, 7, 33, 50)._replace(points=torch.stack([*dots, *lines]))
    renderer = make_splat_renderer(scene, settings, backend, dtype)
    got = adjoint(scene, renderer, cotangent(scene))
    assert all(getattr(got, name).isfinite().all() for name in GRADIENTS)
    # Moving a Gaussian of 0.25 px by 1 px changes alpha by at most 2.5, on a dozen pixels; there are 2688 Gaussians.
    assert got.points.abs().max() < 1e6
