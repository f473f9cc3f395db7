"""Rectangles: a centre, two sides, an angle, and with round corners their radius."""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor

from warpvec.geometry.forms.circle import QUARTERS
from warpvec.geometry.forms.form import ANGLE, CORNER, FIRST, SECOND, Floats, Form, X, Y, line_rows, turned_back
from warpvec.geometry.lines import thirds

_CORNERS = torch.tensor([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]], dtype=torch.float64)

ROUNDING = 1e-6
"""Share of a step by which a quotient of float64 may miss a whole number."""

_TILTS = 30
"""Angles below a right one that are tried for the smallest rectangle around the points, which is the guess of a fit."""


class Rect(Form):
    """A rectangle about x, y; its sizes are its sides, the angle is that of the first."""

    name, element = "rect", "rect"
    sides: tuple[str, ...] = ("x", "y", "width", "height")
    turns = True
    free: tuple[int, ...] = (X, Y, FIRST, SECOND, ANGLE)
    is_line: tuple[bool, ...] = (True,) * 4
    basis = torch.stack(
        [line_rows(_CORNERS * torch.tensor([1.0, 0.0])), line_rows(_CORNERS * torch.tensor([0.0, 1.0])),
         0 * line_rows(_CORNERS)]
    )  # fmt: skip

    def numbers(self, parameters: Tensor) -> Tensor:
        """Return x, y, width and height [K, 4]."""
        return torch.cat([parameters[:, :2] - parameters[:, 2:4] / 2, parameters[:, 2:4]], 1)

    def parameters(self, numbers: Tensor, angle: Tensor) -> Tensor:
        """Return the parameters [K, 6]."""
        corner = numbers[:, 4:] if numbers.shape[1] == 5 else torch.zeros_like(angle)[:, None]
        return torch.cat([numbers[:, :2] + numbers[:, 2:4] / 2, numbers[:, 2:4], angle[:, None], corner], 1)

    def distances(self, parameters: Floats, points: Floats) -> Floats:
        """Return the signed distances [K]."""
        radius = parameters[CORNER]
        off = np.abs(turned_back(parameters, points)) - parameters[[FIRST, SECOND]] / 2 + radius
        outside, inside = np.hypot(*np.maximum(off, 0.0).T), np.minimum(off.max(1), 0.0)
        found: Floats = outside + inside - radius
        return found

    def guesses(self, points: Floats) -> list[Floats]:
        """Return the level rectangle around the points, and the smallest one."""
        boxes = [self._box(points, angle) for angle in np.linspace(0.0, math.pi / 2, _TILTS, endpoint=False)]
        return [boxes[0], min(boxes, key=lambda box: float(box[FIRST] * box[SECOND]))]

    def _box(self, points: Floats, angle: float) -> Floats:
        parameters = np.array([0.0, 0.0, 0.0, 0.0, angle, 0.0])
        turned = turned_back(parameters, points)
        low, high = turned.min(0), turned.max(0)
        cosine, sine = math.cos(angle), math.sin(angle)
        x, y = (low + high) / 2
        sides = high - low
        return np.array([x * cosine - y * sine, x * sine + y * cosine, *sides, angle, self._first_radius(sides)])

    def _first_radius(self, sides: Floats) -> float:
        return 0.0

    def bounded(self, parameters: Floats) -> Floats | None:
        """Return the parameters with corners that have room, and an angle below half a right one; None without room."""
        if min(parameters[FIRST], parameters[SECOND]) <= 0 or not np.isfinite(parameters).all():
            return None
        bounded = parameters.copy()
        quarters = round(parameters[ANGLE] / (math.pi / 2))
        bounded[ANGLE] -= quarters * math.pi / 2
        if quarters % 2:
            bounded[[FIRST, SECOND]] = parameters[[SECOND, FIRST]]
        bounded[CORNER] = np.clip(parameters[CORNER], 0.0, bounded[[FIRST, SECOND]].min() / 2)
        return bounded


class RoundRect(Rect):
    """A rectangle with round corners."""

    name = "rounded rect"
    sides = ("x", "y", "width", "height", "rx")
    free = (X, Y, FIRST, SECOND, ANGLE, CORNER)
    is_line = (True, False) * 4

    def numbers(self, parameters: Tensor) -> Tensor:
        """Return x, y, width, height and rx [K, 5]."""
        return torch.cat([super().numbers(parameters), parameters[:, CORNER:]], 1)

    def drawable(self, numbers: Tensor, step: float) -> Tensor:
        """Return ``numbers`` [K, 5] with a radius of at most half a side: renderers draw no more."""
        room = (numbers[:, 2:4].amin(1) / (2 * step) + ROUNDING).floor() * step
        return torch.cat([numbers[:, :4], torch.minimum(numbers[:, 4], room)[:, None]], 1)

    def _first_radius(self, sides: Floats) -> float:
        return float(sides.min()) / 4  # any; a half would be at the bound


def _round_basis() -> Tensor:
    """Return the outlines [3, 8, 3, 2] of the width, the height and the radius: each line, then the corner after it."""
    across, down = torch.tensor([1.0, 0.0]), torch.tensor([0.0, 1.0])
    return torch.stack([_rounded(across, 0.0), _rounded(down, 0.0), _rounded(torch.zeros(2), 1.0)])


def _rounded(factors: Tensor, radius: float) -> Tensor:
    starts = _CORNERS.double() * factors
    ends, along = starts.roll(-1, 0), _CORNERS.roll(-1, 0) - _CORNERS
    first, last = starts + radius * along, ends - radius * along
    lines = torch.stack([first, *thirds(first, last)], 1)
    inner = ends - radius * (along - along.roll(-1, 0))  # centres of the corners
    quarters = QUARTERS.roll(1, 0)  # the first one follows the top
    return torch.stack([lines, inner[:, None] + radius * quarters], 1).reshape(8, 3, 2)


RoundRect.basis = _round_basis()
