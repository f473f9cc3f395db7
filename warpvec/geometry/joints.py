"""The kinds of the nodes and segments of a drawing: corners, smooth nodes and straight lines, and how to keep them.

A node is the anchor of a row. It is *smooth* if the outline does not change its direction there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.geometry.scene import Scene

SMOOTH_DEGREES = 1.0
"""Largest change of direction at a smooth node."""

HANDLE_ERROR, ROUNDING_DEGREES_MAX = 0.07, 3.0
"""A file may state handles with an error of so many pixels (one decimal, in both directions). The angle that
such an error can make is added to `SMOOTH_DEGREES`, but at most so many degrees as the second number."""

HANDLE_MIN = 0.25
"""Handles of smooth nodes get no shorter than so many pixels, unless they are so from the beginning. A handle of no
length has no direction, and the node becomes a corner."""

BOUND_ERROR = 1e-3
"""A handle longer than the least length by less than this share is at the bound."""

STRAIGHT = 0.05
"""A curve whose handles lie within so many pixels of the thirds of its chord is a line. Tracers write all lines so."""

LENGTH_MIN = 1e-3
"""Handles that are shorter, in pixels, have no direction."""


def with_lines(scene: Scene) -> Scene:
    """Return the cubic ``scene`` with every straight curve marked as a line; a uniform scene stays uniform."""
    if scene.is_uniform or scene.degree != 3:
        return scene
    structure, segments = scene.structure, scene.segments
    start, end = segments[:, 0], segments[structure.segment_next.long(), 0]
    thirds = [start + (end - start) * share for share in (1 / 3, 2 / 3)]
    off = torch.stack([(segments[:, k + 1] - thirds[k]).norm(dim=1) for k in (0, 1)]).amax(0)
    is_line = (off < STRAIGHT) | structure.lines
    if scene.forms is not None:  # a form knows its lines
        is_line = torch.where(scene.forms.is_form[structure.segment_path.long()], structure.lines, is_line)
    return replace(scene, structure=replace(structure, is_line=is_line if is_line.any() else None))


def without_kinds(scene: Scene) -> Scene:
    """Return ``scene`` with lines as curves that happen to be straight, and forms as outlines."""
    scene = scene.outlined()
    return scene if scene.is_uniform else replace(scene, structure=replace(scene.structure, is_line=None))


@dataclass(frozen=True)
class Joints:
    """The nodes of a cubic scene, with handles relative to them, and what must stay as it is.

    Attributes:
        following, preceding: row of the next and the previous node [R].
        is_line: rows that are lines [R].
        is_smooth: smooth nodes with a handle on at least one side [R].
        least: least lengths of the leaving and the arriving handle of each node [R, 2].
    """

    following: Tensor
    preceding: Tensor
    is_line: Tensor
    is_smooth: Tensor
    least: Tensor

    @staticmethod
    def of(scene: Scene, *, keep: bool = True) -> Joints:
        """Return the nodes of ``scene``; without ``keep``, none counts as smooth."""
        structure = scene.structure
        following, preceding = structure.segment_next.long(), structure.segment_previous.long()
        is_line, least = structure.lines, torch.zeros_like(scene.segments[:, 0])
        free = Joints(following, preceding, is_line, torch.zeros_like(is_line), least)
        lengths = torch.stack([handle.norm(dim=1) for handle in free.values(scene)[1:]], 1)
        free = replace(free, least=lengths.clamp_max(HANDLE_MIN))
        return replace(free, is_smooth=free._smooth(scene) & ~structure.line_ends) if keep else free

    def values(self, scene: Scene) -> tuple[Tensor, Tensor, Tensor]:
        """Return the anchors, and the leaving and arriving handles relative to them, each [R, 2]."""
        anchor = scene.segments[:, 0]
        arriving = (scene.segments[:, 2] - anchor[self.following])[self.preceding]
        return anchor, scene.segments[:, 1] - anchor, arriving

    def segments(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> Tensor:
        """Return the control points [R, 3, 2] with these `values`, after lines and smooth nodes are made so again.

        The handles of a smooth node are projected onto their mean direction, or onto that of the line beside it.
        """
        leaving, arriving = self.aligned(anchor, leaving, arriving)
        end = anchor[self.following]
        chord, is_line = end - anchor, self.is_line[:, None]
        first = torch.where(is_line, anchor + chord / 3.0, anchor + leaving)
        second = torch.where(is_line, anchor + chord * 2.0 / 3.0, end + arriving[self.following])
        return torch.stack([anchor, first, second], 1)

    def held(self, points: list[Tensor], adjoints: list[Tensor]) -> Tensor:
        """Return which leaving and arriving handles [R, 2] are as short as they may be and would get shorter.

        Args:
            points: `values`, of aligned handles.
            adjoints: the derivatives of a loss by these.
        """
        mean, least = self.directions(*points), self.least.to(points[0].dtype)
        sides = torch.stack([(points[1] * mean).sum(1), -(points[2] * mean).sum(1)], 1)
        falls = torch.stack([(adjoints[1] * mean).sum(1) > 0.0, (adjoints[2] * mean).sum(1) < 0.0], 1)
        return self.is_smooth[:, None] & (sides <= least * (1.0 + BOUND_ERROR)) & falls

    def aligned(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> tuple[Tensor, Tensor]:
        """Return the handles with those of smooth nodes along one direction."""
        mean = self.directions(anchor, leaving, arriving)
        smooth = self.is_smooth[:, None]
        least = self.least.to(anchor.dtype)
        forward = _at_least((leaving * mean).sum(1), least[:, 0])[:, None]
        backward = -_at_least(-(arriving * mean).sum(1), least[:, 1])[:, None]
        return torch.where(smooth, forward * mean, leaving), torch.where(smooth, backward * mean, arriving)

    def directions(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> Tensor:
        """Return the mean direction of the outline at each node, or that of the line beside it: [R, 2] of length 1."""
        ahead, behind = self.ahead_and_behind(anchor, leaving, arriving)
        mean = torch.where(self.is_line[:, None], ahead, ahead + behind)
        return unit_vectors(torch.where(self.is_line[self.preceding][:, None], behind, mean))

    def ahead_and_behind(self, anchor: Tensor, leaving: Tensor, arriving: Tensor) -> tuple[Tensor, Tensor]:
        """Return where the outline goes to after, and comes from before, each node [R, 2], with lengths in pixels."""
        chord, is_line = anchor[self.following] - anchor, self.is_line[:, None]
        ahead = torch.where(is_line, chord, leaving)
        behind = torch.where(is_line[self.preceding], chord[self.preceding], -arriving)
        return ahead, behind

    def _smooth(self, scene: Scene) -> Tensor:
        ahead, behind = self.ahead_and_behind(*self.values(scene))
        lengths = torch.stack([ahead.norm(dim=1), behind.norm(dim=1)])
        rounding = (HANDLE_ERROR / lengths.amin(0).clamp_min(1e-9)).clamp_max(math.radians(ROUNDING_DEGREES_MAX))
        cosine = (unit_vectors(ahead) * unit_vectors(behind)).sum(1)
        is_straight = cosine > (math.radians(SMOOTH_DEGREES) + rounding).cos()
        has_handle = ~(self.is_line & self.is_line[self.preceding])
        return is_straight & has_handle & (lengths.amin(0) > LENGTH_MIN)


def _at_least(values: Tensor, least: Tensor) -> Tensor:
    """Return the larger values, with the derivative of ``values``, so that a short handle can tell if it would grow."""
    return values + (torch.maximum(values, least) - values).detach()


def unit_vectors(vectors: Tensor) -> Tensor:
    """Return ``vectors`` [N, 2] with the length 1; shorter than 1e-6 they get shorter ones."""
    return vectors / vectors.norm(dim=1, keepdim=True).clamp_min(1e-6)
