"""An independent renderer in float64 torch: plain, slow, and differentiable by autograd.

It shares no algorithm with the kernels. They accumulate signed areas edge by edge along a row; here every pixel looks
at the whole polygon on its own (see ``reference.coverage``), and autograd differentiates what is written.
"""

from __future__ import annotations

import torch
from torch import Tensor

from reference.compositing import composite
from reference.coverage import coverage, signed_coverage
from reference.flattening import flatten, flatten_loop

__all__ = ["compound_coverage", "coverage_stack", "mean_squared_error", "removal_cost", "render"]


def compound_coverage(paths: list[list[Tensor]], counts: list[list[list[int]]], height: int, width: int) -> Tensor:
    """Return the coverage [N, h, w] of paths of several loops [3 S, 2], each with its own S chord counts.

    Windings add: a point has that of each of the path's loops.
    """
    layers = []
    for loops, loop_counts in zip(paths, counts, strict=True):
        polygons = [flatten_loop(loop, row) for loop, row in zip(loops, loop_counts, strict=True)]
        layers.append(coverage(sum(signed_coverage(polygon, height, width) for polygon in polygons)))
    return torch.stack(layers)


def coverage_stack(points: Tensor, counts: Tensor, height: int, width: int) -> Tensor:
    """Return the coverage [N, h, w] of paths [N, 3 S, 2] with ``counts`` [N, S] chords per segment."""
    layers = [coverage(signed_coverage(polygon, height, width)) for polygon in flatten(points, counts)]
    return torch.stack(layers) if layers else points.new_zeros(0, height, width)


def render(
    points: Tensor, color: Tensor, opacity: Tensor, background: Tensor, height: int, width: int, counts: Tensor
) -> Tensor:
    """Return the image [h, w, 3] of N paths, row 0 at the bottom.

    Args:
        points: control points [N, 3 S, 2] in pixels.
        color: fill [N, 3] in [0, 1].
        opacity: fill opacity [N] in [0, 1].
        background: background colour [3] in [0, 1].
        height: rows of the canvas.
        width: columns of the canvas.
        counts: chords per segment [N, S].
    """
    return composite(coverage_stack(points, counts, height, width), color, opacity, background)


def removal_cost(
    points: Tensor, color: Tensor, opacity: Tensor, background: Tensor, target: Tensor, counts: Tensor
) -> Tensor:
    """Return the rise of the mean squared error against ``target`` [h, w, 3] when a path is removed, per path [N].

    Negative where the image is better without the path. Found by drawing the scene again without it.
    """
    stack = coverage_stack(points, counts, *target.shape[:2])
    error = mean_squared_error(composite(stack, color, opacity, background), target)
    rises = []
    for row in range(len(points)):
        rest = [other for other in range(len(points)) if other != row]
        image = composite(stack[rest], color[rest], opacity[rest], background)
        rises.append(mean_squared_error(image, target) - error)
    return torch.stack(rises) if rises else error.new_zeros(0)


def mean_squared_error(image: Tensor, target: Tensor) -> Tensor:
    """Return the mean over the 3 h w values of the squared difference."""
    return (image - target).square().mean()
