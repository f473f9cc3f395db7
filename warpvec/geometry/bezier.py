"""Bernstein weights and bounding boxes of Bezier curves of any degree."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure


def bernstein(degree: int, t: Tensor) -> Tensor:
    """Return the Bernstein weights [..., M + 1] of the control points of a curve of degree M at ``t`` [...]."""
    weights = [math.comb(degree, j) * (1.0 - t) ** (degree - j) * t**j for j in range(degree + 1)]
    return torch.stack(weights, -1)


# Points along a curve that its bounding box is taken from. A half circle exceeds the box by 0.5 % of its radius.
_BOX_SAMPLES = 17


def whole_curves(scene: Scene) -> Tensor:
    """Return the control points [R, M + 1, 2] of each segment, its end included."""
    ends = scene.segments[scene.structure.segment_next.long(), :1]
    return torch.cat([scene.segments, ends], 1)


def path_boxes(scene: Scene) -> Tensor:
    """Return left, top, right and bottom [N, 4] of the paths of ``scene``, from sample points along the curves.

    A stroke reaches as far as its caps and miters may.
    """
    boxes = outline_boxes(scene.segments, scene.structure)
    if scene.strokes is None:
        return boxes
    reach = scene.strokes.reach[:, None].expand(-1, 2)
    return boxes + torch.cat([-reach, reach], 1)


def outline_boxes(segments: Tensor, structure: Structure) -> Tensor:
    """Return the boxes [N, 4] of the outlines of ``segments`` [R, M, 2], without the reach of strokes."""
    ends = segments[structure.segment_next.long(), :1]
    parameters = torch.linspace(0.0, 1.0, _BOX_SAMPLES, dtype=segments.dtype, device=segments.device)
    outline = bernstein(segments.shape[1], parameters) @ torch.cat([segments, ends], 1)
    return torch.cat([_least(outline.amin(1), structure), -_least(-outline.amax(1), structure)], -1)


def _least(values: Tensor, structure: Structure) -> Tensor:
    """Return the least of the ``values`` [R, 2] of each path's rows [N, 2]."""
    if structure.uniform_count is not None:
        return values.reshape(structure.path_count, structure.uniform_count, 2).amin(1)
    rows = structure.segment_path.long()[:, None].expand_as(values)
    return values.new_full((structure.path_count, 2), torch.inf).scatter_reduce_(0, rows, values, "amin")
