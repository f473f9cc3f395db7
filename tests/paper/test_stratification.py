"""Vector Scaffolding's policy by the rules of its code: the first paths, new ones, and how many there are."""

from __future__ import annotations

import math
from typing import Any

import pytest
import torch
from torch import Tensor

from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.population import Population
from warpvec.geometry.scene import Scene
from warpvec.paper.sides import birth_points
from warpvec.paper.stratification import Stratification, base_radius

HEIGHT, WIDTH = 60, 90


def policy_of(**settings: Any) -> tuple[Stratification, Population]:
    image = torch.rand(HEIGHT, WIDTH, 3, generator=torch.Generator().manual_seed(1))
    config = make_config("paper", **{"curves": 64, "iterations": 1000, **settings})
    policy = Stratification(image, config)
    first = policy.first_paths(torch.ones(3))
    return policy, Population(first, config, WIDTH / 2, None, (WIDTH / 2, HEIGHT / 2))


def inflate(policy: Stratification, population: Population, error: Tensor, k: int = 1) -> Scene:
    """Return the paths that the ``k``-th inflation adds, by the ``error`` before its step."""
    policy.look(population, 100 * k, 1000, lambda scene: error)
    before = population.serial.max()
    assert policy.update(population, 100 * k, 1000, None, lambda scene: torch.full_like(error, torch.nan))
    return population.scene.select(population.serial > before)


def half_axes(scene: Scene) -> Tensor:
    """Return half the width and half the height of each ring of control points [N, 2]."""
    return (scene.points.amax(1) - scene.points.amin(1)) / 2


def test_the_first_radius_is_half_the_mean_distance_of_neighbours() -> None:
    corners = torch.tensor([[0.1, 0.1], [0.1, 0.3], [0.9, 0.9], [0.8, 0.9]])
    assert base_radius(corners) == pytest.approx(0.5 * 2.0 * (0.2 + 0.2 + 0.1 + 0.1) / 4)
    assert base_radius(corners[:1]) == 0.5
    drawn = [base_radius(torch.rand(16, 2, generator=torch.Generator().manual_seed(seed))) for seed in range(200)]
    assert sum(drawn) / 200 == pytest.approx(0.140, abs=0.005)  # as read from the code


def test_the_first_paths_ignore_the_image_and_are_jittered() -> None:
    policy, population = policy_of()
    first = population.scene
    assert len(first) == 16 and first.opacity[0].item() == pytest.approx(1 / (1 + math.exp(-1)))
    assert first.color.min() >= 0.5 and first.color.max() <= 0.7311
    full = birth_points(torch.zeros(1, 2), policy._radius(0) * torch.tensor([WIDTH / 2, HEIGHT / 2]), 5)
    assert (half_axes(first) <= half_axes(Scene.uniform(full, *_looks(1), degree=5)) + 1e-4).all()
    assert (half_axes(first) >= 0.4 * half_axes(Scene.uniform(full, *_looks(1), degree=5))).all()


def _looks(count: int) -> tuple[Tensor, ...]:
    return torch.zeros(count, 3), torch.ones(count), torch.ones(3), torch.zeros(count, dtype=torch.int64)


def test_new_paths_lie_where_the_image_was_wrong_and_follow_the_sides_of_the_picture() -> None:
    policy, population = policy_of()
    error = torch.zeros(HEIGHT, WIDTH)
    error[20, 30] = 1.0
    new = inflate(policy, population, error)
    assert len(new) == 16
    axes = half_axes(new)
    radius = policy._radius(1)
    assert radius == pytest.approx(0.5 * policy._radius(0))
    # 10 steps over a whole turn: the ring reaches its half axis across on one side only.
    across = 0.5 * (1.0 - min(math.cos(2 * math.pi * k / 9) for k in range(10)))
    torch.testing.assert_close(axes[:, 0], torch.full((16,), across * radius * WIDTH / 2), rtol=1e-4, atol=1e-4)
    torch.testing.assert_close(axes[:, 1] / axes[:, 0], (axes[:, 1] / axes[:, 0])[:1].expand(16), rtol=1e-3, atol=0)
    right = new.points[:, 0] - torch.tensor([radius * WIDTH / 2, 0.0])
    assert (right - torch.tensor([30.5, 20.5])).abs().max() < 5  # the residual is blurred by a pixel
    assert (right - right.floor() - 0.5).abs().max() < 1e-3


def test_the_outline_of_a_new_path_lies_inside_of_its_ring() -> None:
    points = birth_points(torch.zeros(1, 2).double(), torch.ones(2).double(), 5)
    t = torch.linspace(0, 1, 2001, dtype=torch.float64)[:, None]
    closed = torch.cat([points[0], points[0, :1]])
    sides = [closed[:6], closed[5:]]
    outline = torch.cat(
        [sum(math.comb(5, j) * t**j * (1 - t) ** (5 - j) * side[j] for j in range(6))[:-1] for side in sides]
    )
    after = outline.roll(-1, 0)
    area = 0.5 * (outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0]).sum().abs().item()
    assert math.sqrt(area / math.pi) == pytest.approx(0.825, abs=0.001)  # as read from the code
    assert torch.equal(points[0, 0], points[0, -1])


@pytest.mark.parametrize(("preset", "count"), [("paper", 32), ("paper-released", 32 - 5)])
def test_the_code_does_not_replace_what_it_prunes(preset: str, count: int) -> None:
    policy, population = policy_of(**{} if preset == "paper" else {"compensate": False})
    raw = population._rows[2][0]
    raw[:5] = -9.0  # logits far below any threshold
    population.live.opacity[:5] = raw[:5, 0].sigmoid()
    population._copy = None
    inflate(policy, population, torch.ones(HEIGHT, WIDTH))
    assert len(population) == count


def test_the_released_threshold_removes_what_is_not_more_than_half_opaque() -> None:
    released = make_config("paper-released")
    assert torch.tensor(released.prune_opacity).logit().item() == pytest.approx(0.01, abs=1e-6)
    assert not released.compensate and make_config("paper").compensate


def test_other_path_models_are_refused() -> None:
    with pytest.raises(InputError, match="path_model must be sides with the policy stratification"):
        make_config("paper", path_model="segments")
