"""Circles: a centre and a radius."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from warpvec.geometry.forms.form import FIRST, Floats, Form, X, Y
from warpvec.geometry.quarter import QUARTER_HANDLE

_ENDS = torch.tensor([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]], dtype=torch.float64)
_NEXT = _ENDS.roll(-1, 0)

QUARTERS = torch.stack([_ENDS, _ENDS + QUARTER_HANDLE * _NEXT, _NEXT + QUARTER_HANDLE * _ENDS], 1)
"""Control points [4, 3, 2] of the circle of radius 1 about 0, from the right on."""


class Circle(Form):
    """A circle about x, y; its first size is the radius."""

    name, element, sides = "circle", "circle", ("cx", "cy", "r")
    turns = False
    free = (X, Y, FIRST)
    is_line = (False,) * 4
    basis = torch.stack([QUARTERS, 0 * QUARTERS, 0 * QUARTERS])

    def numbers(self, parameters: Tensor) -> Tensor:
        """Return cx, cy and r [K, 3]."""
        return parameters[:, :3]

    def parameters(self, numbers: Tensor, angle: Tensor) -> Tensor:
        """Return the parameters [K, 6]."""
        return torch.cat([numbers, torch.zeros_like(numbers)], 1)

    def distances(self, parameters: Floats, points: Floats) -> Floats:
        """Return the signed distances [K]."""
        distances: Floats = np.hypot(*(points - parameters[:2]).T) - parameters[FIRST]
        return distances

    def guesses(self, points: Floats) -> list[Floats]:
        """Return the circle with the least squares of its equation."""
        terms = np.concatenate([points, np.ones((len(points), 1))], 1)
        across, down, rest = np.linalg.lstsq(terms, np.square(points).sum(1), rcond=None)[0]
        squared = rest + (across**2 + down**2) / 4
        return [np.array([across / 2, down / 2, np.sqrt(squared), 0, 0, 0])] if squared > 0 else []

    def bounded(self, parameters: Floats) -> Floats | None:
        """Return the parameters if the radius is positive."""
        return parameters if parameters[FIRST] > 0 and np.isfinite(parameters).all() else None
