"""Results of short fits."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

import warpvec

Photo = NDArray[np.uint8]


def vectorize_briefly(photo: Any, curves: int | None = 8, **settings: Any) -> warpvec.Result:
    """Fit 8 paths in 3 iterations, whatever the picture looks like."""
    return warpvec.vectorize(photo, curves, **{"iterations": 3, "mode": "photo", **settings})


def small_photo(transparent: bool = False) -> torch.Tensor:
    """Return a photo [40, 56, 3] of soft waves, or [40, 56, 4] with soft alpha."""
    rows, columns = torch.meshgrid(torch.linspace(0.0, 3.0, 40), torch.linspace(0.0, 4.0, 56), indexing="ij")
    phases = (rows + columns, rows - 2.0 * columns, 2.0 * rows * columns, rows + 0.5 * columns)
    return torch.stack([0.5 + 0.5 * phase.sin() for phase in phases[: 4 if transparent else 3]], -1)
