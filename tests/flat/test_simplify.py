"""Nodes that a picture does not need go; those that it shows stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from flat_drawings import BLACK, BLUE, RED, SIZE, drawing, error, line_count, picture
from scenes import circle, rectangle, straight

from warpvec.config.fit_config import FitConfig
from warpvec.flat.simplification.chosen_nodes import chosen_scene, with_spans_back
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.fewest_spans import fewest_spans
from warpvec.flat.simplification.outline_samples import sample_outlines
from warpvec.flat.simplification.simplify import outlines_of, simplify
from warpvec.geometry.joints import Joints
from warpvec.geometry.nodes import split
from warpvec.geometry.scene import Scene
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1)


def divided(scene: Scene) -> Scene:
    """Return ``scene`` with every segment in three parts."""
    rows = torch.arange(len(scene.segments)).repeat_interleave(2)
    return split(scene, rows, torch.tensor([0.3, 0.7]).repeat(len(scene.segments))).scene


@pytest.fixture(name="shapes")
def shapes_fixture() -> Scene:
    """A circle and, on top, a triangle."""
    return drawing((RED, [circle(24.3, 26.1, 19.2)]), (BLACK, [straight((30, 12), (58.5, 50.2), (14, 55))]))


def test_nodes_inside_of_curves_and_lines_are_dropped(shapes):
    image = picture(shapes)

    found = simplify(divided(shapes), Critic(image, CONFIG), Watch(), detail=0.05)

    assert len(found.segments) <= 7
    assert line_count(found) == 3
    assert error(found, image) < 1.0


def test_without_a_fit_dropped_nodes_leave_the_outline_where_it_is(shapes):
    image = picture(shapes)

    found = simplify(divided(shapes), Critic(image, CONFIG), Watch(), detail=0.02, iterations=0)

    assert len(found.segments) <= 7
    assert error(found, image) < 1.5


def test_corners_stay_sharp(shapes):
    found = simplify(divided(shapes), Critic(picture(shapes), CONFIG), Watch())

    corners = shapes.segments[4:, 0]
    distance = torch.cdist(corners, found.segments[:, 0]).amin(1)
    assert (distance < 0.1).all()


def test_a_plus_of_thin_strokes_keeps_its_lines():
    right = (20, 10), (21.1, 10), (21.1, 14), (24, 14), (24, 15.1), (21.1, 15.1)
    left = (21.1, 20), (20, 20), (20, 15.1), (17, 15.1), (17, 14), (20, 14)
    scene = drawing((BLACK, [straight(*right, *left)]))

    found = simplify(scene, Critic(picture(scene), CONFIG), Watch())

    assert line_count(found) == 12


def test_a_notch_of_three_pixels_stays_and_one_of_a_twentieth_goes():
    for depth, segment_count in ((3.0, 7), (0.05, 4)):
        square = straight((10, 10), (30, 10), (33, 10 + depth), (36, 10), (50, 10), (50, 50), (10, 50))
        scene = drawing((BLACK, [square]))

        found = simplify(scene, Critic(picture(scene), CONFIG), Watch(), iterations=0)

        assert len(found.segments) == line_count(found) == segment_count


def test_a_long_line_does_not_become_a_part_of_a_curve():
    points = straight((10, 10), (50, 10), (50, 50), (10, 50)).reshape(-1, 3, 2)
    points[1, 1:] = torch.tensor([[52.0, 10.1], [50.0, 12.0]])  # a curve that goes on straight at first
    scene = drawing((BLACK, [points.reshape(-1, 2)]))

    found = simplify(scene, Critic(picture(scene), CONFIG), Watch(), detail=1.0, iterations=0)

    assert line_count(found) == 3


def test_smooth_nodes_stay_smooth():
    scene = divided(drawing((BLUE, [circle(32, 32, 20, 5)])))

    found = simplify(scene, Critic(picture(scene), CONFIG), Watch())

    assert Joints.of(found).is_smooth.all()


def test_a_kink_that_hardly_turns_becomes_a_smooth_node():
    scene = drawing((BLUE, [circle(32, 32, 20)]))
    image = picture(scene)
    bent = scene.segments.clone()
    bent[1, 1] += torch.tensor([0.0, 0.8])
    assert not Joints.of(replace(scene, segments=bent)).is_smooth[1]

    # The square beside it has a node to drop, or there would be nothing to do.
    square = drawing((BLACK, [straight((1, 1), (3, 1), (5, 1), (5, 5), (1, 5))]))
    image = picture(scene.joined(square))
    found = simplify(replace(scene, segments=bent).joined(square), Critic(image, CONFIG), Watch())

    assert Joints.of(found).is_smooth[:4].all()
    assert error(found, image) < 1.0


def test_hidden_nodes_go_whatever_their_outline_and_nothing_comes_out_of_hiding():
    teeth = [(30.0 + 6 * (k % 2), 12.0 + 2 * k) for k in range(1, 20)]
    comb = straight((6, 10), (30, 10), *teeth, (30, 54), (6, 54))
    cover = rectangle(26, 4, 60, 60)
    scene = drawing((RED, [comb]), (BLUE, [cover]))
    image = picture(scene)

    found = simplify(scene, Critic(image, CONFIG), Watch(), iterations=0)

    assert len(found.segments) <= 4 + 6
    assert error(found, image) < 0.1
    assert line_count(found) >= 3 + 4


def test_a_hidden_outline_does_not_cross_what_shows_on_its_way():
    notched = straight((10, 10), (40, 10), (40, 24), (32, 24), (32, 36), (40, 36), (40, 50), (10, 50))
    window = rectangle(34, 26, 38, 34).flip(0).roll(1, 0)  # it shows the canvas, not the red path
    scene = drawing((RED, [notched]), (BLUE, [rectangle(20, 4, 60, 60), window]))
    outlines = outlines_of(scene, sample_outlines(scene, SIZE, SIZE))

    choice = fewest_spans(outlines, np.full(len(scene.segments), 0.2), 0.5)

    found = chosen_scene(scene, choice, outlines.is_smooth[choice.first])
    assert error(found, picture(scene)) < 0.1
    closed = drawing((RED, [notched]), (BLUE, [rectangle(20, 4, 60, 60)]))
    fewer = fewest_spans(outlines_of(closed, sample_outlines(closed, SIZE, SIZE)), np.full(12, 0.2), 0.5)
    assert len(fewer.first) < len(choice.first) - 4  # the window has four


def test_contrast_is_that_of_the_colours_at_both_sides_and_none_where_hidden():
    scene = drawing((RED, [rectangle(8, 8, 40, 56)]), (BLUE, [rectangle(30, 4, 60, 60)]))

    samples = sample_outlines(scene, SIZE, SIZE)

    top, right, _, left = samples.contrast[:4]
    over_white = float((torch.ones(3) - torch.tensor(RED)).square().sum())
    np.testing.assert_allclose(left, over_white, rtol=1e-2)
    np.testing.assert_allclose(right, 0.0, atol=1e-4)
    np.testing.assert_allclose(top[:5], over_white, rtol=1e-2)
    np.testing.assert_allclose(top[-2:], 0.0, atol=1e-4)
    assert samples.is_hidden(np.array([0]), np.array([[[45.0, 30.0], [20.0, 30.0]]])).tolist() == [[True, False]]


def test_what_is_put_back_has_the_old_points():
    scene = divided(drawing((RED, [circle(30, 30, 20)]), (BLACK, [rectangle(4, 4, 20, 20)])))
    outlines = outlines_of(scene, sample_outlines(scene, SIZE, SIZE))
    choice = fewest_spans(outlines, np.full(len(scene.segments), 0.2), 0.5)
    simple = chosen_scene(scene, choice, outlines.is_smooth[choice.first])
    assert len(simple.segments) < 12

    nothing = np.zeros(len(simple.segments), np.bool_)
    back, row = with_spans_back(simple, scene, choice, ~nothing, nothing)

    moved = torch.from_numpy(np.argsort(row))
    torch.testing.assert_close(back.segments[moved], scene.segments, atol=1e-4, rtol=0)
    same, _ = with_spans_back(simple, scene, choice, nothing, nothing)
    torch.testing.assert_close(same.segments, simple.segments, atol=1e-4, rtol=0)


def test_an_empty_drawing_stays_empty(shapes):
    found = simplify(shapes.select(torch.zeros(0, dtype=torch.int64)), Critic(picture(shapes), CONFIG), Watch())

    assert len(found) == 0
