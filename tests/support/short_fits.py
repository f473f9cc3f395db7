"""Results of short fits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import warpvec

Photo = NDArray[np.uint8]


def vectorize_briefly(photo: Any, curves: int | None = 8, **settings: Any) -> warpvec.Result:
    """Fit 8 paths in 3 iterations."""
    return warpvec.vectorize(photo, curves, **{"iterations": 3, **settings})
