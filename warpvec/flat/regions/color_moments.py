"""Sums over the pixels of areas, from which the ramp of any union of areas follows without its pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats, Integers
from warpvec.flat.regions.ramp_directions import LineDirection
from warpvec.flat.regions.ramp_fitting import Ramp


@dataclass(frozen=True, eq=False)
class ColorMoments:
    """Sums over the N pixels of an area, p = (1, x, y) and colours c.

    Attributes:
        places: sum of p p' [3, 3].
        products: sum of p c' [3, 3].
        squares: sum of the squares of all colours.
    """

    places: Floats
    products: Floats
    squares: float

    @property
    def count(self) -> float:
        """The number of pixels."""
        return float(self.places[0, 0])

    def joined(self, other: ColorMoments) -> ColorMoments:
        """Return the sums over the pixels of both areas."""
        return ColorMoments(self.places + other.places, self.products + other.products, self.squares + other.squares)

    def flat_rest(self) -> float:
        """Return the sum of squares that the mean colour leaves."""
        return max(self.squares - float((self.products[0] ** 2).sum()) / self.count, 0.0)

    def ramp(self) -> LinearRamp:
        """Return the linear ramp of two stops that leaves least, by the direction in which a plane is steepest."""
        mean_place, mean_color = self.places[0, 1:] / self.count, self.products[0] / self.count
        spread = self.places[1:, 1:] - self.count * np.outer(mean_place, mean_place)
        change = self.products[1:] - self.count * np.outer(mean_place, mean_color)
        damped = spread + 1e-9 * (np.trace(spread) + 1.0) * np.eye(2)
        slopes = np.linalg.solve(damped, change)
        along = np.linalg.eigh(slopes @ slopes.T)[1][:, 1]
        slope = along @ change / (along @ damped @ along)
        gained = float((along @ change) @ slope)
        return LinearRamp(LineDirection(mean_place, along), mean_color, slope, max(self.flat_rest() - gained, 0.0))


@dataclass(frozen=True, eq=False)
class LinearRamp:
    """Colours that change by the same amount at each pixel along a direction.

    Attributes:
        direction: places along the ramp.
        color: colour at place 0 [3].
        slope: change of the colour with the place [3].
        rest: sum of squares that it leaves.
    """

    direction: LineDirection
    color: Floats
    slope: Floats
    rest: float

    def between(self, points: Floats) -> Ramp:
        """Return the ramp with its stops at the ends of ``points`` [N, 2]."""
        places = self.direction.places(points)
        knots = np.array([places.min(), places.max()])
        error = float(np.sqrt(self.rest / (3 * len(points))))
        return Ramp(self.direction, knots, np.clip(self.color + knots[:, None] * self.slope, 0, 1), error)


def moments_of(label: Integers, colors: Floats, points: Floats, count: int) -> list[ColorMoments]:
    """Return the sums of ``count`` areas.

    Args:
        label: area of each pixel [N].
        colors: colours of the pixels [N, 3].
        points: their centres x, y [N, 2].
        count: number of areas.
    """

    def sums(values: Floats) -> Floats:
        return np.bincount(label, values, count).astype(np.float64)

    terms = np.column_stack([np.ones(len(points)), points])
    places = np.stack([[sums(terms[:, i] * terms[:, j]) for j in range(3)] for i in range(3)])
    products = np.stack([[sums(terms[:, i] * colors[:, c]) for c in range(3)] for i in range(3)])
    squares = sums((colors**2).sum(1))
    return [ColorMoments(places[..., k], products[..., k], float(squares[k])) for k in range(count)]
