"""A renderer's fused step, taken over and over: in memory that is kept, and on CUDA as a graph.

A graph is recorded once for the memory that the inputs lie in, and replayed while they stay there. It reads no counts
back (``warpvec/rendering/capacity.py``), so the step before it is counted as usual and tells how much room to give; and every
``_CHECK_GAP`` replays the host asks whether any had too little, in which case the next step is counted again. Where
nothing can be recorded, or a replay is not what a counted step gives, all steps are counted.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any, NamedTuple

import torch
import warp as wp
from torch import Tensor

from warpvec.errors import InputError
from warpvec.rendering.capacity import Counts
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer

_Inputs = tuple[Tensor, Tensor, Tensor, Tensor, Tensor]

# Replays between looks at what was lost; each waits for the device.
_CHECK_GAP = 50


class _Recording(NamedTuple):
    graph: Any
    out: Adjoints
    places: tuple[Any, ...]
    growth: int


class RecordedStep:
    """The fused step of ``renderer``.

    Args:
        record: whether to replay graphs; None: on CUDA, where Warp's memory pool lets them allocate.

    Attributes:
        is_paused: whether steps are counted for as long; what is recorded stays.
    """

    def __init__(self, renderer: TileRenderer, record: bool | None = None) -> None:
        self._renderer = renderer
        self._device = wp.device_from_torch(renderer.device)
        self._record = _can_record(self._device) if record is None else record
        self._is_checked = self.is_paused = False
        self._out: Adjoints | None = None
        self._counted: tuple[tuple[Any, ...], Counts] | None = None
        self._recording: _Recording | None = None
        self._replays = self._lost = 0

    def take(
        self,
        points: Tensor,
        color: Tensor,
        opacity: Tensor,
        background: Tensor,
        prepared_target: Tensor,
        removal_cost: bool = False,
    ) -> Adjoints:
        """What ``renderer.fit_step`` gives, in memory that the next step overwrites unless removal is asked for."""
        inputs = (points, color, opacity, background, prepared_target)
        if removal_cost:
            return self._renderer.fit_step(*inputs, removal_cost)
        if self.is_paused or not self._record:
            return self._renderer.fit_step(*inputs, out=self._out_for(points))
        places = tuple((tensor.data_ptr(), tensor.shape) for tensor in inputs)
        recording = self._recording
        if recording is not None and recording.places == places and recording.growth == self._renderer.growth:
            self._replay(recording)
            return recording.out
        out = self._out_for(points)
        if self._counted is not None and self._counted[0] == places:
            self._rehearse(inputs, out, places, self._counted[1])
        else:
            self._recording = None
            self._renderer.fit_step(*inputs, out=out)
            self._counted = places, self._renderer.counts.with_headroom()
        return out

    @property
    def is_recorded(self) -> bool:
        """Whether the next step will be a replay, if its inputs stay where they are."""
        return self._recording is not None

    def _rehearse(self, inputs: _Inputs, out: Adjoints, places: tuple[Any, ...], room: Counts) -> None:
        """A step within ``room``, which brings all memory to its size, and a recording of another."""
        self._counted = None
        direct = None if self._is_checked else _copies(self._renderer.fit_step(*inputs, out=out))
        self._renderer.limit(room)
        try:
            graph, growth = self._record_within_limits(inputs, out)
        except (InputError, RuntimeError):  # too little memory for the room, or a driver that cannot
            self._record = False
        finally:
            self._renderer.limit(None)
        if not self._record:
            self._renderer.fit_step(*inputs, out=out)
        elif self._renderer.growth == growth and (direct is None or self._agrees(graph, out, direct)):
            self._recording = _Recording(graph, out, places, growth)
            self._replays, self._lost = 0, self._renderer.dropped_steps

    def _record_within_limits(self, inputs: _Inputs, out: Adjoints) -> tuple[Any, int]:
        """The graph of a step, and the growth of the buffers before it was recorded."""
        self._renderer.fit_step(*inputs, out=out)
        growth = self._renderer.growth
        with wp.ScopedCapture(device=self._device, force_module_load=False) as capture:
            self._renderer.fit_step(*inputs, out=out)
        return capture.graph, growth

    def _agrees(self, graph: Any, out: Adjoints, direct: list[Tensor]) -> bool:
        """Whether a replay gives the bits of a step that was counted; without that, nothing is recorded again."""
        rehearsed = _copies(out)
        for value in _tensors(out):
            value.fill_(torch.nan)
        wp.capture_launch(graph)
        self._is_checked = True
        self._record = _equal_bits(rehearsed, direct) and _equal_bits(_tensors(out), direct)
        if not self._record:
            for value, right in zip(_tensors(out), direct, strict=True):
                value.copy_(right)
        return self._record

    def _replay(self, recording: _Recording) -> None:
        wp.capture_launch(recording.graph)
        self._replays += 1
        if self._replays % _CHECK_GAP == 0 and self._renderer.dropped_steps > self._lost:
            self._recording = None

    def _out_for(self, points: Tensor) -> Adjoints:
        if self._out is None or self._out.points.shape != points.shape:
            self._out = self._renderer.make_adjoints(points)
        return self._out


def _can_record(device: Any) -> bool:
    # Sums and sorts need scratch memory, which a graph takes from the pool.
    return bool(device.is_cuda and wp.is_mempool_enabled(device))


def _tensors(adjoints: Adjoints) -> list[Tensor]:
    values = (getattr(adjoints, field.name) for field in fields(Adjoints))
    return [value for value in values if value is not None]


def _copies(adjoints: Adjoints) -> list[Tensor]:
    return [value.clone() for value in _tensors(adjoints)]


def _equal_bits(first: list[Tensor], second: list[Tensor]) -> bool:
    pairs = zip(first, second, strict=True)
    return all(torch.equal(a.view(torch.uint8), b.view(torch.uint8)) for a, b in pairs)
