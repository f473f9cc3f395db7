"""The regularizers' adjoints against autograd and finite differences."""

import pytest
import torch
from compound import compound_scene, split_into_loops
from regularization_cases import CUBIC_SCENES, HEIGHT, WIDTH, polygon, random_points, to_pixels
from sweep import sweep

from warpvec.config.fit_config import FitConfig
from warpvec.fit.regularization import (
    Regularization,
    _legs,
    _overshoot,
    _pixel,
    _planes,
    _projection_share,
    _tips,
    regularization,
    xing_loss,
)
from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import PROJECTION_WEIGHT, TIP_PARAMETER, XING_SCALE

WEIGHTS = [(0.01, 0.02, 1.0), (1.0, 0.0, 0.0), (0.0, 100.0, 0.0), (0.0, 0.0, 1.0)]


def scene_of(points, opacity):
    """Return a black scene of these paths."""
    black = torch.zeros_like(opacity)[:, None].expand(-1, 3)
    return Scene.uniform(points, black, opacity, points.new_zeros(3), torch.zeros_like(opacity).long())


def adjoint(points, opacity, config, device="cpu"):
    """Return dL/dpoints and dL/dopacity."""
    points, opacity = points.to(device), opacity.to(device)
    adj_points, adj_opacity = torch.zeros_like(points), torch.zeros_like(opacity)
    stage = Regularization(HEIGHT, WIDTH, config, device)
    stage.add_adjoint(scene_of(points, opacity), adj_points.view(-1, 3, 2), adj_opacity)
    return adj_points, adj_opacity


@sweep("scene", CUBIC_SCENES)
@sweep("weights", WEIGHTS)
def test_adjoint_equals_autograd(scene, weights, device):
    points = CUBIC_SCENES[scene].clone().requires_grad_()
    opacity = torch.linspace(0, 1, len(points), dtype=torch.float64).requires_grad_()
    config = FitConfig(opacity_weight=weights[0], xing_weight=weights[1], bezier_weight=weights[2])
    regularization(points, opacity, WIDTH, HEIGHT, config).backward()
    adj_points, adj_opacity = adjoint(points.detach(), opacity.detach(), config, device=device)
    assert points.grad.isfinite().all()
    torch.testing.assert_close(adj_points.cpu(), points.grad, rtol=1e-9, atol=1e-14)
    torch.testing.assert_close(adj_opacity.cpu(), opacity.grad, rtol=1e-12, atol=0)


def test_adjoint_equals_finite_differences():
    # The points that move are not those of the chord, so the extent, a constant for the gradient, stays as it is.
    points = to_pixels([(-0.5, 0.0), (-0.6, 0.1), (0.0, 0.1), (0.5, 0.0), (0.6, -0.05), (0.1, -0.35)], (WIDTH, HEIGHT))
    config, opacity, step = FitConfig(xing_weight=100.0, bezier_weight=1.0), torch.ones(1, dtype=torch.float64), 1e-5
    adj_points, _ = adjoint(points, opacity, config)
    assert (adj_points[0, [1, 4, 5]] != 0.0).any(-1).all()
    for k in (1, 2, 4, 5):
        for axis in (0, 1):
            values = []
            for sign in (1, -1):
                moved = points.clone()
                moved[0, k, axis] += sign * step
                values.append(regularization(moved, opacity, WIDTH, HEIGHT, config).item())
            got = adj_points[0, k, axis].item()
            assert got == pytest.approx((values[0] - values[1]) / (2 * step), rel=1e-5, abs=1e-10), (k, axis)


def test_projection_of_a_vanishing_chord_stays_small():
    # Anchors 0.001 px apart with handles of 20 px, next to chords of 50 px.
    points = polygon((50.0, 50.0), (50.001, 50.0), (100.0, 50.0), (100.0, 100.0))
    points[0, 1, 0] += 20.0
    adj_points, _ = adjoint(points, torch.ones(1, dtype=torch.float64), FitConfig(bezier_weight=1.0))
    assert 0.0 < adj_points.abs().max() < 1e-3


def test_coincident_points_have_no_gradient():
    points = torch.full((3, 12, 2), 50.0)
    adj_points, _ = adjoint(points, torch.ones(3), FitConfig())
    assert adj_points.abs().max() == 0.0


