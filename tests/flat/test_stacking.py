"""Tests of warpvec.flat.layers.stacking: the order of regions, and parts of one shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flat_regions import box, disc, regions_of, split_regions

from warpvec.flat.layers.stacking import StackedLayer, stack
from warpvec.flat.regions.regions import find_regions
from warpvec.geometry.paints.registry import FLAT

RED, GREEN, BLUE, WHITE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.6, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0)


def members(layers: list[StackedLayer]) -> list[tuple[int, ...]]:
    return [tuple(sorted(layer.members)) for layer in layers]


def test_shape_on_another_lies_above_it() -> None:
    layers = stack(regions_of([(box(10, 10, 80, 80), RED), (disc(40, 40, 12), BLUE)]))
    assert members(layers) == [(1,), (2,)]
    assert layers[0].above == {2}
    assert layers[1].above == frozenset()


@pytest.mark.parametrize("small_in_front", [False, True])
def test_shape_whose_outline_goes_on_lies_in_front_whatever_its_size(small_in_front: bool) -> None:
    small, large = (disc(64, 44, 14), RED), (box(10.3, 20.2, 60.4, 80.1), BLUE)
    layers = stack(regions_of([large, small] if small_in_front else [small, large]))
    # Regions are numbered in the order in which they were painted.
    assert members(layers) == [(1,), (2,)]


def test_a_translucent_shape_lies_beneath_its_opaque_neighbours() -> None:
    glass = (*RED[:3], 0.5)
    # Its outline goes on, so it would lie in front. But there it would show a mix of both colours.
    layers = stack(regions_of([(box(10.3, 20.2, 60.4, 80.1), BLUE), (disc(64, 44, 14), glass)]))
    assert members(layers) == [(2,), (1,)]
    assert layers[0].above == {1}


def test_shape_in_a_larger_one_lies_above_it_though_a_third_opens_that_one() -> None:
    shapes = [(box(10, 20, 86, 90), RED), (disc(48, 55, 20), GREEN), (box(42.3, 5.2, 54.4, 50.1), BLUE)]
    assert members(stack(regions_of(shapes))) == [(1,), (2,), (3,)]


def test_belt_leaves_one_body() -> None:
    body, belt = box(30.2, 8.3, 66.4, 88.1), box(20.3, 40.2, 76.3, 56.4)
    regions = split_regions(regions_of([(body, RED), (belt, BLUE)]))
    assert len(regions) == 4
    layers = stack(regions)
    assert [len(layer.members) for layer in layers] == [2, 1]
    assert len(layers[0].parts) == 1


def test_two_pieces_of_one_paint_that_do_not_go_on_stay_apart() -> None:
    shapes = [(disc(20, 40, 10), RED), (box(28, 20, 62, 60), BLUE), (disc(76, 62, 10), RED)]
    assert len(stack(split_regions(regions_of(shapes)))) == 3


def test_paint_seen_through_a_hole_is_no_shape() -> None:
    shapes = [(box(8, 8, 88, 88), RED), (disc(48, 48, 30), BLUE), (disc(48, 48, 15), RED)]
    regions = split_regions(regions_of(shapes))
    layers = stack(regions)
    assert [len(layer.members) for layer in layers] == [2, 1]
    inner = int(regions.label[48, 48])
    assert inner in layers[0].members
    assert inner not in layers[1].above


def test_letters_of_the_paint_around_their_sign_lie_on_it() -> None:
    shapes = [(box(8, 8, 88, 88), RED), (box(16, 16, 80, 80), WHITE), (box(24, 30, 28, 66), RED)]
    regions = split_regions(regions_of(shapes))
    assert [len(layer.members) for layer in stack(regions)] == [1, 1, 1]


def test_holes_and_the_canvas_are_no_layers() -> None:
    ring = [(disc(48, 48, 30), BLUE), (disc(48, 48, 12), WHITE)]
    assert len(stack(split_regions(regions_of(ring, canvas=WHITE)))) == 1
    assert len(stack(regions_of(ring))) == 2
    assert stack(regions_of([])) == []


def test_shapes_of_one_paint_that_stand_alone_are_one_path() -> None:
    letters = [(disc(10 + 24 * k, 20, 10), RED) for k in range(4)]
    others = [(disc(10, 50, 8), BLUE), (disc(40, 50, 8), BLUE), (box(60, 40, 90, 90), BLUE), (disc(75, 65, 9), RED)]
    layers = stack(regions_of([*letters, *others]))
    assert sorted(len(layer.parts) for layer in layers) == [1, 1, 1, 1, 4]
    assert [len(layer.parts) for layer in stack(regions_of([*letters[:2], *others[2:]]))] == [1, 1, 1, 1]


def test_nothing_goes_on_beneath_translucent_paint() -> None:
    layers = stack(regions_of([(box(10, 10, 60, 60), RED), (disc(60, 40, 15), (0.0, 0.0, 1.0, 0.5))]))
    assert all(not layer.above or layer.above == {1} for layer in layers)
    assert np.all([2 not in layer.above for layer in layers])


def test_a_word_in_the_paint_of_the_canvas_is_a_layer_and_no_hole() -> None:
    regions = regions_of([(box(10, 10, 80, 80), BLUE), (box(30, 40, 32, 52), WHITE)], canvas=WHITE)
    word = replace(regions, is_lettering=np.arange(len(regions)) == 2)
    assert members(stack(regions)) == [(1,)]
    assert members(stack(word)) == [(1,), (2,)]


@pytest.mark.parametrize(("off", "count"), [(0.0, 2), (20.0, 1)])
def test_a_gradient_that_is_seen_through_a_ring_is_one_layer(off: float, count: int) -> None:
    """The ring lies on a gradient, which has other colours inside of it, or the same."""
    y, x = np.indices((96, 96)) + 0.5
    away = np.hypot(x - 48, y - 48)
    level = 60.0 + 1.5 * x + np.where(away < 14, off, 0.0)
    picture = np.stack([level, 0.5 * level, 40.0 + 0.0 * level], -1) / 255.0
    picture[(away >= 14) & (away < 22)] = (1.0, 1.0, 0.2)
    picture[np.maximum(abs(x - 48), abs(y - 48)) > 40] = 0.9
    regions = find_regions(picture.astype(np.float32))

    gradients = [layer for layer in stack(regions) if regions.paints.kind[layer.members[0]] != FLAT]

    assert [len(layer.members) for layer in gradients] == [count] * (3 - count)
