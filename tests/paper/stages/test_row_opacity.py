"""Three opacities a path: what rows of Gaussians get, and the gradients of the three."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from assertions import assert_grad_close, finite_difference
from backends import Backend
from oracles import cotangent
from reference import splatting
from reference.splatting import Settings
from scenes import SceneTensors
from splat_oracles import in_the_middle, make_splat_renderer
from sweep import sweep
from torch import Tensor

from warpvec.config.presets import make_config
from warpvec.fit.population import Population
from warpvec.geometry.scene import Scene
from warpvec.geometry.side_opacity import SideOpacity
from warpvec.paper.stages.row_opacity import row_shares

THREE = torch.tensor([[0.6, 0.2, 0.9], [0.3, 0.7, 0.4], [0.85, 0.8, 0.1]], dtype=torch.float64)
"""Opacities of three paths in the middle, at side A and at side B."""


def row_opacity(three: Tensor, lines: int) -> Tensor:
    """Return the opacity [N, lines + 2] of each row: lines lead from one side to the middle, and on to the other."""
    middle, a, b = three.logit().unbind(1)
    half, rest = lines // 2, lines - lines // 2
    first = [a + (middle - a) * (k / (half - 1) if half > 1 else 0.0) for k in range(half)]
    second = [middle + (b - middle) * (k / (rest - 1) if rest > 1 else 0.0) for k in range(rest)]
    return torch.stack([a, *first, *second, b], 1).sigmoid()


def with_sides(scene: SceneTensors, three: Tensor) -> Scene:
    generation = torch.zeros(len(three), dtype=torch.int64)
    plain = Scene.uniform(scene.points, scene.color, three[:, 0].clone(), scene.background, generation)
    return replace(plain, side_opacity=SideOpacity(three[:, 1:].contiguous()))


@sweep("lines", [1, 2, 5, 6])
def test_image_and_gradients_against_the_reference(lines: int, backend: Backend) -> None:
    settings, scene = Settings(7, lines), in_the_middle(4, 3, 33, 40)
    renderer, adj_image = make_splat_renderer(scene, settings, backend), cotangent(scene)
    three = THREE.clone().requires_grad_()
    leaves = [scene.points.clone().requires_grad_(), scene.color, row_opacity(three, lines), scene.background]
    image = splatting.render(*leaves, scene.height, scene.width, settings)
    adj_points, adj_three = torch.autograd.grad((image * adj_image).sum(), [leaves[0], three])
    drawn = with_sides(scene, THREE).to(backend.device)
    torch.testing.assert_close(renderer.render(drawn).cpu(), image.detach(), rtol=0, atol=1e-11)
    got = renderer.adjoint(drawn, adj_image.to(backend.device))
    assert got.side_opacity is not None
    found = torch.cat([got.opacity[:, None], got.side_opacity], 1).cpu()
    assert_grad_close(found, adj_three, rtol=1e-10, atol=1e-12, name="opacities")
    assert_grad_close(got.segments.cpu().view_as(adj_points), adj_points, rtol=1e-10, atol=1e-12, name="points")


def test_gradients_against_finite_differences(backend: Backend) -> None:
    settings, scene = Settings(7, 4), in_the_middle(4, 3, 33, 40)
    renderer, adj_image = make_splat_renderer(scene, settings, backend), cotangent(scene).to(backend.device)

    def value(three: Tensor) -> Tensor:
        return (renderer.render(with_sides(scene, three).to(backend.device)) * adj_image).sum().cpu()

    got = renderer.adjoint(with_sides(scene, THREE).to(backend.device), adj_image)
    assert got.side_opacity is not None
    found = torch.cat([got.opacity[:, None], got.side_opacity], 1).cpu()
    want = finite_difference(value, THREE, 1e-6).view_as(THREE)
    assert_grad_close(found, want, rtol=1e-6, atol=1e-7, name="opacities")


def test_equal_opacities_look_as_one(backend: Backend) -> None:
    settings, scene = Settings(7, 4), in_the_middle(4, 3, 33, 40)
    renderer = make_splat_renderer(scene, settings, backend)
    equal = with_sides(scene, THREE[:, :1].expand(-1, 3))
    want = renderer.render(replace(equal, side_opacity=None).to(backend.device))
    torch.testing.assert_close(renderer.render(equal.to(backend.device)), want, rtol=0, atol=1e-12)


@pytest.mark.parametrize("lines", [1, 2, 40, 41])
def test_shares_add_up_to_one(lines: int) -> None:
    torch.testing.assert_close(row_shares(lines).sum(1), torch.ones(lines + 2, dtype=torch.float64))


def test_a_step_moves_each_of_three_opacities_and_keeps_them_apart() -> None:
    config = make_config("paper-released", curves=3, device="cpu")
    scene = with_sides(in_the_middle(4, 3, 33, 40), THREE)
    scene = replace(scene._mapped(torch.Tensor.float))
    population = Population(scene, config, 20.0, half_sides=(20.0, 16.5))
    adj_three = torch.tensor([[1.0, 0.0, -1.0], [0.0, -1.0, 0.0], [0.0, 1.0, 1.0]])
    zeros = [torch.zeros_like(scene.segments), torch.zeros_like(scene.color)]
    population.step(*zeros, adj_three, torch.zeros(3), 1.0)
    after = population.live
    assert after.side_opacity is not None
    found = torch.cat([after.opacity[:, None], after.side_opacity.value], 1)
    assert torch.equal((found - THREE.float()).sign() * (adj_three != 0), -adj_three)
    torch.testing.assert_close(found[adj_three == 0], THREE.float()[adj_three == 0])
    population.remove(torch.tensor([1]))
    kept = population.live.side_opacity
    assert kept is not None and torch.equal(kept.value, found[[0, 2], 1:])
