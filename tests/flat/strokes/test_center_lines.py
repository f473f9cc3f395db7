"""Centre lines whose handles have no length."""

from __future__ import annotations

import numpy as np

from warpvec.flat.strokes.center_lines import _miter_tips
from warpvec.flat.strokes.line_fitting import Rows


def test_a_corner_between_handles_of_no_length_has_no_tip() -> None:
    anchors = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    control = np.stack([anchors, anchors, np.roll(anchors, -1, 0)], 1)
    assert _miter_tips(Rows(control, np.zeros(3, bool), is_open=True), 2.0) == []
