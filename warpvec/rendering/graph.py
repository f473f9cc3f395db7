"""Take a renderer's fused step repeatedly: in memory that is kept, and on CUDA as a recorded graph.

A graph is recorded once for the memory addresses of the inputs, and replayed while they stay the same. A graph cannot
read counts back (``warpvec/rendering/capacity.py``), so the step before the recording reads them and they determine the
capacity. Every ``_CHECK_GAP`` replays the host checks whether a step exceeded it; if so, the next step reads its counts
again. A fit looks more often, and takes the steps again that it lost (``fit/loop.py``). If nothing can be recorded, or
if a replay differs from a step that reads its counts, all steps read counts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any, NamedTuple, TypeVar

import torch
import warp as wp
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.rendering.capacity import Counts
from warpvec.rendering.launch import whole_arrays
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer

_Inputs = tuple[Scene, Tensor]
_Drawn = TypeVar("_Drawn")
_Addresses = tuple[tuple[int, torch.Size], ...]

# Replays between checks for dropped steps; each check waits for the device.
_CHECK_GAP = 50


class _Recording(NamedTuple):
    """A graph, the adjoints it writes, and the arguments that must not change between replays."""

    graph: Any
    out: Adjoints
    addresses: _Addresses
    growth: int
    structure: Structure  # keeps the arrays that the graph reads and the addresses do not tell
    limit: Counts  # the capacity of its steps


class _Drawing(NamedTuple):
    """A graph that draws something else than a step, in the memory and with the capacity of a recording of that."""

    graph: Any
    drawn: Any
    recording: _Recording


class RecordedStep:
    """The fused step of ``renderer``, recorded as a graph when its inputs stay in the same memory.

    Args:
        renderer: renderer whose ``fit_step`` is taken.
        record: whether to record graphs; None: on CUDA, if Warp's memory pool lets graphs allocate.

    Attributes:
        may_drop: whether a step may be dropped because it exceeds its capacity.
        is_paused: while True, steps read their counts and the recording is kept for later, so that
            ``bench/bench_step.py`` can time the stages one by one.
    """

    def __init__(self, renderer: TileRenderer, record: bool | None = None) -> None:
        self._renderer = renderer
        self._device = wp.device_from_torch(renderer.device)
        self._record = self.may_drop = _can_record(self._device) if record is None else record
        self._is_checked = self.is_paused = False
        self._out: Adjoints | None = None
        self._counted: tuple[_Addresses, Counts] | None = None
        self._recording: _Recording | None = None
        self._drawings: dict[str, _Drawing] = {}
        self._replays = self._dropped_steps = 0

    def take(
        self,
        scene: Scene,
        prepared_target: Tensor,
        want_removal_cost: bool = False,
        after: Callable[[Adjoints], None] | None = None,
        least: Counts | None = None,
    ) -> Adjoints:
        """Return what ``renderer.fit_step`` does; the next step overwrites it unless ``want_removal_cost``.

        Args:
            after: what is done with the adjoints, by launches of kernels alone; the graph then contains it. It must do
                the same as long as the addresses of the scene are the same. Give it always, or never.
            least: the least capacity of a graph.
        """
        inputs = (scene, prepared_target)
        if want_removal_cost:
            return self._renderer.fit_step(*inputs, want_removal_cost)
        # A step with these makes tensors of its own, whose memory a graph would not keep.
        has_own = scene.strokes is not None or scene.softness is not None
        has_own = has_own or (scene.gradients is not None and scene.gradients.stops is not None)
        if self.is_paused or not self._record or has_own:
            return _followed(self._renderer.fit_step(*inputs, out=self._out_for(scene)), after)
        recording = self._recording
        if recording is not None and self.has_recorded(scene, prepared_target):
            self._replay(recording, is_checked=after is None)
            return recording.out
        addresses = _addresses(scene, prepared_target)
        out = self._out_for(scene)
        if self._counted is not None and self._counted[0] == addresses:
            self._rehearse(inputs, out, addresses, self._counted[1], after)
        else:
            self._recording = None
            self._renderer.fit_step(*inputs, out=out)
            self._counted = addresses, self._renderer.counts.with_headroom().at_least(least)
        return _followed(out, after)

    def has_recorded(self, scene: Scene, prepared_target: Tensor) -> bool:
        """Return whether there is a graph of the step of ``scene``, which then reads no count."""
        recording = self._recording
        if recording is None or recording.growth != self._renderer.growth:
            return False
        return recording.addresses == _addresses(scene, prepared_target)

    def within(self, draw: Callable[[], _Drawn], bounded: Callable[[], _Drawn] | None = None) -> _Drawn:
        """Return what ``draw`` does with the renderer, with the capacity of the recording if there is one.

        The host then waits once, to look whether that was enough, and not for each count. If not, it draws again.
        ``bounded`` is another way to do the same, within that capacity alone.
        """
        if self._recording is None or self.is_paused:
            return draw()
        self._renderer.set_capacity(self._recording.limit)
        try:
            drawn = (bounded or draw)()
            has_exceeded = self._renderer.has_exceeded
        finally:
            self._renderer.set_capacity(None)
        return draw() if has_exceeded else drawn

    def drawn(self, name: str, scene: Scene, prepared_target: Tensor, draw: Callable[[], _Drawn]) -> _Drawn:
        """Return what ``draw`` does with ``scene``, by a replay of a graph of that if there is one of its step.

        The host waits once, as in `within`. ``draw`` must be launches of kernels alone, write to memory that stays, and
        be the same for each ``name``.
        """
        if not self.has_recorded(scene, prepared_target):
            return draw()
        return self.within(draw, lambda: self._draw_recorded(name, draw))

    def _draw_recorded(self, name: str, draw: Callable[[], _Drawn]) -> _Drawn:
        recording, found = self._recording, self._drawings.get(name)
        assert recording is not None
        if found is not None and found.recording is recording:
            wp.capture_launch(found.graph)
            drawn: _Drawn = found.drawn
            return drawn
        drawn = draw()
        if self._record and self._renderer.growth == recording.growth:
            try:
                self._drawings[name] = _Drawing(self._captured(draw), drawn, recording)
            except (InputError, RuntimeError):  # too little memory, or a driver that cannot record
                self._record = False
        return drawn

    def forget(self) -> None:
        """Drop the recordings; the next step reads its counts and cannot be dropped."""
        self._recording = self._counted = None
        self._drawings.clear()

    def _rehearse(
        self,
        inputs: _Inputs,
        out: Adjoints,
        addresses: _Addresses,
        limit: Counts,
        after: Callable[[Adjoints], None] | None,
    ) -> None:
        """Take a step with the capacity ``limit``, which brings all buffers to their size, and record another one.

        The step that is taken is not followed by ``after``, the recorded one is.
        """
        self._counted = None
        direct = None if self._is_checked else _copies(self._renderer.fit_step(*inputs, out=out))
        self._renderer.set_capacity(limit)
        try:
            graph, growth = self._record_graph(inputs, out, after if direct is None else None)
            followed = graph if direct is None or after is None else self._capture(inputs, out, after)
        except (InputError, RuntimeError):  # too little memory for the capacity, or the driver cannot record
            self._record = False
        finally:
            self._renderer.set_capacity(None)
        if not self._record:
            self._renderer.fit_step(*inputs, out=out)
        elif self._renderer.growth == growth and (direct is None or self._agrees(graph, out, direct)):
            self._recording = _Recording(followed, out, addresses, growth, inputs[0].structure, limit)
            self._replays, self._dropped_steps = 0, self._renderer.dropped_steps

    def _record_graph(
        self, inputs: _Inputs, out: Adjoints, after: Callable[[Adjoints], None] | None
    ) -> tuple[Any, int]:
        """Return the graph of a step, and the growth of the buffers before it was recorded."""
        self._renderer.fit_step(*inputs, out=out)
        growth = self._renderer.growth
        return self._capture(inputs, out, after), growth

    def _capture(self, inputs: _Inputs, out: Adjoints, after: Callable[[Adjoints], None] | None) -> Any:
        """Return the graph of a step, and of what is done ``after`` it."""
        return self._captured(lambda: _followed(self._renderer.fit_step(*inputs, out=out), after))

    def _captured(self, draw: Callable[[], object]) -> Any:
        """Return the graph of what ``draw`` launches."""
        with whole_arrays(), wp.ScopedCapture(device=self._device, force_module_load=False) as capture:
            draw()
        return capture.graph

    def _agrees(self, graph: Any, out: Adjoints, direct: list[Tensor]) -> bool:
        """Return whether a replay gives the same bits as a step that reads counts; if not, stop recording for good."""
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

    def _replay(self, recording: _Recording, is_checked: bool) -> None:
        wp.capture_launch(recording.graph)
        self._replays += 1
        if not is_checked:  # who follows steps looks for dropped ones, at its own times
            return
        if self._replays % _CHECK_GAP == 0 and self._renderer.dropped_steps > self._dropped_steps:
            self._recording = None

    def _out_for(self, scene: Scene) -> Adjoints:
        out = self._out
        if out is None or not _fits(out, scene):
            self._out = out = self._renderer.make_adjoints(scene)
        return out


def _followed(adjoints: Adjoints, after: Callable[[Adjoints], None] | None) -> Adjoints:
    if after is not None:
        after(adjoints)
    return adjoints


def _fits(out: Adjoints, scene: Scene) -> bool:
    """Return whether the adjoints of ``scene`` have the shapes of ``out``."""
    paints = scene.gradients
    same_paints = (out.end_color is None) == (paints is None)
    same_paints &= (out.offset is None) == (paints is None or paints.stops is None)
    same_paints = same_paints and (out.width is None) == (scene.strokes is None)
    same_paints = same_paints and (out.softness is None) == (scene.softness is None)
    same_paints = same_paints and (out.side_opacity is None) == (scene.side_opacity is None)
    return same_paints and out.segments.shape == scene.segments.shape and len(out.color) == len(scene)


def _addresses(scene: Scene, prepared_target: Tensor) -> _Addresses:
    structure = scene.structure
    values = (scene.segments, scene.color, scene.opacity, scene.background)
    paints = scene.gradients
    gradients = () if paints is None else (paints.kind, paints.geometry, paints.end_color)
    sides = () if scene.side_opacity is None else (scene.side_opacity.value,)
    tensors = (*values, *gradients, *sides, structure.loop_first_segment, structure.path_first_loop, prepared_target)
    return tuple((tensor.data_ptr(), tensor.shape) for tensor in tensors)


def _can_record(device: Any) -> bool:
    # Sums and sorts need scratch memory, which a graph takes from the memory pool.
    return bool(device.is_cuda and wp.is_mempool_enabled(device))


def _tensors(adjoints: Adjoints) -> list[Tensor]:
    values = (getattr(adjoints, field.name) for field in fields(Adjoints))
    return [value for value in values if value is not None]


def _copies(adjoints: Adjoints) -> list[Tensor]:
    return [value.clone() for value in _tensors(adjoints)]


def _equal_bits(first: list[Tensor], second: list[Tensor]) -> bool:
    pairs = zip(first, second, strict=True)
    return all(torch.equal(a.view(torch.uint8), b.view(torch.uint8)) for a, b in pairs)
