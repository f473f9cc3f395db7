"""The curves of a drawing as they follow its values: points in one launch, and their derivatives by rows of values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import torch
import warp as wp
from torch import Tensor

from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene
from warpvec.kernels import aligned_nodes
from warpvec.polish.machine import machine_of_thread
from warpvec.rendering.launch import as_warp

if TYPE_CHECKING:  # photos need no matrix, and loading SciPy takes a tenth of a second
    from scipy import sparse


@dataclass(frozen=True)
class RowSlopes:
    """How the values of rows follow those of a drawing; see ``kernels/row_slopes.py``."""

    slopes: wp.array
    value: wp.array
    count: wp.array


class CurveRows:
    """The curves of ``scene``, whose nodes are ``joints``.

    Args:
        scene: the drawing.
        joints: its nodes.
        first_width: the value that is the width of the first path, or -1 if there are no strokes.
        first_form: the value that is the first parameter of the first form.
    """

    def __init__(self, scene: Scene, joints: Joints, first_width: int, first_form: int) -> None:
        self._structure, self._joints = scene.structure, joints
        self._first_width, self._first_form = first_width, first_form
        self._dtype, self._device = wp.dtype_from_torch(scene.segments.dtype), str(scene.segments.device)
        self._kernel = aligned_nodes.make_kernels(self._dtype).align_nodes
        self._vec2 = wp.types.vector(2, dtype=self._dtype)
        self._nodes = self._arrays(scene.segments.device, joints.least.to(scene.segments), self._vec2)

    def _arrays(self, device: torch.device | str, least: Tensor, vec2: type) -> list[wp.array]:
        names = ("segment_next", "segment_previous")
        rows = [as_warp(getattr(self._structure, name).to(device), wp.int32) for name in names]
        kinds = [as_warp(each.to(device), wp.bool) for each in (self._joints.is_line, self._joints.is_smooth)]
        return [*rows, *kinds, as_warp(least.to(device), vec2)]

    def place(self, points: Sequence[Tensor]) -> tuple[Tensor, Tensor, Tensor]:
        """Return the aligned leaving and arriving handles [R, 2] of ``points``, and the control points [R, 3, 2].

        The points are `Joints.values`.
        """
        anchor, leaving, arriving = points
        found = torch.empty_like(leaving), torch.empty_like(arriving), leaving.new_empty((len(leaving), 3, 2))
        values = [as_warp(each, self._vec2) for each in (anchor, leaving, arriving, *found)]
        machine_of_thread(self._device).launch(self._kernel, len(anchor), [*self._nodes, *values])
        return found

    @cached_property
    def _on_host(self) -> list[wp.array]:
        arrays = self._arrays("cpu", self._joints.least.float(), wp.vec2f)
        path = as_warp(self._structure.segment_path.cpu(), wp.int32)
        return [*arrays[:2], path, *arrays[2:]]

    def slopes(self, points: Sequence[Tensor], held: Tensor | None, by_forms: sparse.csr_matrix | None) -> RowSlopes:
        """Return how rows follow the values, in memory that the next call overwrites.

        Rows of forms follow points too, which are not free.

        Args:
            points: `Joints.values`.
            held: handles [R, 2] that keep their length; None for none.
            by_forms: derivative of the curves by the parameters of forms; None without forms.
        """
        machine, count = machine_of_thread(), len(points[0])
        held = torch.zeros((count, 2), dtype=torch.bool) if held is None else held.cpu()
        found = RowSlopes(*machine.row_slopes(count))
        values = [as_warp(each.cpu().float(), wp.vec2f) for each in points]
        into = [found.slopes, found.value, found.count]
        arguments = [count, *self._on_host, as_warp(held, wp.bool), *values, self._first_width, *into]
        machine.run("follow_points", arguments)
        if by_forms is not None:
            _add_forms(by_forms, self._first_form, found)
        return found

    def adjoint(self, slopes: RowSlopes, adj_segments: Tensor, count: int) -> Tensor:
        """Return the adjoints [count] of the values that curves follow, in float64, for those of the curves."""
        found = torch.zeros(count, dtype=torch.float64)
        rows = as_warp(adj_segments.cpu().float(), wp.vec2f)
        arguments = [len(adj_segments), rows, slopes.slopes, slopes.value, slopes.count, as_warp(found, wp.float64)]
        machine_of_thread().run("gather_adjoint", arguments)
        return found.to(adj_segments.device)


def _add_forms(by_forms: sparse.csr_matrix, first: int, into: RowSlopes) -> None:
    """Add the columns of the parameters of forms, of which the first is the value ``first``."""
    rows = np.flatnonzero(np.diff(by_forms.indptr[::8]))
    slopes = by_forms.data.reshape(len(rows), 8, -1).swapaxes(1, 2)
    parameters = first + by_forms.indices.reshape(len(rows), 8, -1)[:, 0]
    place = into.count.numpy()[rows][:, None] + np.arange(parameters.shape[1])
    into.slopes.numpy()[rows[:, None], place] = np.pad(slopes, ((0, 0), (0, 0), (0, 1)))
    into.value.numpy()[rows[:, None], place] = parameters
    into.count.numpy()[rows] += parameters.shape[1]
