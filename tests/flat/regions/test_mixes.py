"""Which regions a pixel is a mix of, where the mix is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flat_pictures import flat_paints, opaque

from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions import assignment
from warpvec.flat.regions.assignment import assign
from warpvec.flat.regions.noise import measure_tolerances
from warpvec.flat.regions.region_growing import NONE
from warpvec.flat.regions.unmixing import (
    Candidates,
    best_mixes,
    explain_by_three,
    nearest_labels,
    pair_shares,
    triple_shares,
)

RED, GREEN, BLUE = np.eye(3, dtype=np.float32)


def test_shares_of_two_colours_are_exact() -> None:
    share, rest = pair_shares(0.3 * RED + 0.7 * BLUE, RED, BLUE)
    assert float(share) == pytest.approx(0.3) and float(rest) == pytest.approx(0.0, abs=1e-6)
    beyond, left = pair_shares(1.5 * RED - 0.5 * BLUE, RED, BLUE)
    assert float(beyond) == 1.0 and float(left) > 0.3


def test_shares_of_three_colours_are_exact_unless_they_lie_on_a_line() -> None:
    color = 0.2 * RED + 0.5 * GREEN + 0.3 * BLUE
    shares, rest = triple_shares(color[None], np.stack([RED, GREEN, BLUE])[None])
    np.testing.assert_allclose(shares[0], [0.2, 0.5, 0.3], atol=1e-6)
    assert rest[0] == pytest.approx(0.0, abs=1e-6)
    on_a_line = np.stack([RED, BLUE, (RED + BLUE) / 2])[None]
    assert (triple_shares(color[None], on_a_line)[0] < 0).all()


def test_of_pairs_that_explain_a_pixel_the_nearest_does() -> None:
    """Grey between black and white, of which one pair is near and one is far."""
    values = np.array([0.0, 1.0, 0.0, 1.0], np.float32)[None, :, None] * np.ones((1, 1, 3), np.float32)
    squared = np.array([[1.0, 4.0, 1.0, 1.0]], np.float32)
    mixes = best_mixes(
        np.full((1, 3), 0.6, np.float32), values, Candidates(np.arange(4, dtype=np.int32)[None], squared)
    )
    assert (int(mixes.label[0]), int(mixes.other[0])) == (3, 0)
    assert float(mixes.share[0]) == pytest.approx(0.6)


def test_three_regions_are_taken_where_two_leave_too_much() -> None:
    candidates = Candidates(np.arange(3, dtype=np.int32)[None], np.ones((1, 3), np.float32))
    color, values = (0.5 * RED + 0.3 * GREEN + 0.2 * BLUE)[None], np.stack([RED, GREEN, BLUE])[None]
    two = best_mixes(color, values, candidates)
    three = explain_by_three(two, color, values, candidates, np.zeros((1, 3), bool))
    assert float(two.residual[0]) > 0.05 > 1e-5 > float(three.residual[0])
    assert (int(three.label[0]), int(three.other[0])) == (0, 1)
    assert float(three.share[0]) == pytest.approx(0.5 / 0.8)


def test_the_nearest_labels_come_first() -> None:
    labels = np.full((7, 7), NONE, np.int32)
    labels[3, 5], labels[3, 0], labels[6, 6] = 4, 2, 9
    found = nearest_labels(labels, np.array([3], np.int32), np.array([3], np.int32), 3)
    assert found.label[0].tolist() == [4, 2, 9, NONE]
    assert found.squared[0, :3].tolist() == [4.0, 9.0, 18.0]


@pytest.mark.parametrize("covered", [0.25, 0.6])
def test_an_edge_has_the_share_that_it_covers(covered: float) -> None:
    share = np.where(np.arange(12) < 5, 1.0, 0.0)
    share[5] = covered
    colors = share[None, :, None] * RED + (1 - share)[None, :, None] * BLUE + np.zeros((10, 1, 1))
    seeds = np.tile(np.where(np.arange(12) < 5, 0, np.where(np.arange(12) > 5, 1, NONE)), (10, 1)).astype(np.int32)
    picture = opaque(colors)
    found = assign(picture, seeds, flat_paints((1, 0, 0), (0, 0, 1)), measure_tolerances(picture), None)
    first = 0 if covered > 0.5 else 1
    assert (found.label[:, 5] == first).all() and (found.other[:, 5] == 1 - first).all()
    np.testing.assert_allclose(found.share[:, 5], max(covered, 1 - covered), atol=1e-3)
    assert found.is_pure[:, :5].all() and not found.is_pure[:, 5].any()


def test_parts_of_the_pixels_are_unmixed_as_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(0)
    picture = opaque(np.kron(random.random((4, 4, 3)), np.ones((8, 8, 1))) + 0.02 * random.random((32, 32, 3)))
    seeds = np.full((32, 32), NONE, np.int32)
    seeds[2:6, 2:6], seeds[20:23, 20:23] = 0, 1
    paints = flat_paints(*(tuple(picture[place, place, :3].tolist()) for place in (3, 21)))
    tolerances = measure_tolerances(picture)
    whole = assign(picture, seeds, paints, tolerances, None)
    monkeypatch.setattr(assignment, "REGIONS", replace(REGIONS, pixels_at_once=100))
    parts = assign(picture, seeds, paints, tolerances, None)
    for name in ("label", "other", "share", "residual"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))
