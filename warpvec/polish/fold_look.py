"""Look for folds of a drawing in a few launches, which takes a fifth of the time of their many small steps."""

from __future__ import annotations

from types import SimpleNamespace

import torch
import warp as wp
from torch import Tensor

from warpvec.geometry import crossings, joints, rounding
from warpvec.geometry.scene import Scene
from warpvec.kernels import folds
from warpvec.kernels.making import made_once
from warpvec.polish.machine import machine_of_thread
from warpvec.rendering.launch import as_warp

PAIRS_MAX = 2**22
"""Most pairs of curves of the same paths: each pair is looked at, which takes a few nanoseconds."""


@made_once  # type: ignore[untyped-decorator]
def _kernels() -> SimpleNamespace:
    return folds.make_kernels(fold_numbers())


def fold_numbers() -> SimpleNamespace:
    """Return the constants that the kernels share with the modules that they stand for."""
    return SimpleNamespace(
        smooth_degrees=joints.SMOOTH_DEGREES, handle_error=joints.HANDLE_ERROR, length_min=joints.LENGTH_MIN,
        rounding_degrees_max=joints.ROUNDING_DEGREES_MAX, turn_max=rounding.TURN_MAX, reach=rounding.REACH,
        chords=crossings.CHORDS, fold_min=crossings.FOLD_MIN, fold_width=crossings.FOLD_WIDTH,
    )  # fmt: skip


class FoldLook:
    """Looks at drawings of the structure of ``scene``, as a file with ``precision`` decimals states them."""

    def __init__(self, scene: Scene, precision: int) -> None:
        structure = scene.structure
        self._ticks, self._count, self._path_count = 10.0**precision, structure.segment_count, len(scene)
        names = ("segment_next", "segment_previous", "segment_path", "loop_first_segment", "path_first_segment")
        rows = [as_warp(getattr(structure, name), wp.int32) for name in names]
        self._next, self._previous, self._path, self._loop_first, self._path_first = rows
        self._kinds = [as_warp(each, wp.bool) for each in (structure.lines, structure.line_ends)]
        sizes = structure.loop_first_segment.diff().long()
        self._loop = as_warp(torch.arange(len(sizes)).repeat_interleave(sizes).int(), wp.int32)
        self._machine = machine_of_thread()

    @staticmethod
    def is_possible(scene: Scene) -> bool:
        """Return whether ``scene`` can be looked at: on the CPU, not uniform, without forms, and of few curves."""
        is_plain = scene.segments.device.type == "cpu" and scene.segments.dtype == torch.float32
        if not is_plain or scene.is_uniform or scene.forms is not None:
            return False
        return int(scene.structure.path_first_segment.diff().long().square().sum()) <= PAIRS_MAX

    def written(self, segments: Tensor) -> wp.array:
        """Return the curves [R, 4] with the nodes of ``segments`` [R, 3, 2] as the file has them."""
        get, count = self._machine.get, self._count
        nodes = [get(f"tick_{name}", count, wp.vec2d) for name in ("anchor", "leaving", "arriving")]
        found = get("written", (count, 4), wp.vec2d)
        inputs = [self._ticks, count, as_warp(segments, wp.vec2f), self._next, self._previous, *self._kinds]
        self._machine.launch(_kernels().round_nodes, 1, [*inputs, *nodes, found])
        return found

    def crossings(self, written: wp.array, is_counted: Tensor) -> Tensor:
        """Return what `crossings_of_rows` does: how often each curve crosses another one of its path [R]."""
        get, count, chords = self._machine.get, self._count, crossings.CHORDS
        found = torch.empty(count, dtype=torch.int32)
        scratch = [get("chord_place", chords * count, wp.vec2d), get("row_box", (count, 2), wp.vec2d)]
        scratch += [get(f"chord_{name}", chords * count + 1, wp.float64) for name in ("areas", "lengths")]
        rows = [self._next, self._loop, self._loop_first, self._path_first, as_warp(is_counted, wp.bool)]
        outputs = [*scratch, as_warp(found, wp.int32)]
        self._machine.launch(_kernels().count_crossings, 1, [count, self._path_count, written, *rows, *outputs])
        return found.long()

    def overshoots(self, written: wp.array, width: Tensor) -> Tensor:
        """Return what `overshoots` does for strokes of the ``width`` [N]: which curves turn back [R]."""
        found = torch.empty(self._count, dtype=torch.bool)
        arguments = [self._count, written, self._path, as_warp(width, wp.float32), as_warp(found, wp.bool)]
        self._machine.launch(_kernels().find_overshoots, 1, arguments)
        return found
