"""Ellipses: a centre, two half axes, and the angle of the first."""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor

from warpvec.geometry.forms.circle import QUARTERS
from warpvec.geometry.forms.form import ANGLE, FIRST, SECOND, Floats, Form, X, Y, turned_back

_SLOPE_MIN = 1e-9
"""Slope of the equation at the centre, where no direction leads to the outline."""


class Ellipse(Form):
    """An ellipse about x, y; its sizes are the half axes, the angle is that of the first."""

    name, element, sides = "ellipse", "ellipse", ("cx", "cy", "rx", "ry")
    turns = True
    free = (X, Y, FIRST, SECOND, ANGLE)
    is_line = (False,) * 4
    basis = torch.stack([QUARTERS * torch.tensor([1.0, 0.0]), QUARTERS * torch.tensor([0.0, 1.0]), 0 * QUARTERS])

    def numbers(self, parameters: Tensor) -> Tensor:
        """Return cx, cy, rx and ry [K, 4]."""
        return parameters[:, :4]

    def parameters(self, numbers: Tensor, angle: Tensor) -> Tensor:
        """Return the parameters [K, 6]."""
        return torch.cat([numbers, angle[:, None], torch.zeros_like(angle)[:, None]], 1)

    def distances(self, parameters: Floats, points: Floats) -> Floats:
        """Return the value of the equation over its slope [K], which is the distance to first order."""
        first, second = parameters[FIRST], parameters[SECOND]
        u, v = turned_back(parameters, points).T / np.array([[first], [second]])
        slope = 2.0 * np.hypot(u / first, v / second)
        found: Floats = (u * u + v * v - 1.0) / np.maximum(slope, _SLOPE_MIN)
        return found

    def guesses(self, points: Floats) -> list[Floats]:
        """Return the level and the tilted ellipse with the least squares of their equations."""
        centre = points.mean(0)
        scale = float(np.sqrt(np.square(points - centre).sum(1).mean()))
        if scale <= 0.0:
            return []
        x, y = ((points - centre) / scale).T
        found = []
        for terms in ([x * x, y * y, x, y], [x * x, x * y, y * y, x, y]):
            solution = np.linalg.lstsq(np.stack(terms, 1), np.ones(len(x)), rcond=None)[0].tolist()
            a, b, c, d, e = solution if len(solution) == 5 else (solution[0], 0.0, *solution[1:])
            found += _from_conic(a, b, c, d, e, centre, scale)
        return found

    def bounded(self, parameters: Floats) -> Floats | None:
        """Return the parameters if both half axes are positive, with an angle within a right one of 0."""
        if min(parameters[FIRST], parameters[SECOND]) <= 0 or not np.isfinite(parameters).all():
            return None
        bounded = parameters.copy()
        bounded[ANGLE] = math.remainder(parameters[ANGLE], math.pi)
        return bounded


def _from_conic(a: float, b: float, c: float, d: float, e: float, centre: Floats, scale: float) -> list[Floats]:
    """Return the ellipse a x x + b x y + c y y + d x + e y = 1, enlarged by ``scale`` and moved, if it is one."""
    matrix = np.array([[a, b / 2.0], [b / 2.0, c]])
    if a + c <= 0.0 or np.linalg.det(matrix) <= 1e-12:
        return []
    middle = np.linalg.solve(matrix, [-d / 2.0, -e / 2.0])
    level = 1.0 + float(middle @ matrix @ middle)
    if level <= 0.0:
        return []
    values, vectors = (np.array([a, c]), np.eye(2)) if b == 0.0 else np.linalg.eigh(matrix)
    axes = np.sqrt(level / values) * scale
    angle = math.atan2(vectors[1, 0], vectors[0, 0])
    return [np.array([*(middle * scale + centre), *axes, angle, 0.0])]
