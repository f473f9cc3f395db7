"""Capacities: how much a step may make when the host does not read back how much it made.

On the CPU reading a count costs nothing, and buffers and launches have exactly the size needed. On CUDA reading a count
waits for all work queued before it, and a recorded graph cannot read at all. There the host reads the counts of one
step and gives the following steps a somewhat larger capacity; kernels read the true counts on the device. A step that
exceeds its capacity draws nothing: its adjoints are zero, its loss keeps the value of the step before, and it counts
as dropped.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import warp as wp


class Counts(NamedTuple):
    """How many of each thing a step makes or may make, in the order of ``overflow``."""

    vertices: int
    strips: int
    pairs: int
    slots: int

    def with_headroom(self) -> Counts:
        """Return the counts plus a half, for paths that grow, plus 256, for scenes that are almost empty."""
        return Counts(*(count + count // 2 + 256 for count in self))

    def at_least(self, least: Counts | None) -> Counts:
        """Return the larger one of each count and that of ``least``."""
        return self if least is None else Counts(*map(max, self, least))


class Capacity:
    """The capacity of the steps on one device, and a record of the steps that exceeded it.

    Attributes:
        limit: the capacity of the next steps; None if counts are read back.
        overflow: [4] on the device, 1 for each count of the last step with a limit that exceeded it.
        fits: [1] float64 on the device, 1, or -1 if the last step exceeded its limit; its paths must then not move.
        dropped_steps: [1] on the device, the number of steps so far that drew nothing for that reason.
    """

    def __init__(self, device: Any) -> None:
        self.limit: Counts | None = None
        self.overflow = wp.zeros(len(Counts._fields), dtype=wp.int32, device=device)
        self.dropped_steps = wp.zeros(1, dtype=wp.int32, device=device)
        self.fits = wp.ones(1, dtype=wp.float64, device=device)
        self._no_overflow = wp.zeros_like(self.overflow)

    @property
    def flags(self) -> wp.array:
        """``overflow``, or zeros without a limit: a replayed graph may have set ``overflow`` in the meantime."""
        return self._no_overflow if self.limit is None else self.overflow
