"""Gradients lose the stops that say nothing, and their colours become whole levels, on squares drawn exactly."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from flat_drawings import SIZE, drawing, picture
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.fewer_stops import with_fewer_stops
from warpvec.flat.simplification.whole_levels import with_whole_levels
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import Stops
from warpvec.watch.watch import Watch

_DARK, _LIGHT = (61, 45, 36), (181, 165, 36)


def _painted(*stops: tuple[float, tuple[int, int, int]]) -> Scene:
    """Return a square with a linear gradient from left to right, of stops: each a place and a colour in levels."""
    low, high = 4.0, SIZE - 4.0
    corners = torch.tensor([[low, low], [high, low], [high, high], [low, high]])
    share = torch.tensor([0.0, 1 / 3, 2 / 3])[None, :, None]
    outline = (corners[:, None] + share * (corners.roll(-1, 0) - corners)[:, None]).reshape(-1, 2)
    colors = torch.tensor([color for _, color in stops]) / 255.0
    two, count = Stops.two(colors[-1:]), len(stops)
    two.offset[0, :count] = torch.tensor([place for place, _ in stops])
    two.inner_color[0, : count - 2] = colors[1:-1]
    kept = replace(two, count=torch.tensor([count], dtype=torch.int32))
    paints = Gradients(torch.ones(1, dtype=torch.int32), torch.tensor([[low, 0.0, high, 0.0]]), colors[-1:], kept)
    return replace(drawing(((0.0, 0.0, 0.0), [outline])), color=colors[:1], gradients=paints)


def _critic(image: Tensor) -> Critic:
    return Critic(image, FitConfig(threads=1))


def _fewer(scene: Scene, critic: Critic) -> tuple[Scene, int]:
    found = with_fewer_stops(scene, critic, Watch())
    assert found.gradients is not None
    return found, 1 if int(found.gradients.kind[0]) == FLAT else int(found.gradients.all_stops().count[0])


def _error(critic: Critic, scene: Scene) -> float:
    return float(critic.error(scene).sum())


def test_a_jump_where_the_picture_has_a_bend_becomes_the_bend() -> None:
    critic = _critic(picture(_painted((0.0, _DARK), (0.5, _DARK), (1.0, _LIGHT))))
    jump = _painted((0.0, _DARK), (0.56, _DARK), (0.56, (75, 59, 36)), (1.0, _LIGHT))
    found, count = _fewer(jump, critic)
    assert count == 2  # the flat part is the pad before the first stop
    assert _error(critic, found) < 0.2 * _error(critic, jump)
    assert found.gradients is not None
    assert found.gradients.geometry[0].tolist() == pytest.approx([32.0, 0.0, 60.0, 0.0], abs=0.1)


def test_stops_that_the_picture_shows_stay() -> None:
    bent = _painted((0.0, _DARK), (0.4, _LIGHT), (1.0, _DARK))
    assert _fewer(bent, _critic(picture(bent)))[1] == 3
    real = _painted((0.0, _DARK), (0.5, _DARK), (0.501, _LIGHT), (1.0, _DARK))
    assert _fewer(real, _critic(picture(real)))[1] >= 3


def test_a_gradient_of_one_colour_becomes_that_colour() -> None:
    critic = _critic(picture(_painted((0.0, _LIGHT), (1.0, _LIGHT))))
    found, count = _fewer(_painted((0.0, _LIGHT), (0.5, (180, 165, 36)), (1.0, _LIGHT)), critic)
    assert count == 1
    assert (255.0 * found.color[0]).tolist() == pytest.approx(_LIGHT, abs=0.2)


def test_places_make_up_for_colours_that_become_whole_levels() -> None:
    truth = _painted((0.0, _DARK), (1.0, _LIGHT))
    critic = _critic(picture(truth))
    assert truth.gradients is not None
    share = torch.tensor([[0.4 / 60.0]])  # a gradient of the same slope whose ends lie 0.2 pixels further out
    spread = truth.gradients.geometry + torch.tensor([[-0.2, 0.0, 0.2, 0.0]])
    change = 0.5 * share * (truth.gradients.end_color - truth.color)
    paints = replace(truth.gradients, geometry=spread, end_color=truth.gradients.end_color + change)
    start = replace(truth, color=truth.color - change, gradients=paints)
    found = with_whole_levels(start, critic, Watch())
    assert found.gradients is not None
    assert (255.0 * found.color[0]).tolist() == pytest.approx(_DARK, abs=1e-3)
    assert (255.0 * found.gradients.end_color[0]).tolist() == pytest.approx(_LIGHT, abs=1e-3)
    assert found.gradients.geometry[0, ::2].tolist() == pytest.approx([4.0, 60.0], abs=0.1)
