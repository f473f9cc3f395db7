"""The paints of regions, and their colours at places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats32, Integers32, Places
from warpvec.geometry.paints.registry import FLAT, kind_of

FIELDS = ("color", "opacity", "kind", "geometry", "end_color")
"""Arrays of paints, one row a paint."""


@dataclass(frozen=True, eq=False)
class Paints:
    """K paints: flat, or gradients of two stops that continue beyond their ends.

    Attributes:
        color: sRGB-encoded colour of the first stop [K, 3] in [0, 1].
        opacity: opacity [K] in [0, 1].
        kind: as in `warpvec.geometry.gradients.Gradients` [K].
        geometry: the numbers that the kind has, in pixels [K, 4].
        end_color: sRGB-encoded colour of the last stop [K, 3].
    """

    color: Floats32
    opacity: Floats32
    kind: Integers32
    geometry: Floats32
    end_color: Floats32

    def __len__(self) -> int:
        return len(self.color)

    def joined(self, other: Paints) -> Paints:
        """Return these paints and those of ``other``."""
        return Paints(*(np.concatenate([getattr(self, name), getattr(other, name)]) for name in FIELDS))

    def select(self, index: Integers32 | Places) -> Paints:
        """Return the paints ``index`` [N]."""
        return Paints(*(getattr(self, name)[index] for name in FIELDS))

    def replaced(self, index: int, paint: Paints) -> Paints:
        """Return the paints with that at ``index`` replaced by the only one of ``paint``."""
        arrays = [getattr(self, name).copy() for name in FIELDS]
        for array, name in zip(arrays, FIELDS, strict=True):
            array[index] = getattr(paint, name)[0]
        return Paints(*arrays)

    def at(self, index: Integers32, x: Floats32, y: Floats32) -> Floats32:
        """Return premultiplied sRGB and alpha [..., 4] of the paints ``index`` [...] at places ``x``, ``y`` [...]."""
        color = self.color[index]
        is_ramp = self.kind[index] != FLAT
        if is_ramp.any():
            ramp = index[is_ramp]
            part = self.position(ramp, x[is_ramp], y[is_ramp])[:, None]
            color[is_ramp] += part * (self.end_color[ramp] - self.color[ramp])
        opacity = self.opacity[index][..., None]
        return np.concatenate([color * opacity, opacity], -1)

    def position(self, index: Integers32, x: Floats32, y: Floats32) -> Floats32:
        """Return the place between the two stops, in [0, 1], of the gradients ``index`` [N] at ``x``, ``y`` [N]."""
        share = np.zeros(len(index), np.float32)
        for number in np.unique(self.kind[index]):
            rows = self.kind[index] == number
            share[rows] = kind_of(number).share(self.geometry[index[rows]].T, x[rows], y[rows])
        return np.clip(share, 0.0, 1.0)
