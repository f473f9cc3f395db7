"""The kernel of the regularizers of two sides against autograd of their torch form and finite differences."""

import pytest
import torch
from assertions import finite_difference
from regularization_cases import HEIGHT, SIDE_SCENES, WIDTH, scattered
from sweep import sweep

from warpvec.config.presets import make_config
from warpvec.geometry.scene import Scene
from warpvec.geometry.side_opacity import SideOpacity
from warpvec.paper.side_terms import SideTerms, side_terms

START = 2.0
"""What the adjoints hold before the terms are added."""


def config_of(points, **settings):
    return make_config("paper", degree=points.shape[1] // 2, **{"xing_weight": 3.0, "bezier_weight": 5.0} | settings)


def scene_of(points, opacity):
    black = torch.zeros(len(points), 3, dtype=points.dtype)
    generation = torch.zeros(len(points)).long()
    return Scene.uniform(points, black, opacity, torch.zeros(3).to(points), generation, points.shape[1] // 2)


def added(scene, config, device, shape, counts=None):
    """Return what the terms add to adjoints of points [N, P, 2] and of opacities [*shape]."""
    there = scene.to(device)
    adj_segments = torch.full_like(there.segments, START)
    adj_opacity = torch.full(shape, START, dtype=there.opacity.dtype, device=device)
    SideTerms(HEIGHT, WIDTH, config, device).add_adjoint(there, adj_segments, adj_opacity, counts)
    return adj_segments.cpu().view_as(scene.points) - START, adj_opacity.cpu() - START


# Points that coincide exactly have no one gradient of a tip or of a turn.
@sweep("scene", sorted(SIDE_SCENES.keys() - {"doubled_points", "coincident_points", "degree_1"}))
def test_adjoints_follow_autograd(scene, backend):
    points = SIDE_SCENES[scene]
    opacity = torch.linspace(0.1, 1.0, len(points)).double()
    config = config_of(points)
    leaves = [points.clone().requires_grad_(), opacity.clone().requires_grad_()]
    want = torch.autograd.grad(side_terms(*leaves, WIDTH, HEIGHT, config), leaves)
    got = added(scene_of(points, opacity), config, backend.device, opacity.shape)
    torch.testing.assert_close(got[0], want[0], rtol=1e-9, atol=1e-13)
    torch.testing.assert_close(got[1], want[1], rtol=1e-9, atol=1e-13)


def test_adjoints_are_finite_differences(backend):
    points, opacity = scattered(6), torch.linspace(0.1, 0.9, 6).double()
    config = config_of(points, bezier_weight=50.0)
    got = added(scene_of(points, opacity), config, backend.device, opacity.shape)

    def value(x):
        return side_terms(x, opacity, WIDTH, HEIGHT, config)

    want = finite_difference(value, points, 1e-5).view_as(points)
    assert (want != 0.0).double().mean() > 0.3
    torch.testing.assert_close(got[0], want, rtol=1e-5, atol=1e-9)


def test_three_opacities_a_path(backend):
    points, three = scattered(4), torch.linspace(0.1, 0.9, 12).double().view(4, 3)
    scene = scene_of(points, three[:, 0].clone())
    object.__setattr__(scene, "side_opacity", SideOpacity(three[:, 1:].contiguous()))
    config = config_of(points, opacity_weight=0.6)
    _, got = added(scene, config, backend.device, three.shape)
    torch.testing.assert_close(got, torch.full((4, 3), -0.6 / 12, dtype=torch.float64), rtol=1e-12, atol=0.0)


@pytest.mark.parametrize("count", [0, 3])
def test_paths_beyond_the_count_get_nothing_and_weigh_nothing(count, backend):
    points, opacity = scattered(5), torch.linspace(0.1, 0.9, 5).double()
    config = config_of(points)
    counts = torch.tensor([count], dtype=torch.int32, device=backend.device)
    got = added(scene_of(points, opacity), config, backend.device, opacity.shape, counts)
    want = added(scene_of(points[:count], opacity[:count]), config, backend.device, (count,))
    for whole, part in zip(got, want, strict=True):
        assert torch.equal(whole[:count], part) and not whole[count:].any()
