"""A kind of gradient states the share t of its end colour at each place, and the derivative of t by its geometry."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

Reals = TypeVar("Reals", NDArray[np.float32], NDArray[np.float64])

Geometry = tuple[float, ...]
"""The numbers of a gradient's geometry, 4 or 5; a kind that needs fewer leaves the last ones 0."""

GEOMETRY_SIZE = 4
"""Length of a `Geometry` of the kinds that need no `warpvec.geometry.stops.Stops`."""

WHOLE_SIZE = 5
"""Length of a `Geometry` of any kind."""

RAMP_EXTENT_MIN = 1.0e-3
"""Length or radius in pixels below which a gradient counts as degenerate: its colours change within one pixel, so it
shows its end colour, and its derivatives, which grow as 1 / length, would say nothing."""


class GradientKind(ABC):
    """A kind of gradient: the share t of its end at a place. The offsets of its stops are values of t.

    A geometry is four or five numbers in pixels: G. Methods over many places take it as an array [G], or [G, M] with
    one geometry for each of M places.

    Attributes:
        name: in one word, as in the name of a layer.
        element: the element of SVG.
        sides: its attributes that hold the first numbers of the geometry, in order.
        has_free_start: whether t may be 0 anywhere; else it is 0 at one point only, a centre.
        needs_stops: whether its geometry is five numbers, the last of them `Stops.breadth`.
        is_root: whether t is the root of a quadratic form, and no linear one; see `form`.
    """

    name: str
    element: str
    sides: tuple[str, ...]
    has_free_start: bool
    needs_stops: bool = False
    is_root: bool = True

    @abstractmethod
    def share(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return t [M], not limited to [0, 1], at the places ``x``, ``y`` [M]."""

    @abstractmethod
    def slopes(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return the derivative of `share` by each number of the geometry [G, M]."""

    @abstractmethod
    def is_drawn(self, geometry: Tensor) -> Tensor:
        """Return a mask [N] of the geometries [N, G] that are finite and not smaller than ``RAMP_EXTENT_MIN``."""

    @abstractmethod
    def scaled(self, geometry: Tensor, x_factor: float, y_factor: float) -> Tensor:
        """Return the geometries [N, G] of the gradients scaled about the origin."""

    @abstractmethod
    def moved(self, geometry: Tensor, x: float, y: float) -> Tensor:
        """Return the geometries [N, G] of the gradients moved by ``x`` and ``y`` pixels."""

    @abstractmethod
    def form(self, geometry: Tensor) -> Tensor:
        """Return what the kernels need of the geometries [N, 5] that are drawn: origin and form [N, 5].

        With q from the origin to a place, t is x q_x + y q_y with a linear form (x, y, 0), and the root of
        xx q_x^2 + 2 xy q_x q_y + yy q_y^2 with a quadratic one (xx, xy, yy).
        """

    @abstractmethod
    def form_adjoint(self, geometry: Tensor, adj_form: Tensor) -> Tensor:
        """Return dL/d(geometry) [N, 5] from dL/d(what `form` returns) [N, 5]."""

    @abstractmethod
    def between(self, geometry: Geometry, start: float, end: float) -> Geometry:
        """Return the geometry whose t is 0 where this one's is ``start``, and 1 where it is ``end``.

        Without a free start, ``start`` is ignored.
        """

    def attributes(self, numbers: Sequence[str]) -> dict[str, str]:
        """Return the attributes that state a geometry, whose ``numbers`` are given as texts."""
        return dict(zip(self.sides, numbers, strict=False))

    def numbers(self, attributes: Mapping[str, str]) -> list[str]:
        """Return the numbers of a geometry, as texts, from its `attributes`; those left out are 0."""
        found = [attributes[side] for side in self.sides]
        return [*found, *["0"] * (GEOMETRY_SIZE - len(found))]

    @property
    def number_count(self) -> int:
        """How many numbers of a geometry it has."""
        return WHOLE_SIZE if self.needs_stops else len(self.sides)


def length(x: Reals, y: Reals) -> Reals:
    """Return the lengths of vectors, computed in float64 and rounded once."""
    squared = np.square(x, dtype=np.float64) + np.square(y, dtype=np.float64)
    found: Reals = np.sqrt(squared).astype(x.dtype)
    return found
