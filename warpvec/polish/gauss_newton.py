"""The Gauss-Newton matrix of a drawing: how the pixels change with each pair of its values.

With J the derivative of all pixels by all values, it is J^T J in the scale of the loss. Few values meet in one pixel,
so J is sparse. Its columns of points and forms follow from samples of the outlines, those of paints from the visible
share of each path. Opacities are left to `Variables.strength`.

J is never made. Curves change a pixel by its winding, in all channels together, so products over pixels are first
taken by curves, four points and a width each, of which there are few; then the values that move these follow.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import TILE
from warpvec.polish.outline_samples import crossed_pixels
from warpvec.polish.outline_slopes import CURVE_VALUES, OutlineSlopes
from warpvec.polish.paint_slopes import PaintSlopes
from warpvec.polish.variables import Variables


def gauss_newton(variables: Variables, x: Tensor, held: Tensor) -> sparse.csc_matrix:
    """Return the matrix [K, K] in float64 at the values ``x`` [K]; rows and columns of opacities are empty.

    Those of locked paths are of no use: their outlines, and what their gradients do away from outlines, are left out.
    Handles that are ``held`` [R, 2] do not get longer or shorter; see `Variables.held`.
    """
    scene, target = variables.scene(x), variables.target
    height, width = target.size
    path = scene.structure.segment_path.cpu().numpy().astype(np.int64)
    is_free = None if variables.locked is None else ~variables.locked.cpu().numpy()
    crossed = crossed_pixels(scene, height, width, is_free)
    outlines = OutlineSlopes(crossed, path, -(-width // TILE), target.matte_scale)
    paints = PaintSlopes(scene, width, height, outlines.pixels, is_free)
    for part in target.pixel_slopes(scene):
        outlines.add(part)
        paints.add(part)
    at_pixels = [paints.at_pixels(channel) for channel in range(3)]
    stacked = sparse.vstack(at_pixels, "csr")
    by_values = _row_derivative(variables, scene, x, held, paints.value_count)
    first = 6 * len(path)
    offset = sparse.csr_matrix(
        (np.ones(paints.value_count), first + np.arange(paints.value_count), np.arange(paints.value_count + 1)),
        shape=(paints.value_count, by_values.shape[1]),
    )
    mixed = by_values.T @ (outlines.products(at_pixels) @ offset)
    own = offset.T @ ((stacked.T @ stacked + paints.elsewhere()) @ offset)
    total = by_values.T @ (outlines.squares() @ by_values) + mixed + mixed.T + own
    return (2.0 * target.error_scale * total).tocsc()


def _row_derivative(variables: Variables, scene: Scene, x: Tensor, held: Tensor, paint_count: int) -> sparse.csr_matrix:
    """Return the derivative of the values of all rows by those of the drawing [9 R, K]; see `CURVE_VALUES`."""
    path = scene.structure.segment_path.cpu().numpy()
    found = variables.point_derivative(x, held).tocoo()
    parts = [(_row_places(found.row), found.col, found.data)]
    count = found.shape[1] + paint_count
    if scene.strokes is not None:
        rows = np.arange(len(path))
        parts.append((CURVE_VALUES * rows + CURVE_VALUES - 1, count + path, np.ones(len(path))))
        count += len(scene)
    if scene.softness is not None:  # left out of the matrix, as are the outlines of soft paths
        count += len(scene)
    by_forms = variables.form_derivative(x)
    if by_forms is not None:
        found = by_forms.tocoo()
        parts.append((_row_places(found.row), count + found.col, found.data))
        count += found.shape[1]
    row, column, value = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return sparse.csr_matrix((value, (row, column)), shape=(CURVE_VALUES * len(path), count))


def _row_places(coordinates: np.ndarray) -> np.ndarray:
    """Return the places among the values of all rows of the ``coordinates`` of their curves, eight for each row."""
    return coordinates // 8 * CURVE_VALUES + coordinates % 8
