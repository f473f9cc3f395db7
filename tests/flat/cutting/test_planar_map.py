"""Curves that meet only in vertices, the faces between them, and slivers, for squares of known places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting import noding
from warpvec.flat.cutting.cut_edges import CutEdges
from warpvec.flat.cutting.noding import Chords, chords_of, noded
from warpvec.flat.cutting.planar_map import PlanarMap, planar_map
from warpvec.flat.cutting.slivers import without_slivers

Points = list[tuple[float, float]]


def _lines(*polygons: Points) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges of closed polygons as cubics [R, 4, 2], and the polygon of each edge [R]."""
    share, cubics, owner = np.linspace(0, 1, 4)[:, None], [], []
    for number, polygon in enumerate(polygons):
        points = np.array(polygon, np.float64)
        for start, end in zip(points, np.roll(points, -1, 0), strict=True):
            cubics.append(start + share * (end - start))
            owner.append(number)
    return np.array(cubics), np.array(owner)


def _square(left: float, top: float, right: float, bottom: float) -> Points:
    return [(left, top), (right, top), (right, bottom), (left, bottom)]


def _map(*polygons: Points) -> tuple[PlanarMap, np.ndarray, np.ndarray]:
    cubics, owner = _lines(*polygons)
    chords = noded(chords_of(cubics, np.ones(len(cubics), bool)))
    return planar_map(chords, owner, len(polygons)), cubics, owner


def test_lines_are_broken_where_they_cross() -> None:
    cubics, _ = _lines([(0, 0), (8, 8)], [(0, 6), (6, 0)])
    chords = noded(chords_of(cubics[[0, 2]], np.ones(2, bool)))
    assert len(chords) == 4
    ends = {tuple(place) for place in (np.concatenate([chords.start, chords.end]) / CUTTING.units).tolist()}
    assert ends == {(0, 0), (8, 8), (0, 6), (6, 0), (3, 3)}
    first = chords.select(chords.curve == 0)
    assert sorted(first.t_end.tolist()) == pytest.approx([3 / 8, 1.0])


def test_a_line_through_the_end_of_another_is_broken_there() -> None:
    cubics, _ = _lines([(0, 0), (8, 0)], [(4, 0), (4, 5)])
    chords = noded(chords_of(cubics[[0, 2]], np.ones(2, bool)))
    assert len(chords) == 3


def test_only_chords_that_are_near_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    side, compared, parts = 24, 0, noding._parts
    squares = [_square(8 * x, 8 * y, 8 * x + 4, 8 * y + 4) for x in range(side) for y in range(side)]

    def counted(counts: np.ndarray) -> object:
        nonlocal compared
        compared += int(counts.sum())
        return parts(counts)

    monkeypatch.setattr(noding, "_parts", counted)
    cubics, _ = _lines(*squares)
    chords = chords_of(cubics, np.ones(len(cubics), bool))
    assert len(noded(chords)) == len(chords) == 4 * side**2
    assert compared < 4 * len(chords)  # each side of a square has two neighbours, and is in two strips


