"""Straight lines as cubics: their handles lie at thirds."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

Points = TypeVar("Points", Tensor, NDArray[np.float64])


def thirds(start: Points, end: Points) -> tuple[Points, Points]:
    """Return the leaving and the arriving handles [..., 2] of lines from ``start`` to ``end`` [..., 2]."""
    return start + (end - start) / 3.0, start + (end - start) * 2.0 / 3.0
