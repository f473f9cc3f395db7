"""Tests of warpvec.flat.regions.mark_writing: marks become regions of the mix."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.mark_writing import join_grounds
from warpvec.flat.regions.paint_fitting import flat_paints


def test_clear_grounds_beside_a_mark_are_one_whatever_color_they_hide() -> None:
    clear = flat_paints(np.array([[0, 0, 0, 0], [0, 0, 0, 0], [1, 1, 1, 1]], np.float32))
    paints = replace(clear, color=np.array([[1, 0, 0], [0, 1, 0], [1, 1, 1]], np.float32))
    label, share = np.array([[0, 1, 2]], np.int32), np.ones((1, 3), np.float32)
    found = Assignment(label, share > 0, label.copy(), label.copy(), share, 0 * share)
    join_grounds(found, [np.array([0, 1, 2], np.int32)], paints)
    assert found.label.tolist() == found.other.tolist() == [[0, 0, 2]]
    assert paints.first_alike().tolist() == [0, 0, 2]
