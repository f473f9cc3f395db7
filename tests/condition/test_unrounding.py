"""Of the pictures that become the same JPEG, the one nearest to a drawing is found."""

from __future__ import annotations

import numpy as np
from damage import as_jpeg, drawn, levels_of
from sweep import sweep

from warpvec.condition.jpeg import Jpeg
from warpvec.condition.unrounding import JpegRounding


@sweep(("quality", "is_subsampled"), [(50, True), (80, True), (80, False)])
def test_the_picture_itself_is_possible_and_a_grey_one_becomes_what_was_decoded(
    quality: int, is_subsampled: bool
) -> None:
    clean = drawn(100)
    truth = levels_of(clean)
    rounding = JpegRounding(levels_of(as_jpeg(clean, quality, 2 if is_subsampled else 0)), Jpeg(quality, is_subsampled))
    damage = _difference(rounding.levels, truth)
    assert _difference(rounding.nearest(truth), truth) < 0.15 * damage
    # What nothing is known of becomes about what was decoded.
    gray = np.full_like(truth, 128.0)
    assert _difference(rounding.nearest(gray), truth) < 1.28 * damage


def _difference(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.sqrt(((one - other) ** 2).mean()))
