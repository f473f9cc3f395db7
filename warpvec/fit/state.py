"""The state of a fit as plain values, and when to save it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from torch import Tensor

State = dict[str, Any]
"""What a part of a fit is made of: tensors, numbers, lists, None, and such dictionaries."""


@dataclass(frozen=True)
class Saving:
    """``save`` is called with the fit's state after every ``every``-th iteration."""

    every: int
    save: Callable[[State], None]


def digest(target: Tensor) -> str:
    """SHA-256 of a target's shape and pixels."""
    pixels = target.detach().cpu().contiguous().numpy()
    return hashlib.sha256(repr(pixels.shape).encode() + pixels.tobytes()).hexdigest()
