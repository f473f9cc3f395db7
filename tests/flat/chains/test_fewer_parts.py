"""Numbers that a picture does not need go; what it shows stays."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
import torch
from flat_drawings import BLACK, BLUE, RED, drawing, error, line_count, picture
from scenes import circle, rectangle, straight

from warpvec.config.fit_config import FitConfig
from warpvec.flat.chains import fewer_parts
from warpvec.flat.chains.fewer_parts import with_fewer_parts
from warpvec.flat.simplification.critic import Critic
from warpvec.geometry.joints import Joints
from warpvec.geometry.nodes import split
from warpvec.geometry.scene import Scene
from warpvec.watch.decisions import noted
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1)


def divided(scene: Scene) -> Scene:
    """Return ``scene`` with every segment in three parts."""
    rows = torch.arange(len(scene.segments)).repeat_interleave(2)
    return split(scene, rows, torch.tensor([0.3, 0.7]).repeat(len(scene.segments))).scene


def fewer(scene: Scene, image: torch.Tensor, detail: float = FitConfig.detail) -> Scene:
    return with_fewer_parts(scene, Critic(image, CONFIG), Watch(), detail)


@pytest.fixture(name="shapes")
def shapes_fixture() -> Scene:
    """A circle and, on top, a triangle."""
    return drawing((RED, [circle(24.3, 26.1, 19.2)]), (BLACK, [straight((30, 12), (58.5, 50.2), (14, 55))]))


def test_nodes_inside_of_curves_and_lines_go(shapes):
    image = picture(shapes)

    found = fewer(divided(shapes), image, detail=0.05)

    assert len(found.segments) <= 8
    assert line_count(found) == 3
    assert error(found, image) < 1.0


def test_corners_stay_sharp(shapes):
    found = fewer(divided(shapes), picture(shapes))

    distance = torch.cdist(shapes.segments[4:, 0], found.segments[:, 0]).amin(1)
    assert (distance < 0.1).all()


def test_a_plus_of_thin_strokes_keeps_its_lines():
    right = (20, 10), (21.1, 10), (21.1, 14), (24, 14), (24, 15.1), (21.1, 15.1)
    left = (21.1, 20), (20, 20), (20, 15.1), (17, 15.1), (17, 14), (20, 14)
    scene = drawing((BLACK, [straight(*right, *left)]))

    assert line_count(fewer(scene, picture(scene))) == 12


def test_a_notch_of_three_pixels_stays_and_one_of_a_twentieth_goes():
    for depth, segment_count in ((3.0, 7), (0.05, 4)):
        square = straight((10, 10), (30, 10), (33, 10 + depth), (36, 10), (50, 10), (50, 50), (10, 50))
        scene = drawing((BLACK, [square]))

        found = fewer(scene, picture(scene))

        assert len(found.segments) == line_count(found) == segment_count


def test_smooth_nodes_stay_smooth():
    scene = divided(drawing((BLUE, [circle(32, 32, 20, 5)])))

    assert Joints.of(fewer(scene, picture(scene))).is_smooth.all()


def test_waves_that_are_hidden_are_said_roughly():
    waves = torch.tensor([(30.0 + 2 * math.sin(k / 3), 12.0 + 0.7 * k) for k in range(1, 60)])
    scene = drawing((RED, [straight((6, 10), (30, 10), *waves.tolist(), (30, 54), (6, 54))]))
    hidden = scene.joined(drawing((BLUE, [rectangle(26, 4, 60, 60)])))
    found = [fewer(each, picture(each)) for each in (scene, hidden)]

    assert len(found[1].segments) - 4 < len(found[0].segments)
    assert error(found[1], picture(hidden)) < 0.5


def test_a_hidden_outline_does_not_cross_what_shows_on_its_way():
    notched = straight((10, 10), (40, 10), (40, 24), (32, 24), (32, 36), (40, 36), (40, 50), (10, 50))
    window = rectangle(34, 26, 38, 34).flip(0).roll(1, 0)  # it shows the canvas, not the red path
    scene = drawing((RED, [notched]), (BLUE, [rectangle(20, 4, 60, 60), window]))

    assert error(fewer(scene, picture(scene)), picture(scene)) < 0.1


def test_one_loop_that_must_stay_does_not_keep_the_others():
    wave = straight((8, 8), (14, 11), (20, 8), (26, 11), (32, 8), (32, 24), (8, 24))
    scene = divided(drawing((BLACK, [wave]), (RED, [circle(40, 44, 14)])))

    found = fewer(scene, picture(scene))

    assert line_count(found) == 7
    assert len(found.segments) <= 7 + 5


def test_what_was_weighed_is_told(shapes):
    with noted() as found:
        fewer(divided(shapes), picture(shapes))

    assert {(each.stage, each.before, each.is_taken) for each in found} >= {("parts", "9 segments", True)}


def test_an_empty_drawing_stays_empty(shapes):
    found = fewer(shapes.select(torch.zeros(0, dtype=torch.int64)), picture(shapes))

    assert len(found) == 0


def test_a_fit_that_goes_wrong_is_undone(shapes, monkeypatch):
    scene = divided(shapes)

    def recolored(target, scene, *others, **settings):
        return SimpleNamespace(scene=replace(scene, color=1.0 - scene.color))

    monkeypatch.setattr(fewer_parts, "polish", recolored)

    assert fewer(scene, picture(shapes)) is scene
