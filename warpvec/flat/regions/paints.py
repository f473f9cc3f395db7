"""The paints of regions, and their colours at places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.gradients import FLAT, RADIAL

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

LENGTH_MIN = 1.0e-3
"""Length or radius in pixels below which a gradient is evaluated as if it had this one, to divide by no zero."""


FIELDS = ("color", "opacity", "kind", "geometry", "end_color")
"""Arrays of paints, one row a paint."""


@dataclass(frozen=True, eq=False)
class Paints:
    """K paints: flat, or gradients of two stops that continue beyond their ends.

    Attributes:
        color: sRGB-encoded colour of the first stop [K, 3] in [0, 1].
        opacity: opacity [K] in [0, 1].
        kind: `warpvec.geometry.gradients.FLAT`, ``LINEAR`` or ``RADIAL`` [K].
        geometry: ends x1, y1, x2, y2 or cx, cy, r, 0 in pixels [K, 4].
        end_color: sRGB-encoded colour of the last stop [K, 3].
    """

    color: Floats
    opacity: Floats
    kind: Integers
    geometry: Floats
    end_color: Floats

    def __len__(self) -> int:
        return len(self.color)

    def joined(self, other: Paints) -> Paints:
        """Return these paints and those of ``other``."""
        return Paints(*(np.concatenate([getattr(self, name), getattr(other, name)]) for name in FIELDS))

    def select(self, index: Integers) -> Paints:
        """Return the paints ``index`` [N]."""
        return Paints(*(getattr(self, name)[index] for name in FIELDS))

    def replaced(self, index: int, paint: Paints) -> Paints:
        """Return the paints with that at ``index`` replaced by the only one of ``paint``."""
        arrays = [getattr(self, name).copy() for name in FIELDS]
        for array, name in zip(arrays, FIELDS, strict=True):
            array[index] = getattr(paint, name)[0]
        return Paints(*arrays)

    def at(self, index: Integers, x: Floats, y: Floats) -> Floats:
        """Return premultiplied sRGB and alpha [..., 4] of the paints ``index`` [...] at places ``x``, ``y`` [...]."""
        color = self.color[index]
        is_ramp = self.kind[index] != FLAT
        if is_ramp.any():
            ramp = index[is_ramp]
            part = self.position(ramp, x[is_ramp], y[is_ramp])[:, None]
            color[is_ramp] += part * (self.end_color[ramp] - self.color[ramp])
        opacity = self.opacity[index][..., None]
        return np.concatenate([color * opacity, opacity], -1)

    def position(self, index: Integers, x: Floats, y: Floats) -> Floats:
        """Return the place between the two stops, in [0, 1], of the gradients ``index`` [N] at ``x``, ``y`` [N]."""
        a, b, c, d = self.geometry[index].T
        radial = np.hypot(x - a, y - b) / np.maximum(c, LENGTH_MIN)
        along, squared = (x - a) * (c - a) + (y - b) * (d - b), (c - a) ** 2 + (d - b) ** 2
        linear = along / np.maximum(squared, LENGTH_MIN**2)
        return np.clip(np.where(self.kind[index] == RADIAL, radial, linear), 0.0, 1.0).astype(np.float32)
