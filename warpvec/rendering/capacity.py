"""Limits: how much a step may make where the host does not wait to read how much it made.

On the CPU a count costs nothing to read, and buffers and launches have its size. On CUDA reading it waits for all work
before it, and a recorded graph cannot. There one step is counted, the next ones are given room for somewhat more, and
kernels read the true counts where they are. A step that would make more than it has room for draws nothing: its
adjoints are zero, its loss stays that of the step before, and it counts as lost.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import warp as wp


class Counts(NamedTuple):
    """How much of each kind a step makes, or has room for, in the order of ``overflow``."""

    vertices: int
    strips: int
    pairs: int
    slots: int

    def with_headroom(self) -> Counts:
        """Half as much again, as new paths grow, and some for a scene that was nearly empty."""
        return Counts(*(count + count // 2 + 256 for count in self))


class Capacity:
    """Room on one device, and what did not fit.

    Attributes:
        room: for the next steps; None where counts are read back.
        overflow: [4] on the device, 1 for each kind that the last step with a room had too little for.
        fits: [1] float64 on the device, 1, or -1 if the last step had too little room, and its paths are to stay.
        lost: [1] on the device, the steps so far that drew nothing for that.
    """

    def __init__(self, device: Any) -> None:
        self.room: Counts | None = None
        self.overflow = wp.zeros(len(Counts._fields), dtype=wp.int32, device=device)
        self.dropped_steps = wp.zeros(1, dtype=wp.int32, device=device)
        self.fits = wp.ones(1, dtype=wp.float64, device=device)
        self._nothing = wp.zeros_like(self.overflow)

    @property
    def flags(self) -> wp.array:
        """``overflow``, or zeros where there is no limit: a replayed graph may have set ``overflow`` since."""
        return self._nothing if self.room is None else self.overflow
