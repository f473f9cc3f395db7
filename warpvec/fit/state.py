"""The state of a fit as plain values, and when it is saved."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from torch import Tensor

State = dict[str, Any]
"""The state of a part of a fit: tensors, numbers, strings, lists of plain values, None, and dictionaries of these."""


@dataclass(frozen=True)
class Saving:
    """A request to call ``save`` with the fit's state after every ``every``-th iteration."""

    every: int
    save: Callable[[State], None]


def digest(target: Tensor) -> str:
    """Return the SHA-256 of a target's shape and pixels."""
    pixels = target.detach().cpu().contiguous().numpy()
    return hashlib.sha256(repr(pixels.shape).encode() + pixels.tobytes()).hexdigest()
