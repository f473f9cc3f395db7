"""Types of NumPy arrays, by the numbers that they hold."""

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
