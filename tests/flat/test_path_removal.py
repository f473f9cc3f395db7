"""Paths and loops that a picture hardly shows are removed, and no others."""

from __future__ import annotations

import torch
from flat_drawings import BLACK, BLUE, RED, SIZE, drawing, error, picture
from scenes import circle, rectangle

from warpvec.config.fit_config import FitConfig
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.path_removal import remove_paths
from warpvec.geometry.scene import Scene
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1)

SQUARE = (RED, [rectangle(10.2, 10.2, 50.2, 50.2)])


def kept_paths(scene: Scene, image: torch.Tensor) -> list[int]:
    """Return the numbers of the paths that stay; each has its own as its generation."""
    return remove_paths(scene, Critic(image, CONFIG), Watch())[0].generation.tolist()


def test_a_sliver_along_an_edge_goes_and_a_stroke_stays():
    for thickness, numbers in ((0.05, [0]), (1.0, [0, 1])):
        scene = drawing(SQUARE, (BLACK, [rectangle(10.2, 50.2, 50.2, 50.2 + thickness)]))

        assert kept_paths(scene, picture(scene)) == numbers


def test_a_path_that_the_picture_does_not_show_goes_however_large():
    image = picture(drawing(SQUARE))

    assert kept_paths(drawing(SQUARE, (BLUE, [rectangle(20, 20, 60, 60)])), image) == [0]


def test_one_of_two_equal_paths_stays():
    image = picture(drawing(SQUARE))

    found, loop_count = remove_paths(drawing(SQUARE, SQUARE, SQUARE), Critic(image, CONFIG), Watch())

    assert (len(found), loop_count) == (1, 0)
    assert error(found, image) < 0.1


def test_hidden_paths_go():
    scene = drawing((BLUE, [circle(30, 30, 12)]), SQUARE, (BLACK, [circle(30, 30, 8)]))

    assert kept_paths(scene, picture(scene)) == [1, 2]


def test_a_hole_under_another_path_goes_and_one_that_shows_stays():
    hole, shown = circle(20, 20, 4).flip(0).roll(1, 0), circle(40, 40, 4).flip(0).roll(1, 0)
    cover = (BLUE, [rectangle(14, 14, 26, 26)])
    scene = drawing((RED, [SQUARE[1][0], hole, shown]), cover)
    image = picture(scene)

    found, loop_count = remove_paths(scene, Critic(image, CONFIG), Watch())

    assert (len(found), loop_count) == (2, 1)
    assert found.structure.path_first_loop.tolist() == [0, 2, 3]
    assert error(found, image) < 0.1


def test_a_hidden_outline_around_a_shown_inside_stays():
    # Nothing shows of the edge of the square but much of its inside.
    frame = [rectangle(4, 4, 56, 56), rectangle(16, 16, 44, 44).flip(0).roll(1, 0)]
    hidden = circle(7, 30, 1.5)
    scene = drawing((RED, [rectangle(10, 10, 50, 50), hidden, circle(60, 60, 2)]), (BLUE, frame))
    image = picture(scene)

    found, loop_count = remove_paths(scene, Critic(image, CONFIG), Watch())

    assert (len(found), loop_count) == (2, 1)
    assert error(found, image) < 0.1


def test_nothing_is_removed_from_an_empty_drawing():
    scene = drawing(SQUARE).select(torch.zeros(0, dtype=torch.int64))

    found, loop_count = remove_paths(scene, Critic(torch.ones(SIZE, SIZE, 3), CONFIG), Watch())

    assert (len(found), loop_count) == (0, 0)
