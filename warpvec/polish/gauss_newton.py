"""The Gauss-Newton matrix of a drawing: how the pixels change with each pair of its values.

With J the derivative of all pixels by all values, it is J^T J in the scale of the loss. Few values meet in one pixel,
so J is sparse. Its columns of points and forms follow from samples of the outlines, those of paints from the visible
share of each path. Opacities are left to `Variables.strength`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import sparse
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.polish.outline_samples import CrossedPixels, crossed_pixels
from warpvec.polish.paint_slopes import PaintSlopes
from warpvec.polish.variables import Variables


def gauss_newton(variables: Variables, x: Tensor, held: Tensor) -> sparse.csc_matrix:
    """Return the matrix [K, K] in float64 at the values ``x`` [K]; rows and columns of opacities are empty.

    Handles that are ``held`` [R, 2] do not get longer or shorter; see `Variables.held`.
    """
    scene = variables.scene(x)
    height, width = variables.target.size
    crossed = crossed_pixels(scene, height, width)
    pixels, place = np.unique(crossed.y * width + crossed.x, return_inverse=True)
    paints = PaintSlopes(scene, width, pixels)
    for shares in variables.target.shares(scene):
        paints.add(shares.float().cpu().numpy().reshape(3, -1))
    by_points, by_forms = variables.point_derivative(x, held), variables.form_derivative(x)
    forms = [] if by_forms is None else [by_forms]
    width_count = 0 if scene.strokes is None else len(scene)
    sizes = [by_points.shape[1], width_count, *(each.shape[1] for each in forms)]
    empty = [sparse.csr_matrix((size, size)) for size in sizes]
    total = sparse.block_diag([empty[0], paints.elsewhere(), *empty[1:]], "csr")
    for channel, (slopes, by_widths) in enumerate(_slopes(variables, scene, crossed, place, len(pixels))):
        by_paints = paints.at_pixels(channel) if channel < 3 else paints.nothing()
        blocks = [slopes @ by_points, by_paints, by_widths[:, :width_count], *(slopes @ each for each in forms)]
        both = sparse.hstack(blocks, "csr")
        total = total + both.T @ both
    return (2.0 * variables.target.error_scale * total).tocsc()


def _slopes(
    variables: Variables, scene: Scene, crossed: CrossedPixels, place: NDArray[np.int64], pixel_count: int
) -> Iterator[tuple[sparse.csr_matrix, sparse.csr_matrix]]:
    """Yield for each channel how the crossed pixels change with the points of the curves [P, 8 R] and widths [P, N]."""
    device = scene.segments.device
    rows, x, y = (torch.from_numpy(part).to(device) for part in crossed[:3])
    path = scene.structure.segment_path.long()[rows]
    columns = (8 * crossed.row[:, None] + np.arange(8)).ravel()
    where, shape = (np.repeat(place, 8), columns), (pixel_count, 8 * len(scene.segments))
    width_where, width_shape = (place, path.cpu().numpy()), (pixel_count, len(scene))
    for slopes in variables.target.winding_slopes(scene, path, x, y).double().cpu().numpy().T:
        found = slopes[:, None] * crossed.slopes
        by_points = sparse.csr_matrix((found[:, :8].ravel(), where), shape=shape)
        yield by_points, sparse.csr_matrix((found[:, 8], width_where), shape=width_shape)
