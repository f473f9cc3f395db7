"""Tests of warpvec.flat.regions.islands: small islands in grounds, and where islands touch several."""

from __future__ import annotations

import numpy as np

from warpvec.flat.regions.islands import Grounds, whole_islands
from warpvec.flat.regions.region_growing import NONE


def test_islands_of_one_ground_are_found_inside_of_large_ones_and_those_of_several_are_marked() -> None:
    shown = np.zeros((120, 120), np.int32)
    shown[:, 100:] = 7
    shown[10:110, [10, 89]] = shown[[10, 109], 10:90] = NONE  # larger than a letter, in one ground
    shown[20:30, 20:23] = shown[40, 40] = NONE
    shown[60, 95:105] = NONE  # in two
    islands, several = whole_islands(Grounds(shown, shown))
    assert [(each.box.tolist(), each.ground, len(each.pixels)) for each in islands] == [
        ([20, 20, 29, 22], 0, 30),
        ([40, 40, 40, 40], 0, 1),
    ]
    assert (several == ((shown == NONE) & (np.indices(shown.shape)[1] > 90))).all()
