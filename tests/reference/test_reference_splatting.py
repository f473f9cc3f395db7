"""The splat reference against arithmetic in plain Python, closed forms and finite differences."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from assertions import assert_grad_close, finite_difference
from scenes import SceneTensors, circle, random_scene, straight
from torch import Tensor

from reference.compositing import composite
from reference.splat_definition import literal_coverage
from reference.splatting import (
    Settings,
    chain_point,
    end_factors,
    gaussians,
    path_alpha,
    peak,
    render,
    row_weights,
    sides,
)

SMALL = Settings(samples=5, lines=2)

EXACT = 1e-12
"""Tolerance for a few hundred float64 operations on values of canvas size."""


# The definition in plain Python


@pytest.mark.parametrize(
    ("degree", "pieces", "samples", "lines"),
    [(3, 4, 5, 2), (3, 3, 4, 1), (3, 2, 3, 2), (3, 5, 2, 1), (5, 2, 7, 2), (2, 2, 4, 2), (1, 6, 5, 2)],
)
@pytest.mark.parametrize("opacity", [0.07, 0.8, 1.0])
def test_coverage_is_the_definition(degree: int, pieces: int, samples: int, lines: int, opacity: float) -> None:
    settings = Settings(samples, lines, degree)
    generator = torch.Generator().manual_seed(10 * degree + pieces)
    points = 12 * torch.rand(1, degree * pieces, 2, generator=generator, dtype=torch.float64) - 1
    got = path_alpha(gaussians(points, settings), torch.tensor([opacity], dtype=torch.float64), 9, 11)[0]
    want = literal_coverage([tuple(p) for p in points[0].tolist()], opacity, settings, 9, 11)
    assert want.max() > 0.05
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)


@pytest.mark.parametrize(
    "path", [circle(5.5, 4.5, 0.0), circle(5.5, 4.5, 3.0), straight((1, 1), (9, 1), (9, 1), (1, 1))]
)
def test_coverage_of_collapsed_and_even_paths_is_the_definition(path: Tensor) -> None:
    got = path_alpha(gaussians(path[None], SMALL), torch.ones(1).double(), 9, 11)[0]
    want = literal_coverage([tuple(p) for p in path.tolist()], 1.0, SMALL, 9, 11)
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)


# Sides, rows, spacing


@pytest.mark.parametrize(("pieces", "middle"), [(2, 3), (3, 3), (4, 6), (5, 6)])
def test_both_sides_run_from_the_first_anchor_to_the_middle_one(pieces: int, middle: int) -> None:
    path = random_scene(pieces, 1, 40, 40, pieces).points
    for side in sides(path, 3):
        ends = chain_point(side, 3, torch.tensor([0.0, 1.0], dtype=torch.float64))
        torch.testing.assert_close(ends, path[:, [0, middle]], rtol=0, atol=EXACT)


def test_sides_of_five_pieces_follow_the_outline() -> None:
    path = random_scene(1, 1, 40, 40, 5).points
    side_a, side_b = sides(path, 3)
    # Joints of the two pieces on side A, and of the three pieces, run backwards, on side B.
    a = chain_point(side_a, 3, torch.tensor([0.5], dtype=torch.float64))
    b = chain_point(side_b, 3, torch.tensor([1 / 3, 2 / 3], dtype=torch.float64))
    torch.testing.assert_close(a[:, 0], path[:, 3], rtol=0, atol=EXACT)
    torch.testing.assert_close(b, path[:, [12, 9]], rtol=0, atol=EXACT)


def test_a_path_of_raised_degree_has_the_same_gaussians() -> None:
    path = random_scene(2, 3, 40, 50, 2).points
    raised = raise_degree(raise_degree(path, 3), 4)
    low, high = (gaussians(p, Settings(7, 3, degree)) for p, degree in ((path, 3), (raised, 5)))
    for got, want in zip(high, low, strict=True):
        torch.testing.assert_close(got, want, rtol=0, atol=1e-11)


def raise_degree(points: Tensor, degree: int) -> Tensor:
    """Return the same loops [N, (degree + 1) * pieces, 2] as curves of one degree more."""
    pieces = points.unfold(1, degree, degree).mT
    control = torch.cat([pieces, pieces[:, :, :1].roll(-1, 1)], 2)
    share = torch.arange(degree + 1, dtype=points.dtype)[:, None] / (degree + 1)
    before = torch.cat([control[:, :, :1], control[:, :, :-1]], 2)
    return (share * before + (1 - share) * control).flatten(1, 2)


@pytest.mark.parametrize("lines", [1, 2, 5, 40])
def test_row_weights_are_even_about_the_middle_and_denser_at_the_sides(lines: int) -> None:
    w = row_weights(lines)
    torch.testing.assert_close(w + w.flip(0), torch.ones(lines + 2).double(), rtol=0, atol=EXACT)
    assert (w.diff() > 0).all() and len(w) == lines + 2
    if lines == 40:
        assert w[1].item() == pytest.approx(0.0093, abs=1e-4) and w[2] - w[1] < 0.1 * (w[21] - w[20])


def test_end_factors() -> None:
    wants = {2: [0.4, 0.4], 3: [0.4, 0.9, 0.4], 4: [0.4, 0.9, 0.9, 0.4], 6: [0.4, 0.9, 1.0, 1.0, 0.9, 0.4]}
    for samples, want in wants.items():
        assert end_factors(samples).tolist() == want


def test_spacing_of_a_strip() -> None:
    # Side A is the line from (10, 10) to (40, 10); side B starts at a right angle to it and runs 24 px below.
    path = straight((10.0, 10.0), (40.0, 10.0))[None].repeat(1, 1, 1)
    path[0, 3:] = torch.tensor([[40.0, 10.0], [30.0, 34.0], [20.0, 34.0]], dtype=torch.float64)
    found = gaussians(path, Settings(9, 3))
    step = 30 * (0.993 - 0.007) / 8
    want = 2 / 3 * step * torch.tensor([0.4, 0.9, 1, 1, 1, 1, 1, 0.9, 0.4], dtype=torch.float64)
    torch.testing.assert_close(found.scale[0, 0, :, 0], want, rtol=0, atol=EXACT)
    gap = (found.mean[0, 2:] - found.mean[0, 1:-1]).norm(dim=-1)
    torch.testing.assert_close(found.free_scale[0, 1:-1, :, 1], 2 / 3 * gap, rtol=0, atol=EXACT)
    first = (found.mean[0, 1] - found.mean[0, 0]).norm(dim=-1)
    for row in (0, -1):
        torch.testing.assert_close(found.scale[0, row, :, 1], (2 / 3 * first).clamp(0.75, 1.0), rtol=0, atol=EXACT)
    assert torch.equal(found.frame[0, 0], torch.eye(2).double().expand(9, 2, 2))


def test_covariance_turns_with_the_path() -> None:
    path, angle = random_scene(3, 1, 40, 40).points, 0.7
    turn = torch.tensor([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]], dtype=torch.float64)
    before, after = gaussians(path, SMALL).covariance, gaussians(path @ turn, SMALL).covariance
    torch.testing.assert_close(after, turn.T @ before @ turn, rtol=0, atol=1e-10)


def test_scales_off_the_clamps_grow_with_the_path() -> None:
    path = 1e3 * random_scene(4, 1, 40, 40).points
    before, after = gaussians(path, SMALL), gaussians(2 * path, SMALL)
    torch.testing.assert_close(after.covariance[:, 1:-1], 4 * before.covariance[:, 1:-1], rtol=EXACT, atol=0)
    across = after.scale[:, [0, -1], :, 1]
    assert across.amin() >= 0.75 and across.amax() == 1.0


# Coverage and image in closed form


def test_a_path_that_is_a_point() -> None:
    # 2 x 5 Gaussians of the sides (0.3 by 0.75 px) and 2 x 5 of the lines (0.25 by 0.25 px), all at a pixel centre.
    found = gaussians(circle(5.5, 4.5, 0.0)[None], SMALL)
    got = path_alpha(found, torch.tensor([0.5], dtype=torch.float64), 9, 11)[0]
    y, x = torch.meshgrid(torch.arange(9.0).double() - 4, torch.arange(11.0).double() - 5, indexing="ij")
    side = 0.5 * torch.exp(-0.5 * ((x / 0.3) ** 2 + (y / 0.75) ** 2))
    line = 0.5 * torch.exp(-0.5 * (x**2 + y**2) / 0.25**2)
    side, line = (torch.where(alpha < 1 / 255, 0.0, alpha) for alpha in (side, line))
    torch.testing.assert_close(got, 1 - (1 - side) ** 10 * (1 - line) ** 10, rtol=0, atol=EXACT)


@pytest.mark.parametrize(("opacity", "peak_alpha"), [(0.0, 0.0), (0.0039, 0.0), (0.004, 0.004), (0.9, 0.9), (1, 0.999)])
def test_alpha_is_cut_below_and_clipped_above(opacity: float, peak_alpha: float) -> None:
    found = gaussians(circle(5.5, 4.5, 0.0)[None], Settings(2, 1))
    got = path_alpha(found, torch.tensor([opacity], dtype=torch.float64), 9, 11)[0, 4, 5]
    assert got.item() == pytest.approx(1 - (1 - peak_alpha) ** 6, abs=EXACT)


def test_paths_are_composited_in_row_order() -> None:
    scene = random_scene(5, 3, 20, 24)
    coverage = path_alpha(gaussians(scene.points, SMALL), scene.opacity, 20, 24)
    want = composite(coverage, scene.color, torch.ones(3).double(), scene.background)
    assert torch.equal(render(*scene, SMALL), want)
    flipped = scene._replace(points=scene.points.flip(0), color=scene.color.flip(0), opacity=scene.opacity.flip(0))
    assert not torch.allclose(render(*flipped, SMALL), want, atol=1e-3)


def test_no_paths() -> None:
    scene = random_scene(1, 0, 3, 4)
    assert torch.equal(render(*scene, SMALL), scene.background.expand(3, 4, 3))


# Gradients


def test_gradients_are_finite_differences() -> None:
    scene = random_scene(6, 2, 14, 17)
    settings = replace(SMALL, covariance_gradient=True)
    weight = torch.randn(14, 17, 3, dtype=torch.float64)
    for index, name in enumerate(("points", "color", "opacity", "background")):
        leaf = scene[index].clone().requires_grad_()
        (got,) = torch.autograd.grad(weighted(scene, settings, weight, name, leaf), leaf)

        def move(value: Tensor, name: str = name) -> Tensor:
            return weighted(scene, settings, weight, name, value)

        # No alpha of this scene crosses the cut within the step.
        want = finite_difference(move, scene[index], 1e-6).reshape(got.shape)
        assert_grad_close(got, want, rtol=1e-7, atol=1e-8, name=name)


def weighted(scene: SceneTensors, settings: Settings, weight: Tensor, name: str, value: Tensor) -> Tensor:
    return (render(*scene._replace(**{name: value}), settings) * weight).sum()


@pytest.mark.parametrize("covariance", [True, False])
def test_switches_detach_what_they_say(covariance: bool) -> None:
    points = random_scene(7, 2, 30, 30).points.requires_grad_()
    found = gaussians(points, Settings(5, 3, interior_gradient=False, covariance_gradient=covariance))
    for tensor, attached in ((found.mean, True), (found.frame, covariance), (found.scale, covariance)):
        assert tensor.requires_grad or not attached
        if attached:
            inner, outer = (
                torch.autograd.grad(rows.sum(), points, retain_graph=True)[0]
                for rows in (tensor[:, 1:-1] ** 2, tensor[:, [0, -1], :, 0] ** 2)
            )
            assert not inner.any() and outer.any()
        else:
            assert not tensor.requires_grad
    attached = gaussians(points, Settings(5, 3, covariance_gradient=covariance))
    assert torch.autograd.grad(attached.mean[:, 1:-1].sum(), points, retain_graph=True)[0].any()
    assert attached.scale.requires_grad == covariance


@pytest.mark.parametrize("opacity", [0.0, 0.003])
def test_what_is_dropped_has_no_gradient(opacity: float) -> None:
    scene = random_scene(8, 1, 14, 17)._replace(opacity=torch.tensor([opacity], dtype=torch.float64))
    leaves = [tensor.clone().requires_grad_() for tensor in scene[:3]]
    image = render(*leaves, *scene[3:], SMALL)
    grads = torch.autograd.grad(image.sum(), leaves, allow_unused=True, materialize_grads=True)
    assert not any(gradient.any() for gradient in grads)


def test_what_is_clipped_has_no_gradient() -> None:
    # Every Gaussian has its peak at the only pixel of the canvas.
    points = circle(0.5, 0.5, 0.0)[None].requires_grad_()
    opacity = torch.ones(1, dtype=torch.float64, requires_grad=True)
    layer = path_alpha(gaussians(points, SMALL), opacity, 1, 1)
    got = torch.autograd.grad(layer.sum(), [points, opacity], materialize_grads=True)
    assert not got[0].any() and not got[1].any()


def test_gradients_of_a_collapsed_path_are_finite() -> None:
    points = circle(5.3, 4.4, 0.0)[None].requires_grad_()
    layer = path_alpha(gaussians(points, replace(SMALL, covariance_gradient=True)), torch.ones(1).double(), 9, 11)
    (got,) = torch.autograd.grad((layer * torch.arange(11.0)).sum(), points)
    assert got.isfinite().all() and got.any()


def test_peaks_are_those_of_the_coverage() -> None:
    scene = random_scene(9, 2, 14, 17)
    found = gaussians(scene.points, SMALL)
    values = peak(found, 1, scene.opacity, 14, 17).clamp(max=0.999)
    want = 1 - (1 - torch.where(values < 1 / 255, 0.0, values)).prod(0).prod(0)
    torch.testing.assert_close(path_alpha(found, scene.opacity, 14, 17)[1], want, rtol=0, atol=EXACT)
