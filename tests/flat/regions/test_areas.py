"""Areas of one label: lines that pass corners, lines between two pixels, specks, and paints that are one."""

from __future__ import annotations

import numpy as np
import pytest
from flat_pictures import assignment_of, flat_paints, opaque, pure
from scipy import ndimage

from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.hairlines import keep_hairlines
from warpvec.flat.regions.label_areas import areas_of, most_contact
from warpvec.flat.regions.noise import measure_tolerances
from warpvec.flat.regions.region_merging import pool_paints
from warpvec.flat.regions.specks import SpeckLimits, specks_of

METRIC = np.eye(4, dtype=np.float32)


@pytest.mark.parametrize(("share", "count"), [(0.7, 1), (0.52, 5)])
def test_a_diagonal_line_is_one_area_if_it_has_enough_of_the_corners(share: float, count: int) -> None:
    """The line is one label on the diagonal, which has ``share`` there and the rest of the pixels beside it."""
    label = np.eye(5, dtype=int)
    near = np.eye(5, k=1, dtype=int) | np.eye(5, k=-1, dtype=int)
    rest = 1 - share if count == 1 else 0.0
    other = np.where(near, 1 if rest else 0, 0) * (1 - label)
    shares = np.where(label, share, np.where(near & (rest > 0), 1 - rest / 2, 1.0))
    areas = areas_of(assignment_of(label.tolist(), other.tolist(), shares.tolist()))
    assert len(np.unique(areas[np.eye(5, dtype=bool)])) == count


def test_contact_is_the_largest_part_of_a_border() -> None:
    """A square of 2 x 2 pixels with three sides to one label and one to another."""
    label = np.zeros((4, 6), np.int32)
    label[:, 4:] = 2
    label[1:3, 2:4] = 1
    areas = label.copy()
    assert most_contact(areas, label)[1] == pytest.approx(6 / 8)


@pytest.mark.parametrize("turned", [False, True])
def test_a_line_between_two_columns_gets_pixels_of_its_own(turned: bool) -> None:
    label, other, share = np.zeros((6, 8), int), np.zeros((6, 8), int), np.ones((6, 8))
    other[:, 3:5], share[:, 3], share[:, 4] = 1, 0.68, 0.58  # the line has 0.32 and 0.42
    arrays = [(values.T if turned else values).tolist() for values in (label, other, share)]
    found = assignment_of(*arrays)
    keep_hairlines(found, is_noisy=False)
    shown, rest = (values.T if turned else values for values in (found.label, found.share))
    assert (shown[1:-1, 4] == 1).all() and (shown[:, 3] == 0).all()
    np.testing.assert_allclose(rest[1:-1, 4], REGIONS.hairline_raised_share)
    np.testing.assert_allclose(1 - rest[1:-1, 3], 0.74 - REGIONS.hairline_raised_share, atol=1e-6)


def test_a_line_of_a_third_of_a_pixel_and_the_edge_of_a_wide_shape_stay() -> None:
    for third, wide in ((0.15, 0.0), (0.4, 0.9)):
        label, other, share = np.zeros((6, 8), int), np.zeros((6, 8), int), np.ones((6, 8))
        other[:, 3:5], share[:, 3:5] = 1, 1 - third
        if wide:
            label[:, 5], other[:, 5], share[:, 5] = 1, 0, wide
        found = assignment_of(label.tolist(), other.tolist(), share.tolist())
        keep_hairlines(found, is_noisy=False)
        assert (found.label == label).all()


def test_small_areas_are_specks_unless_they_stand_out() -> None:
    label = np.zeros((8, 10), int)
    label[2, 2:4], label[5, 2:4], label[2, 7], label[5:7, 6:9] = 1, 2, 2, 1
    faint, clear = (0.55, 0.5, 0.5), (1.0, 0.5, 0.5)
    paints = flat_paints((0.5, 0.5, 0.5), faint, clear)
    specks = specks_of(pure(label.tolist()), paints, METRIC, SpeckLimits(area=4.0, clear_area=1.5))
    assert sorted(zip(*(axis.tolist() for axis in np.nonzero(specks)), strict=True)) == [(2, 2), (2, 3), (2, 7)]


def test_colours_that_are_alike_become_that_of_the_largest_area() -> None:
    grey = np.array([0.5, 0.5, 0.5])
    tolerances = measure_tolerances(opaque(np.full((16, 16), 0.5)))
    level = tolerances.pool
    paints = flat_paints(*(tuple((grey + offset).tolist()) for offset in (0.0, 0.9 * level, 1.5 * level, 1.5 * level)))
    area = np.array([900, 1000, 500, REGIONS.small_area - 1])
    assert pool_paints(paints, area, tolerances).tolist() == [1, 1, 1, 1]
    far = flat_paints(*(tuple((grey + offset).tolist()) for offset in (0.0, 1.5 * level, -1.5 * level, 3.0 * level)))
    assert pool_paints(far, np.array([1000, 900, REGIONS.small_area - 1, 800]), tolerances).tolist() == [0, 1, 0, 3]


def test_holes_are_filled_as_scipy_does() -> None:
    chance = np.random.default_rng(3)
    for share in np.linspace(0.3, 0.9, 60):
        mask = chance.random(chance.integers(1, 14, 2)) < share
        np.testing.assert_array_equal(with_filled_holes(mask), ndimage.binary_fill_holes(mask))
