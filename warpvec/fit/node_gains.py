"""Predict what a new anchor gains and what an anchor is worth, from the adjoint of the outlines.

Let an outline move by d(s) across itself, along its length s. The image then changes by c d in the pixels at the
outline, where c is the contrast: the change of a pixel when the path covers it. To second order the loss changes by the
integral of g d + h d^2 / 2 over the length, with the adjoint g of the outline and the stiffness h = 2 c^2 / (3 h w).

**A new anchor** in the middle of a segment lets d follow splines of two cubics, three more dimensions than the segment
itself has. Let q1, q2, q3 be orthonormal over the segment and orthogonal to all cubics, and a1, a2, a3 the components
of g along them. The best d in these dimensions gains (a1^2 + a2^2 + a3^2) / (2 h) over the length of the segment.

**An anchor** is worth what is lost if one cubic replaces the two at it: the integral of h d^2 / 2 over the distance d
between the old and the new outline. The loss grows with |d| where d is more than a pixel, as whole pixels change then.
The term with g is left out: a fitted outline has no slope along what its points can follow, only noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import torch
from torch import Tensor

from warpvec.geometry.quick_merge import QuickMerges
from warpvec.geometry.structure import Structure
from warpvec.rendering.outline_adjoint import OutlineAdjoint

_NODES = 512
"""Points of the quadrature that makes the three functions of a new anchor orthonormal."""

_AREA_ADDED = 1.0
"""Square pixels added to the area of a path, so that the contrast of one without area is finite."""

_TINY = 1e-30
"""Added to what is divided by, where a path does not show."""


@dataclass(frozen=True)
class NodeValues:
    """The value of anchors to the loss, for each segment [R].

    Attributes:
        gain: what an anchor in the middle of the segment would gain.
        length: length of the segment in pixels.
        stiffness: h of its path.
    """

    gain: Tensor
    length: Tensor
    stiffness: Tensor


def node_values(structure: Structure, outline: OutlineAdjoint, contrast: Tensor) -> NodeValues:
    """Return the values of anchors, all in float64 on the CPU.

    Args:
        structure: that of the scene, on the CPU.
        outline: the adjoint of its outlines.
        contrast: the sum of c^2 / (3 h w) over the pixels of each path [N].
    """
    first, count = outline.segment_first_vertex, structure.segment_count
    chords = first.diff()
    segment = torch.arange(count).repeat_interleave(chords)
    following = torch.arange(1, len(segment) + 1)
    following[first[1:] - 1] = first[structure.segment_next.long()]
    step = outline.vertices[following] - outline.vertices
    chord_length = step.norm(dim=1)
    across = torch.stack([-step[:, 1], step[:, 0]], 1) / (chord_length[:, None] + _TINY)
    at_start, at_end = ((part * across).sum(1, keepdim=True) for part in torch.split(outline.adj_edges, 2, 1))
    place = torch.arange(len(segment)) - first[segment]
    start, end = ((place + more).double() / chords[segment] for more in (0, 1))
    parts = _new_directions(start) * at_start + _new_directions(end) * at_end
    components = _sums(parts, segment, count)
    length = _sums(chord_length, segment, count)
    path = structure.segment_path.long()
    vertices, after = outline.vertices, outline.vertices[following]
    area = _sums((vertices[:, 0] * after[:, 1] - vertices[:, 1] * after[:, 0]) / 2.0, path[segment], len(contrast))
    stiffness = (2.0 * contrast.clamp_min(0.0) / (area.abs() + _AREA_ADDED))[path]
    return NodeValues(components.square().sum(1) / (2.0 * stiffness * length + _TINY), length, stiffness)


def merge_costs(values: NodeValues, merges: QuickMerges) -> Tensor:
    """Return the loss [R] of replacing each row and the row before it by one cubic."""
    squares = torch.minimum(merges.offset.square(), merges.offset.abs())
    return 0.5 * values.stiffness * (merges.length * squares).sum(1)


def _sums(values: Tensor, owner: Tensor, count: int) -> Tensor:
    """Return the sums of ``values`` of each of ``count`` owners. On the CPU they are added in order."""
    return values.new_zeros(count, *values.shape[1:]).index_add_(0, owner, values)


def _new_directions(t: Tensor) -> Tensor:
    """Return the three functions of a new anchor at ``t`` [V]: [V, 3]."""
    return _monomials(t) @ _orthonormal()


def _monomials(t: Tensor) -> Tensor:
    """Return the powers up to three of ``t``, and of what it is beyond the middle, where a new anchor lies [V, 7]."""
    beyond = (t - 0.5).clamp_min(0.0)
    square, beyond_square = t * t, beyond * beyond
    powers = [torch.ones_like(t), t, square, square * t, beyond, beyond_square, beyond_square * beyond]
    return torch.stack(powers, 1)


@cache
def _orthonormal() -> Tensor:
    """Return the three functions of a new anchor as sums of the seven monomials [7, 3].

    They are the last of an orthonormal basis that begins with the cubics.
    """
    t = (torch.arange(_NODES, dtype=torch.float64) + 0.5) / _NODES
    triangle = torch.linalg.qr(_monomials(t) / _NODES**0.5).R
    return torch.linalg.inv(triangle)[:, 4:]