@pytest.mark.parametrize("most", [1, 50, 10**6])
def test_all_pairs_of_chords_whose_boxes_overlap_are_found_once(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(noding, "CUTTING", replace(CUTTING, pairs_at_once=most))
    generator = np.random.default_rng(5)
    start = generator.integers(-9, 60, (40, 2)) * CUTTING.units
    end = start + generator.integers(-12, 12, (40, 2)) * CUTTING.units
    chords = Chords(start, end, np.arange(40), np.zeros(40), np.ones(40))
    low, high = np.minimum(start, end) - 1, np.maximum(start, end) + 1
    wanted = [
        (one, two)
        for one in range(40)
        for two in range(one + 1, 40)
        if (low[one] <= high[two]).all() and (low[two] <= high[one]).all()
    ]
    found = zip(*noding._near_pairs(chords), strict=True)
    assert sorted(tuple(sorted(map(int, pair))) for pair in found) == wanted


def test_chords_stay_near_their_curve() -> None:
    handle = 10 * 4 / 3 * np.tan(np.pi / 8)
    quarter = np.array([[[10, 0], [10, handle], [handle, 10], [0, 10]]])
    chords: Chords = chords_of(quarter, np.zeros(1, bool))
    middle = (chords.start + chords.end) / 2 / CUTTING.units
    assert np.abs(np.hypot(*middle.T) - 10).max() < 1.5 * CUTTING.chord_error + 10 * 3e-4
    assert 5 < len(chords) < 60


def test_two_squares_make_three_faces_of_known_area() -> None:
    mapped, *_ = _map(_square(0, 0, 10, 10), _square(5, 5, 15, 15))
    assert sorted(mapped.areas()[1:].tolist()) == pytest.approx([25, 75, 75])
    assert mapped.areas()[0] == pytest.approx(-175)
    assert sorted(mapped.winding.tolist()) == [[0, 0], [0, 1], [1, 0], [1, 1]]
    covered = {tuple(row): area for row, area in zip((mapped.winding != 0).tolist(), mapped.areas(), strict=True)}
    assert covered[True, True] == pytest.approx(25)


def test_a_square_in_another_is_a_face_inside_of_it() -> None:
    mapped, *_ = _map(_square(0, 0, 10, 10), _square(2, 2, 4, 4))
    covered = {tuple(row): area for row, area in zip((mapped.winding != 0).tolist(), mapped.areas(), strict=True)}
    assert covered[True, True] == pytest.approx(4)
    assert covered[True, False] == pytest.approx(96)


@pytest.mark.parametrize(("gap", "count"), [(0.04, 1), (2.0, 0)])
def test_a_sliver_between_two_edges_goes_to_a_neighbour(gap: float, count: int) -> None:
    """The upper square ends a little before the lower one; the last path is the canvas, which owns all."""
    mapped, _, owner = _map(_square(2, 2, 12, 12), _square(2, 2, 12 - gap, 12), _square(0, 0, 14, 14))
    is_covered = mapped.winding != 0
    owners = np.where(is_covered[:, 1], 1, np.where(is_covered[:, 0], 0, np.where(is_covered[:, 2], 2, 3)))
    found, gone = without_slivers(mapped, owners, owner[mapped.curve])
    assert gone == count
    assert (0 in found) == (count == 0)


def test_a_cut_curve_keeps_to_its_curve_and_both_sides_share_it() -> None:
    """A square with one bent edge, cut by a box over its lower half."""
    cubics, owner = _lines(_square(2, 2, 12, 12), _square(0, 7, 20, 20))
    cubics[1] = [(12, 2), (16, 5), (16, 9), (12, 12)]
    is_line = np.ones(len(cubics), bool)
    is_line[1] = False
    mapped = planar_map(noded(chords_of(cubics, is_line)), owner, 2)
    is_covered = mapped.winding != 0
    owners = np.where(is_covered[:, 1], 1, np.where(is_covered[:, 0], 0, 2))
    edges = CutEdges(mapped, owners, cubics, is_line)
    (upper,) = edges.loops(0)
    curved = [part for part in upper if not part.is_line]
    assert len(curved) == 1 and sum(part.is_line for part in upper) == len(upper) - 1
    np.testing.assert_allclose(curved[0].cubic[[0, -1], 1], [2, 7], atol=2 / CUTTING.units)
    halved = np.array([(12, 2), (14, 3.5), (15, 5.25), (15, 7)])
    np.testing.assert_allclose(curved[0].cubic, halved, atol=0.01)  # the half of the symmetric curve
    shared = [part.cubic for loop in edges.loops(1) for part in loop]
    bottom = next(
        part.cubic for part in upper if part.is_line and np.ptp(part.cubic[:, 1]) == 0 and part.cubic[0, 1] > 6
    )
    assert any(np.array_equal(bottom[::-1], cubic) for cubic in shared)
