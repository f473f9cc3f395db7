"""Which region lies above which, and what a layer covers below others."""

from __future__ import annotations

import numpy as np
import pytest
from flat_regions import box, disc, regions_of, split_regions

from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.layers.covering import chosen, cover_of, mixed
from warpvec.flat.layers.hidden_borders import is_in, with_simple_hidden_borders
from warpvec.flat.layers.junctions import border_shares, evidence_above, find_junctions
from warpvec.flat.layers.merging import alike, interrupted_pairs
from warpvec.watch.watch import Watch

INK, GOLD, TEAL = (0.0, 0.0, 0.3, 1.0), (0.9, 0.7, 0.0, 1.0), (0.0, 0.5, 0.5, 1.0)
WHITE = (1.0, 1.0, 1.0, 1.0)


def test_the_disc_on_a_border_lies_above_both_sides() -> None:
    regions = regions_of([(box(32, 0, 64, 64), INK), (disc(32, 32, 14), GOLD)], 64, 64, WHITE)
    above = evidence_above(find_junctions(regions, np.arange(3)), 3)
    assert above[2, 0] > 0.5 and above[2, 1] > 0.5
    np.testing.assert_allclose(above, -above.T)


def test_no_junction_is_looked_for_once_the_time_is_up() -> None:
    regions = regions_of([(box(32, 0, 64, 64), INK), (disc(32, 32, 14), GOLD)], 64, 64, WHITE)
    assert len(find_junctions(regions, np.arange(3)).region) > 0
    assert len(find_junctions(regions, np.arange(3), Watch(time_budget=0.0)).region) == 0


def test_shares_of_borders_are_counted_by_sides_of_pixels() -> None:
    label = np.zeros((4, 6), np.int32)
    label[:, 4:], label[1:3, 2:4] = 2, 1
    shares = border_shares(label, 3)
    np.testing.assert_allclose(shares[1], [6 / 8, 0, 2 / 8])
    np.testing.assert_allclose(shares.sum(1), 1.0)


def _crossed() -> tuple:
    """Return a level bar that an upright bar interrupts, and a short one that ends at it."""
    shapes = [(box(6, 26, 58, 36), INK), (box(26, 4, 38, 60), GOLD), (box(6, 46, 26, 54), INK)]
    regions = split_regions(regions_of(shapes, 64, 64, WHITE))
    places = {"left": (31, 10), "right": (31, 54), "upright": (31, 32), "alone": (50, 12)}
    return regions, {name: int(regions.label[place]) for name, place in places.items()}


def test_the_two_parts_of_a_bar_behind_another_are_one_pair() -> None:
    regions, number = _crossed()
    others = np.array([number["alone"], number["upright"]])
    assert alike(regions, number["left"], others).tolist() == [True, False]
    order = [regions.canvas, number["left"], number["right"], number["alone"], number["upright"]]
    junctions = find_junctions(regions, np.array(order))
    assert list(interrupted_pairs(regions, junctions, order)) == [(number["left"], number["right"])]


def test_a_layer_goes_on_beneath_what_hides_it_and_keeps_off_its_far_edge() -> None:
    regions, number = _crossed()
    cover = cover_of(regions, [number["left"], number["right"]], [number["upright"]])
    row = 31 - int(cover.corner[1])
    start = int(cover.corner[0])
    assert cover.coverage[row, 6 - start : 58 - start] == pytest.approx(1.0)
    assert cover.shown[row, 28 - start : 36 - start].max() == 0.0
    beside = cover.coverage[16 - int(cover.corner[1]) : 21 - int(cover.corner[1])]
    assert beside[:, 32 - start].min() == 1.0  # in the middle of the upright bar
    assert beside[:, [26 - start, 27 - start, 36 - start, 37 - start]].max() == 0.0
    alone = cover_of(regions, [number["alone"]], [])
    assert (alone.coverage == alone.shown).all() and not alone.above.any()


def test_shares_of_chosen_regions_add_up() -> None:
    regions = regions_of([(disc(32, 32, 14.3), GOLD)], 64, 64, WHITE)
    one, other = (mixed(regions, chosen(regions, [number])) for number in (0, 1))
    np.testing.assert_allclose(one + other, 1.0)
    assert float(other.sum()) == pytest.approx(np.pi * 14.3**2, rel=0.005)


def test_a_hidden_detour_becomes_few_lines_and_what_shows_stays() -> None:
    """A box whose right half is hidden, where its border runs in zigzags."""
    regions = regions_of([(box(8, 16, 40, 48), INK), (box(24, 4, 60, 60), GOLD)], 64, 64, WHITE)
    cover = cover_of(regions, [1], [2])
    zigzag = np.array([[26 + (k % 2) * 6, 16 + k] for k in range(33)], float)
    shown = np.array([[24, 48], [8, 48], [8, 16], [24, 16]], float)
    loop = np.concatenate([shown, zigzag]) - cover.corner
    found = with_simple_hidden_borders(loop, np.arange(len(loop)) >= 4, cover)
    assert len(found) <= 4 + 2 * LAYERS.links_max
    assert {(8.0, 48.0), (8.0, 16.0)} <= {tuple(point) for point in (found + cover.corner).tolist()}
    assert with_simple_hidden_borders(loop, np.zeros(len(loop), bool), cover) is loop
    assert is_in(cover.above, np.array([[30.0, 30.0], [10.0, 30.0], [-5.0, 3.0]]) - cover.corner).tolist() == [
        True, False, False,
    ]  # fmt: skip
