"""Types of NumPy arrays, by the numbers that they hold, and counting in many runs at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Integers = NDArray[np.int64]
Integers32 = NDArray[np.int32]
Mask = NDArray[np.bool_]
Places = NDArray[np.intp]
"""Positions in an array, as `numpy.nonzero` returns them."""


def counted(counts: Integers) -> Integers:
    """Return 0, 1, ... below each of ``counts`` [n], one run after the other."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
