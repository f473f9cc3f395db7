"""The kinds of the nodes and segments of a drawing: corners, smooth nodes and straight lines, and how to keep them.

A node is the anchor of a row. It is *smooth* if the outline does not change its direction there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy import sparse
from torch import Tensor

from warpvec.geometry.scene import Scene

SMOOTH_DEGREES = 1.0
"""Largest change of direction at a smooth node."""

HANDLE_ERROR, ROUNDING_DEGREES_MAX = 0.07, 3.0
"""A file may state handles with an error of so many pixels (one decimal, in both directions). The angle that
such an error can make is added to `SMOOTH_DEGREES`, but at most so many degrees as the second number."""

STRAIGHT = 0.05
"""A curve whose handles lie within so many pixels of the thirds of its chord is a line. Tracers write all lines so."""

_LENGTH_MIN = 1e-3
"""Handles that are shorter, in pixels, have no direction."""


def with_lines(scene: Scene) -> Scene:
    """Return the cubic ``scene`` with every straight curve marked as a line; a uniform scene stays uniform."""
    if scene.is_uniform or scene.degree != 3:
        return scene
    structure, segments = scene.structure, scene.segments
    start, end = segments[:, 0], segments[structure.segment_next.long(), 0]
    thirds = [start + (end - start) * share for share in (1 / 3, 2 / 3)]
    off = torch.stack([(segments[:, k + 1] - thirds[k]).norm(dim=1) for k in (0, 1)]).amax(0)
    is_line = off < STRAIGHT
    if structure.is_line is not None:
        is_line |= structure.is_line
    return replace(scene, structure=replace(structure, is_line=is_line if is_line.any() else None))


def without_kinds(scene: Scene) -> Scene:
    """Return ``scene`` with lines as curves that happen to be straight."""
    return scene if scene.is_uniform else replace(scene, structure=replace(scene.structure, is_line=None))


@dataclass(frozen=True)
class Joints:
    """The nodes of a cubic scene, with handles relative to them, and what must stay as it is.

    Attributes:
        following, preceding: row of the next and the previous node [R].
        is_line: rows that are lines [R].
        is_smooth: smooth nodes with a handle on at least one side [R].
    """

    following: Tensor
    preceding: Tensor
    is_line: Tensor
    is_smooth: Tensor

    @staticmethod
    def of(scene: Scene, *, keep: bool = True) -> Joints:
        """Return the nodes of ``scene``; without ``keep``, none counts as smooth."""
        structure = scene.structure
        following, preceding = structure.segment_next.long(), structure.segment_previous.long()
        none = torch.zeros(len(scene.segments), dtype=torch.bool, device=scene.segments.device)
        is_line = none if structure.is_line is None else structure.is_line
        free = Joints(following, preceding, is_line, none)
        return replace(free, is_smooth=free._smooth(scene)) if keep else free

    def values(self, scene: Scene) -> tuple[Tensor, Tensor, Tensor]:
        """Return the anchors, and the leaving and arriving handles relative to them, each [R, 2]."""
        anchor = scene.segments[:, 0]
        arriving = (scene.segments[:, 2] - anchor[self.following])[self.preceding]
        return anchor, scene.segments[:, 1] - anchor, arriving

    def segments(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> Tensor:
        """Return the control points [R, 3, 2] with these `values`, after lines and smooth nodes are made so again.

        The handles of a smooth node are projected onto their mean direction, or onto that of the line beside it.
        """
        leaving, arriving = self._aligned(anchor, leaving, arriving)
        end = anchor[self.following]
        chord, is_line = end - anchor, self.is_line[:, None]
        first = torch.where(is_line, anchor + chord / 3.0, anchor + leaving)
        second = torch.where(is_line, anchor + chord * 2.0 / 3.0, end + arriving[self.following])
        return torch.stack([anchor, first, second], 1)

    def derivative(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> sparse.csr_matrix:
        """Return the derivative of the curves by the `values` [8 R, 6 R], in float64.

        Its rows are the coordinates of four points of each curve, its end included; its columns those of all anchors,
        then all leaving and all arriving handles.
        """
        blocks = _Blocks(len(anchor))
        own = torch.arange(len(anchor), device=anchor.device)
        for point, k in ((0, 0), (3, 1)):
            blocks.add(point, own, 0, (own, self.following)[k], 1.0)
        line, curve = own[self.is_line], own[~self.is_line]
        for point, share in ((1, 1 / 3), (2, 2 / 3)):
            blocks.add(point, line, 0, line, 1.0 - share)
            blocks.add(point, line, 0, self.following[line], share)
        blocks.add(1, curve, 0, curve, 1.0)
        blocks.add(2, curve, 0, self.following[curve], 1.0)
        for kind, node, found in self._turning(anchor.double(), leaving.double(), arriving.double()):
            blocks.add(1, curve, kind, node[curve], found[0][curve])
            blocks.add(2, curve, kind, node[self.following[curve]], found[1][self.following[curve]])
        return blocks.matrix()

    def _turning(
        self, anchor: Tensor, leaving: Tensor, arriving: Tensor
    ) -> Iterator[tuple[int, Tensor, tuple[Tensor, Tensor]]]:
        """Yield the derivatives of the aligned handles of each node: by a kind of value, of which node, and both."""
        ahead, behind = self._directions(anchor, leaving, arriving)
        is_line, after_line = self.is_line, self.is_line[self.preceding]
        by_ahead, by_behind = (~after_line).double(), (~is_line).double()
        mean = by_ahead[:, None] * ahead + by_behind[:, None] * behind
        length, unit = mean.norm(dim=1).clamp_min(1e-6), _unit(mean)
        along = unit[:, :, None] * unit[:, None, :]
        whole = torch.eye(2, dtype=along.dtype, device=along.device).expand_as(along)
        across = (whole - along) / length[:, None, None]
        reach = [(leaving * unit).sum(1).clamp_min(0.0), (arriving * unit).sum(1).clamp_max(0.0)]
        sides = [unit[:, :, None] * (handle[:, None] @ across) for handle in (leaving, arriving)]
        is_long = [(length != 0.0)[:, None, None] for length in reach]
        turns = [
            torch.where(some, length[:, None, None] * across + side, 0.0)
            for some, length, side in zip(is_long, reach, sides, strict=True)
        ]
        smooth, zero = self.is_smooth[:, None, None], torch.zeros_like(along)
        chord_after, chord_before = by_ahead * is_line, by_behind * after_line
        own = torch.arange(len(anchor), device=anchor.device)
        parts = [
            (1, own, by_ahead * ~is_line, (1.0, 0.0)),
            (2, own, -by_behind * ~after_line, (0.0, 1.0)),
            (0, self.following, chord_after, (0.0, 0.0)),
            (0, own, chord_before - chord_after, (0.0, 0.0)),
            (0, self.preceding, -chord_before, (0.0, 0.0)),
        ]
        for kind, node, share, direct in parts:
            found = [
                torch.where(smooth, share[:, None, None] * turn + part * some * along, part * whole + zero)
                for turn, some, part in zip(turns, is_long, direct, strict=True)
            ]
            yield kind, node, (found[0], found[1])

    def _aligned(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> tuple[Tensor, Tensor]:
        ahead, behind = self._directions(anchor, leaving, arriving)
        mean = torch.where(self.is_line[:, None], ahead, ahead + behind)
        mean = _unit(torch.where(self.is_line[self.preceding][:, None], behind, mean))
        smooth = self.is_smooth[:, None]
        forward = (leaving * mean).sum(1, keepdim=True).clamp_min(0.0)
        backward = (arriving * mean).sum(1, keepdim=True).clamp_max(0.0)
        return torch.where(smooth, forward * mean, leaving), torch.where(smooth, backward * mean, arriving)

    def _directions(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> tuple[Tensor, Tensor]:
        """Return where the outline goes to after, and comes from before, each node [R, 2], with lengths in pixels."""
        chord, is_line = anchor[self.following] - anchor, self.is_line[:, None]
        ahead = torch.where(is_line, chord, leaving)
        behind = torch.where(is_line[self.preceding], chord[self.preceding], -arriving)
        return ahead, behind

    def _smooth(self, scene: Scene) -> Tensor:
        ahead, behind = self._directions(*self.values(scene))
        lengths = torch.stack([ahead.norm(dim=1), behind.norm(dim=1)])
        rounding = (HANDLE_ERROR / lengths.amin(0).clamp_min(1e-9)).clamp_max(math.radians(ROUNDING_DEGREES_MAX))
        cosine = (_unit(ahead) * _unit(behind)).sum(1)
        is_straight = cosine > (math.radians(SMOOTH_DEGREES) + rounding).cos()
        has_handle = ~(self.is_line & self.is_line[self.preceding])
        return is_straight & has_handle & (lengths.amin(0) > _LENGTH_MIN)


class _Blocks:
    """Gathers blocks of 2 x 2 of a sparse matrix."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._parts: list[tuple[Tensor, Tensor, Tensor]] = []

    def add(self, point: int, curve: Tensor, kind: int, node: Tensor, value: Tensor | float) -> None:
        """Add a block each, or a factor: of a ``point`` of each ``curve`` by a ``kind`` of value of each ``node``."""
        if isinstance(value, float):
            value = value * torch.eye(2, dtype=torch.float64, device=curve.device).expand(len(curve), 2, 2)
        self._parts.append((4 * curve + point, kind * self._count + node, value))

    def matrix(self) -> sparse.csr_matrix:
        row, column, value = (torch.cat(part).cpu().numpy() for part in zip(*self._parts, strict=True))
        pair = np.arange(2)
        rows = np.broadcast_to(2 * row[:, None, None] + pair[:, None], value.shape)
        columns = np.broadcast_to(2 * column[:, None, None] + pair[None], value.shape)
        shape = (8 * self._count, 6 * self._count)
        return sparse.csr_matrix((value.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def _unit(vectors: Tensor) -> Tensor:
    return vectors / vectors.norm(dim=1, keepdim=True).clamp_min(1e-6)
