"""Layers of one colour: as few as the paths that overlap allow, with the same picture."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from flat_drawings import BLUE, RED, SIZE, drawing, picture

from warpvec.flat.color_layers.layering import layered
from warpvec.flat.color_layers.order import few_layers
from warpvec.flat.color_layers.overlaps import overlapping_paths

DARK_RED = (0.9 * RED[0], 0.9 * RED[1], 0.9 * RED[2])


def _polygon(*corners: tuple[float, float]) -> torch.Tensor:
    ends = torch.tensor(corners)
    share = torch.tensor([0.0, 1 / 3, 2 / 3])[None, :, None]
    return (ends[:, None] + share * (ends.roll(-1, 0) - ends)[:, None]).reshape(-1, 2)


def _square(left: float, top: float) -> torch.Tensor:
    return _polygon((left, top), (left + 10.0, top), (left + 10.0, top + 10.0), (left, top + 10.0))


@pytest.mark.parametrize(("left", "count"), [(40.0, 2), (15.0, 3)])
def test_a_colour_has_two_layers_only_where_another_one_lies_between(left: float, count: int) -> None:
    scene = drawing((RED, [_square(2, 2)]), (BLUE, [_square(10, 2)]), (RED, [_square(left, 2)]))
    found, names = layered(scene, SIZE, SIZE)
    assert len(names) == count == len(set(names.values()))
    assert (picture(found) == picture(scene)).all()


def test_shades_share_a_layer_unless_colours_are_asked_for() -> None:
    scene = drawing(
        (RED, [_square(2, 2)]), (BLUE, [_square(40, 2)]), (DARK_RED, [_square(8, 2)]), (RED, [_square(20, 30)])
    )
    found, names = layered(scene, SIZE, SIZE)
    assert len(names) == 2 and (picture(found) == picture(scene)).all()
    assert [name.endswith(", shaded") for name in names.values()].count(True) == 1
    assert max(len(name.split()) for name in names.values()) == 3
    assert len(layered(scene, SIZE, SIZE, joins_shades=False)[1]) == 3


def test_paths_overlap_where_they_meet_and_not_where_only_their_boxes_do() -> None:
    below, above = _polygon((0, 0), (40, 0), (0, 40)), _polygon((50, 10), (50, 50), (10, 50))
    scene = drawing((RED, [below]), (BLUE, [above]), (RED, [_square(45, 45)]))
    found = overlapping_paths(scene, SIZE, SIZE)
    assert found.tolist() == [[False, False, False], [False, False, True], [False, True, False]]


def test_paths_that_overlap_keep_their_order_in_layers_of_one_group(seed: None) -> None:
    for count in (0, 1, 5, 40):
        group = np.random.randint(0, 4, count)
        overlaps = np.triu(np.random.rand(count, count) < 0.15, 1)
        layers = few_layers(group, overlaps | overlaps.T)
        order = [path for layer in layers for path in layer]
        assert sorted(order) == list(range(count))
        assert all(len(set(group[layer].tolist())) == 1 for layer in layers)
        place = np.argsort(order)
        below, above = np.nonzero(overlaps)
        assert (place[below] < place[above]).all()


def test_a_layer_waits_for_what_its_group_can_take_later() -> None:
    """Two stacks, red over blue and blue over red: three layers, not the four of their painting order."""
    group = np.array([0, 1, 1, 0])
    overlaps = np.zeros((4, 4), bool)
    for one, other in ((0, 1), (2, 3)):
        overlaps[one, other] = overlaps[other, one] = True
    assert len(few_layers(group, overlaps)) == 3
