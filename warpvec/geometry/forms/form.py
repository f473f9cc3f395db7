"""A form states the outline of a path by a few numbers, such as the centre and the radius of a circle."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.geometry.lines import thirds

PARAMETERS = 6
"""Length of a row of parameters: x and y of the centre, two sizes, the angle in radians, the radius of the corners.
Lengths are in pixels. A form that needs fewer leaves the others 0."""

X, Y, FIRST, SECOND, ANGLE, CORNER = range(PARAMETERS)
"""Places of these numbers in a row."""

SIZES = (FIRST, SECOND, CORNER)

Floats = NDArray[np.float64]

_STEP = 1e-4
"""Step in pixels, or in radians over the size, of the differences that stand for derivatives in a fit."""

_ROUNDS_MAX = 30
"""Most Gauss-Newton steps of a fit: from the guess, five to ten are enough."""

_HOPELESS = 0.2
"""Largest distance of a point from a guess, as a share of its size, from which a fit begins. The guess of a rectangle
whose ends are half circles is a tenth of its smaller side off."""

_MOVE_MIN = 1e-5
"""A fit ends with a step below so many pixels."""

_ROUNDS_HOPEFUL, _TOO_FAR = 4, 4.0
"""A fit is given up after so many steps if a point is still this many times farther away than asked for: most outlines
are no form, and each step of a fit gains most at its beginning."""


class Fitted(NamedTuple):
    """The form nearest to some points: its parameters [6], and the largest distance of a point from it in pixels."""

    parameters: Floats
    distance: float


class Form(ABC):
    """A form whose outline is one loop of S cubics, clockwise on screen.

    Before it is turned about its centre and moved there, the outline is a sum: each size times the outline of a form
    with this size 1 and the others 0.

    Attributes:
        name: in one word, as in the summary.
        element: the element of SVG.
        sides: its attributes that state the form, without the angle.
        turns: whether it has an angle.
        free: places of the parameters that it has.
        is_line: which of its rows are straight lines [S].
        basis: the outlines of the three sizes [3, S, 3, 2] (float64).
    """

    name: str
    element: str
    sides: tuple[str, ...]
    turns: bool
    free: tuple[int, ...]
    is_line: tuple[bool, ...]
    basis: Tensor

    @property
    def row_count(self) -> int:
        """The number of its cubics, S."""
        return len(self.is_line)

    def segments(self, parameters: Tensor) -> Tensor:
        """Return the control points [K, S, 3, 2] of forms with ``parameters`` [K, 6], differentiable by torch."""
        turned = self._level(parameters) @ _turn(parameters[:, ANGLE])[:, None]
        return parameters[:, None, None, :2] + turned

    def derivative(self, parameters: Tensor) -> Tensor:
        """Return the derivative of `segments` by the parameters [K, S, 3, 2, 6]; that of numbers it lacks is 0."""
        turn = _turn(parameters[:, ANGLE])[:, None]
        quarter = torch.tensor([[0.0, 1.0], [-1.0, 0.0]], dtype=parameters.dtype, device=parameters.device)
        level = self._level(parameters)
        found = parameters.new_zeros(*level.shape, PARAMETERS)
        found[..., 0, X] = found[..., 1, Y] = 1.0
        for place, basis in zip(SIZES, self.basis.to(parameters), strict=True):
            found[..., place] = basis[None] @ turn
        found[..., ANGLE] = level @ quarter @ turn
        absent = [place for place in range(PARAMETERS) if place not in self.free]
        found[..., absent] = 0.0
        return found

    def _level(self, parameters: Tensor) -> Tensor:
        """Return the outlines [K, S, 3, 2] about 0 before they are turned."""
        sizes = parameters[:, list(SIZES)]
        return torch.tensordot(sizes, self.basis.to(parameters), 1)

    # What a file states

    @abstractmethod
    def numbers(self, parameters: Tensor) -> Tensor:
        """Return the values [K, sides] of the attributes ``sides``."""

    @abstractmethod
    def parameters(self, numbers: Tensor, angle: Tensor) -> Tensor:
        """Return the parameters [K, 6] with these values of ``sides`` [K, sides] and ``angle`` [K] in radians."""

    def drawable(self, numbers: Tensor, step: float) -> Tensor:
        """Return ``numbers`` [K, sides], which are multiples of ``step``, as renderers take them."""
        del step
        return numbers

    # Fits

    @abstractmethod
    def distances(self, parameters: Floats, points: Floats) -> Floats:
        """Return how far ``points`` [K, 2] lie outside of the outline with ``parameters`` [6]: [K], negative inside.

        The values are exact on the outline and, near it, to first order.
        """

    @abstractmethod
    def guesses(self, points: Floats) -> list[Floats]:
        """Return parameters [6] to begin a fit to ``points`` [K, 2] with, the simplest form first."""

    @abstractmethod
    def bounded(self, parameters: Floats) -> Floats | None:
        """Return ``parameters`` [6] with sizes within their bounds; None if there is no such form."""

    def fit(self, points: Floats, weights: Floats, *, is_level: bool = False, near: float = math.inf) -> Fitted | None:
        """Return the form nearest to ``points`` [K, 2] by the weighted squares of the distances, None for none.

        Args:
            points: points of an outline, in pixels.
            weights: how much each counts [K]; those of weight 0 do not count, nor for the largest distance.
            is_level: whether the angle stays 0.
            near: distance in pixels beyond which a form is of no use; the fit may then be given up.
        """
        seen = weights > 0.0
        points, weights = points[seen], np.sqrt(weights[seen])
        free = self._free(is_level)
        if len(points) < len(free):
            return None
        guesses = [guess for guess in self.guesses(points) if not is_level or guess[ANGLE] == 0.0]
        guesses = [guess for guess in guesses if self._is_hopeful(guess, points)]
        found = [self._descended(guess, points, weights, free, _TOO_FAR * near) for guess in guesses]
        fits = [Fitted(each, float(np.abs(self.distances(each, points)).max())) for each in found if each is not None]
        return min(fits, key=lambda each: each.distance, default=None)

    def determined(self, fitted: Floats, points: Floats, weights: Floats, *, is_level: bool = False) -> float:
        """Return how well ``points`` [K, 2] tell all parameters of a form, from 0 to 1.

        It is the smallest singular value over the largest of the derivative of the distances, in pixels. The angle of a
        form that ``is_level`` is known.
        """
        seen = weights > 0.0
        steps = _steps_of(fitted, self._free(is_level))
        slopes = np.stack([step * self._slope(fitted, points[seen], place, step) for place, step in steps], 1)
        values = np.linalg.svd(slopes * np.sqrt(weights[seen])[:, None], compute_uv=False)
        return float(values[-1] / values[0]) if len(values) == len(steps) and values[0] > 0.0 else 0.0

    def _free(self, is_level: bool) -> list[int]:
        return [place for place in self.free if not (is_level and place == ANGLE)]

    def _is_hopeful(self, guess: Floats, points: Floats) -> bool:
        """Return whether a fit from ``guess`` can come near."""
        bounded = self.bounded(guess)
        if bounded is None:
            return False
        return bool(np.abs(self.distances(bounded, points)).max() <= _HOPELESS * np.abs(bounded[[FIRST, SECOND]]).max())

    def _descended(self, start: Floats, points: Floats, weights: Floats, free: list[int], far: float) -> Floats | None:
        """Return the parameters after Gauss-Newton steps from ``start``; None if a point stays ``far`` away."""
        here: Floats | None = self.bounded(start)
        steps = _steps_of(start, free)
        for number in range(_ROUNDS_MAX):
            if here is None:
                return None
            distances = self.distances(here, points)
            if number >= _ROUNDS_HOPEFUL and np.abs(distances).max() > far:
                return None
            slopes = np.stack([self._slope(here, points, place, step) for place, step in steps], 1)
            move = np.linalg.lstsq(slopes * weights[:, None], -distances * weights, rcond=1e-9)[0]
            moved = here.copy()
            moved[free] += move
            here = self.bounded(moved)
            if np.abs(move * _STEP / np.array([step for _, step in steps])).max() < _MOVE_MIN:
                break
        return here

    def _slope(self, parameters: Floats, points: Floats, place: int, step: float) -> Floats:
        ahead, behind = parameters.copy(), parameters.copy()
        ahead[place] += step
        behind[place] -= step
        return (self.distances(ahead, points) - self.distances(behind, points)) / (2.0 * step)


def _steps_of(parameters: Floats, free: list[int]) -> list[tuple[int, float]]:
    """Return each free place with the step of its differences: one that moves the outline by about ``_STEP``."""
    reach = max(float(np.abs(parameters[[FIRST, SECOND]]).max()), 1.0)
    return [(place, _STEP / reach if place == ANGLE else _STEP) for place in free]


def _turn(angle: Tensor) -> Tensor:
    """Return the matrices [K, 2, 2] that turn rows of x and y by ``angle`` [K], clockwise on screen."""
    cosine, sine = angle.cos(), angle.sin()
    return torch.stack([torch.stack([cosine, sine], -1), torch.stack([-sine, cosine], -1)], -2)


def turned_back(parameters: Floats, points: Floats) -> Floats:
    """Return ``points`` [K, 2] relative to the centre and axes of a form with ``parameters`` [6]."""
    cosine, sine = np.cos(parameters[ANGLE]), np.sin(parameters[ANGLE])
    offset = points - parameters[:2]
    turned: Floats = offset @ np.array([[cosine, -sine], [sine, cosine]])
    return turned


def line_rows(anchors: Tensor) -> Tensor:
    """Return the rows [S, 3, 2] of the lines between ``anchors`` [S, 2] and back to the first."""
    return torch.stack([anchors, *thirds(anchors, anchors.roll(-1, 0))], 1)
