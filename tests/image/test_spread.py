"""Largest channels and differences of neighbours against SciPy's filters."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.image.spread import largest_channel, spread


def test_the_spread_is_that_of_filters_of_three_by_three() -> None:
    levels = np.random.default_rng(0).integers(0, 256, (7, 5, 3)).astype(np.int16)
    expected = ndimage.maximum_filter(levels, (3, 3, 1)) - ndimage.minimum_filter(levels, (3, 3, 1))
    np.testing.assert_array_equal(spread(levels), expected.max(2))
    np.testing.assert_array_equal(largest_channel(levels), levels.max(2))
