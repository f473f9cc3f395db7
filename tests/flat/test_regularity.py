"""Outlines become ellipses where the picture cannot tell the difference, and only there."""

from __future__ import annotations

import pytest
import torch
from flat_drawings import BLACK, BLUE, RED, SIZE, drawing, error, picture
from scenes import circle, rectangle, straight

from warpvec.config.fit_config import FitConfig
from warpvec.flat.simplification.accepted_changes import accepted_loops
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.regularity import regularize
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1)


@pytest.mark.parametrize("clockwise", [True, False])
def test_a_circle_of_two_cubics_becomes_four_arcs(clockwise):
    image = picture(drawing((RED, [circle(30.2, 32.7, 12.0)])))
    rough = circle(30.2, 32.7, 12.05, 2)
    rough = rough if clockwise else rough.flip(0).roll(1, 0)
    scene = drawing((RED, [rough]))

    found = regularize(scene, Critic(image, CONFIG), Watch())

    nodes, middles = found.segments[:, 0], torch.tensor([1.0, 3.0, 3.0, 1.0]) @ whole_curves(found) / 8.0
    assert len(nodes) == 4
    radii = (torch.cat([nodes, middles]) - nodes.mean(0)).norm(dim=1)
    assert radii.max() - radii.min() < 0.01
    torch.testing.assert_close(nodes.mean(0), torch.tensor([30.2, 32.7]), atol=0.1, rtol=0)
    assert (nodes - nodes.mean(0)).abs().amin(1).max() < 1e-4
    assert _area(found) * _area(scene) > 0.0
    assert error(found, image) < error(scene, image)


def test_a_circle_is_not_closed_where_a_hole_would_lie_outside_of_it():
    window = rectangle(48, 48, 56, 56).flip(0).roll(1, 0)
    disk, seen = circle(23, 23, 13.0), circle(23, 23, 11.0)
    cover = (BLUE, [rectangle(2, 2, 62, 62), seen.flip(0).roll(1, 0), window])
    scene = drawing((RED, [straight((8, 8), (40, 8), (60, 40), (60, 60), (40, 60), (8, 40)), window]), cover)
    image = picture(scene)
    critic = Critic(image, CONFIG)

    found = accepted_loops(scene, {0: disk.reshape(-1, 3, 2).numpy()}, critic, critic.samples(scene), 0.05)

    assert error(found, image) < 0.1


def test_an_ellipse_that_is_partly_hidden_becomes_whole_below():
    ellipse = circle(0, 0, 1) * torch.tensor([22.0, 13.0]) + torch.tensor([30.0, 34.0])
    cover = (BLUE, [rectangle(40.3, 2, 62, 62)])
    image = picture(drawing((RED, [ellipse]), cover))
    rough = ellipse.reshape(-1, 3, 2)[:, 0] + torch.tensor([[0.0, 0.0], [0.0, 0.2], [-0.2, 0.0], [0.0, -0.2]])
    shifted = ellipse.reshape(-1, 3, 2).clone()
    shifted += (rough - shifted[:, 0])[:, None] * torch.tensor([1.0, 1.0, 0.0])[:, None]
    scene = drawing((RED, [shifted.reshape(-1, 2)]), cover)

    found = regularize(scene, Critic(image, CONFIG), Watch())

    nodes = found.segments[:4, 0]
    assert sorted(set(nodes[:, 1].tolist()))[1] == pytest.approx(34.0, abs=0.2)
    assert len(set(nodes[:, 1].tolist())) == 3  # level: two of the nodes have one height
    assert error(found, image) <= error(scene, image) + 0.05


def test_a_square_with_bulges_is_no_circle():
    bulged = torch.tensor([[20.0, 10], [28, 8], [36, 8], [44, 10], [48, 20], [48, 28], [44, 44], [36, 48], [28, 48],
                           [20, 44], [16, 36], [16, 20]])  # fmt: skip
    scene = drawing((RED, [bulged]))

    found = regularize(scene, Critic(picture(scene), CONFIG), Watch())

    torch.testing.assert_close(found.segments, scene.segments, atol=0.2, rtol=0)


def test_an_empty_drawing_stays_empty():
    scene = drawing((BLACK, [rectangle(1, 1, 2, 2)])).select(torch.zeros(0, dtype=torch.int64))

    assert len(regularize(scene, Critic(torch.ones(SIZE, SIZE, 3), CONFIG), Watch())) == 0


def _area(scene: Scene) -> float:
    """Return twice the area of the polygon of all control points, which has the sign of the direction."""
    x, y = scene.segments.reshape(-1, 2).T
    return float((x * y.roll(-1) - y * x.roll(-1)).sum())
