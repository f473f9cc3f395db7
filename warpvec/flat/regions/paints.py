"""The paints of regions, and their colours at places."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from warpvec.arrays import Floats32, Integers, Integers32, Places
from warpvec.geometry.paints.kind import WHOLE_SIZE
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.stops import STOPS_MAX

FIELDS = ("color", "opacity", "kind", "geometry", "end_color", "count", "offset", "inner_color", "shown")
"""Arrays of paints, one row a paint."""


@dataclass(frozen=True, eq=False)
class Paints:
    """K paints: flat, or gradients of up to ``STOPS_MAX`` stops that continue beyond their ends.

    Attributes:
        color: sRGB-encoded colour of the first stop [K, 3] in [0, 1].
        opacity: opacity [K] in [0, 1].
        kind: as in `warpvec.geometry.gradients.Gradients` [K].
        geometry: the numbers that the kind has, in pixels [K, 5]; [K, 4] is filled up.
        end_color: sRGB-encoded colour of the last stop [K, 3].
        count, offset, inner_color: as in `warpvec.geometry.stops.Stops`; two stops at the ends if not given.
        shown: opacity of each stop [K, STOPS_MAX], which multiplies that of the paint; 1 if not given.
    """

    color: Floats32
    opacity: Floats32
    kind: Integers32
    geometry: Floats32
    end_color: Floats32
    count: Integers32 = field(default_factory=lambda: np.zeros(0, np.int32))
    offset: Floats32 = field(default_factory=lambda: np.zeros((0, STOPS_MAX), np.float32))
    inner_color: Floats32 = field(default_factory=lambda: np.zeros((0, STOPS_MAX - 2, 3), np.float32))
    shown: Floats32 = field(default_factory=lambda: np.zeros((0, STOPS_MAX), np.float32))

    def __post_init__(self) -> None:
        size = len(self.color)
        missing = WHOLE_SIZE - self.geometry.shape[1]
        object.__setattr__(self, "geometry", np.pad(self.geometry, ((0, 0), (0, missing))))
        if len(self.count) != size:
            offset = np.ones((size, STOPS_MAX), np.float32)
            offset[:, 0] = 0
            object.__setattr__(self, "count", np.full(size, 2, np.int32))
            object.__setattr__(self, "offset", offset)
            object.__setattr__(self, "inner_color", np.zeros((size, STOPS_MAX - 2, 3), np.float32))
        if len(self.shown) != size:
            object.__setattr__(self, "shown", np.ones((size, STOPS_MAX), np.float32))

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
        color, opacity = self.color[index], self.opacity[index]
        is_ramp = self.kind[index] != FLAT
        if is_ramp.any():
            ramp = index[is_ramp]
            values = self._along(ramp, self.position(ramp, x[is_ramp], y[is_ramp]))
            color[is_ramp] = values[:, :3]
            opacity[is_ramp] *= values[:, 3]
        return np.concatenate([color * opacity[..., None], opacity[..., None]], -1)

    def premultiplied(self) -> Floats32:
        """Return premultiplied sRGB and alpha [K, 4] of the paints; of gradients, without the opacities of stops."""
        return np.column_stack([self.color * self.opacity[:, None], self.opacity])

    def first_alike(self) -> Integers:
        """Return the first paint [K] that looks like each: that of the same premultiplied colour if both are flat."""
        own = np.where(self.kind == FLAT, -1, np.arange(len(self)))
        keys = np.column_stack([self.premultiplied(), own])
        _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        return first[same.ravel()]

    def with_whole_ends(self, limit: float) -> Paints:
        """Return the paints with black and white in place of flat ones all of whose channels are within ``limit``."""
        color, end_color = self.color.copy(), self.end_color.copy()
        for whole in (0.0, 1.0):
            is_near = (self.kind == FLAT) & (np.abs(color - whole) <= limit).all(1)
            color[is_near] = end_color[is_near] = whole
        return replace(self, color=color, end_color=end_color)

    def first_equal_ramp(self) -> Integers32:
        """Return for each paint [K] the number of the first one that is the same ramp. Flat ones keep their own."""
        rows = np.column_stack([getattr(self, name).reshape(len(self), -1) for name in FIELDS])
        _, first, group = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        own = np.arange(len(self), dtype=np.int32)
        return np.where(self.kind == FLAT, own, first[group.ravel()]).astype(np.int32)

    def mean_opacity(self) -> Floats32:
        """Return the opacity of each paint [K], of a gradient the mean of those of its stops."""
        is_used = np.arange(STOPS_MAX) < self.count[:, None]
        mean = (self.shown * is_used).sum(1) / is_used.sum(1)
        return np.where(self.kind == FLAT, self.opacity, self.opacity * mean).astype(np.float32)

    def position(self, index: Integers32, x: Floats32, y: Floats32) -> Floats32:
        """Return the place between the two ends, in [0, 1], of the gradients ``index`` [N] at ``x``, ``y`` [N]."""
        share = np.zeros(len(index), np.float32)
        for number in np.unique(self.kind[index]):
            rows = self.kind[index] == number
            share[rows] = kind_of(number).share(self.geometry[index[rows]].T, x[rows], y[rows])
        return np.clip(share, 0.0, 1.0)

    def _along(self, index: Integers32, place: Floats32) -> Floats32:
        """Return the colours and opacities [N, 4] of the gradients ``index`` [N] at a ``place`` [N] of each."""
        values = np.column_stack([self.color[index], self.shown[index, 0]])
        before = values.copy()
        counts = np.asarray(self.count[index])
        for stop in range(1, int(counts.max(initial=1))):
            has_stop = np.less(stop, counts)[:, None]
            is_last = np.equal(stop, counts - 1)[:, None]
            inner = self.inner_color[index, min(stop, STOPS_MAX - 2) - 1]
            color = np.where(is_last, self.end_color[index], inner)
            here = np.where(has_stop, np.column_stack([color, self.shown[index, stop]]), before)
            first, last = self.offset[index, stop - 1], self.offset[index, stop]
            rising = (place - first) / np.maximum(last - first, np.float32(1e-6))
            part = np.where(place >= last, np.float32(1), np.clip(rising, 0, 1))[:, None]
            values += part * (here - before)
            before = here
        return values