@sweep("scene", CUBIC_SCENES)
def test_float32_adjoint_is_finite_and_close(scene):
    points, config = CUBIC_SCENES[scene], FitConfig()
    opacity = torch.linspace(0, 1, len(points))
    adj_points, _ = adjoint(points.float(), opacity, config)
    expected, _ = adjoint(points.float().double(), opacity.double(), config)
    assert adj_points.dtype == torch.float32
    torch.testing.assert_close(adj_points.double(), expected, rtol=1e-3, atol=1e-6)


def test_adjoint_adds_to_its_outputs():
    points = random_points(70, 4)
    opacity, config = torch.linspace(0, 1, 70, dtype=torch.float64), FitConfig()
    expected = adjoint(points, opacity, config)
    adj_points, adj_opacity = torch.full_like(points, 2.0), torch.full_like(opacity, 3.0)
    stage = Regularization(HEIGHT, WIDTH, config, "cpu")
    stage.add_adjoint(scene_of(points, opacity), adj_points.view(-1, 3, 2), adj_opacity)
    torch.testing.assert_close(adj_points - 2.0, expected[0], rtol=0, atol=1e-14)
    torch.testing.assert_close(adj_opacity - 3.0, expected[1], rtol=0, atol=1e-14)


def path_value(loops, config):
    """Return Xing and the Bezier regularizer of a path of ``loops`` [3 S, 2], whose cubics share one extent."""
    pixel = _pixel(loops[0], WIDTH, HEIGHT)
    legs = [_legs(_planes(loop[None], 3)) * pixel for loop in loops]
    anchors = [loop.reshape(1, -1, 3, 2)[:, :, 0].permute(2, 0, 1) * pixel - 1.0 for loop in loops]
    squares = torch.cat([_tips(each, TIP_PARAMETER).square().sum(0) for each in legs], -1)
    outside = torch.cat([(each - each.clamp(-1.0, 1.0)).abs().mean(0) for each in anchors], -1)
    xing = sum(len(loop) * xing_loss(loop[None]) for loop in loops) / sum(map(len, loops))
    whole = torch.cat(legs, -1)
    chord = whole.sum(0)
    squared = _overshoot(whole, chord).square() * _projection_share(whole, chord, pixel)
    projection = PROJECTION_WEIGHT * squared.sum()
    return config.xing_weight * XING_SCALE * xing + config.bezier_weight * (
        projection + squares.mean() + outside.mean()
    )


@sweep("weights", WEIGHTS)
@sweep("seed", range(3))
def test_adjoint_of_paths_of_loops_is_that_of_the_mean_over_the_paths(weights, seed, device):
    scene = compound_scene(seed, 9, HEIGHT, WIDTH)
    config = FitConfig(opacity_weight=weights[0], xing_weight=weights[1], bezier_weight=weights[2])
    segments, opacity = scene.segments.clone().requires_grad_(), scene.opacity.clone().requires_grad_()
    paths = [[loop.flatten(0, 1) for loop in path] for path in split_into_loops(segments, scene.structure)]
    total = sum(path_value(loops, config) for loops in paths) + config.opacity_weight * (1.0 - opacity).abs().sum()
    (total / len(scene)).backward()
    adj_segments, adj_opacity = torch.zeros_like(scene.segments).to(device), torch.zeros_like(scene.opacity).to(device)
    Regularization(HEIGHT, WIDTH, config, device).add_adjoint(scene.to(device), adj_segments, adj_opacity)
    torch.testing.assert_close(adj_segments.cpu(), segments.grad, rtol=1e-9, atol=1e-14)
    torch.testing.assert_close(adj_opacity.cpu(), opacity.grad, rtol=1e-12, atol=0)


def test_the_value_of_paths_of_one_loop_is_that_of_the_regularizers():
    points, config = random_points(5, 4), FitConfig(opacity_weight=0.0, xing_weight=1.0, bezier_weight=1.0)
    expected = regularization(points, torch.ones(5, dtype=torch.float64), WIDTH, HEIGHT, config)
    torch.testing.assert_close(sum(path_value([path], config) for path in points) / 5, expected)
