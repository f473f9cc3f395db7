"""The Gauss-Newton matrix of a drawing: how the pixels change with each pair of its values.

With J the derivative of all pixels by all values, it is J^T J in the scale of the loss. Few values meet in one pixel,
so J is sparse. Its columns of points and forms follow from samples of the outlines, those of paints from the visible
share of each path. Opacities are left to `Variables.strength`.

J is never made. Curves change a pixel by its winding, in all channels together, so products over pixels are first
taken by curves, four points and a width each, of which there are few; then the values that move these follow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
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
    by_values = _row_derivative(variables, scene, x, held, paints.value_count)
    first, count = 6 * len(path), by_values.shape[1]
    by_paints = _among(paints.at_pixels(), first, count)
    half = by_values.T.tocsr() @ (outlines.half_squares() @ by_values + outlines.products(by_paints))
    own = by_paints.T.tocsr() @ by_paints + paints.elsewhere(first, count)
    return (2.0 * target.error_scale * (half + half.T.tocsr() + own)).tocsc()


def _among(slopes: sparse.csr_matrix, first: int, count: int) -> sparse.csr_matrix:
    """Return ``slopes`` [P, V] as columns of ``count`` values, from the column ``first`` on."""
    return sparse.csr_matrix((slopes.data, slopes.indices + first, slopes.indptr), shape=(slopes.shape[0], count))


def _row_derivative(variables: Variables, scene: Scene, x: Tensor, held: Tensor, paint_count: int) -> sparse.csr_matrix:
    """Return the derivative of the values of all rows by those of the drawing [9 R, K]; see `CURVE_VALUES`."""
    by_points = variables.point_derivative(x, held)
    first_width = by_points.shape[1] + paint_count
    first_form = first_width
    if scene.strokes is not None:
        first_form += len(scene)
    if scene.softness is not None:  # left out of the matrix, as are the outlines of soft paths
        first_form += len(scene)
    by_forms = variables.form_derivative(x)
    count = first_form if by_forms is None else first_form + by_forms.shape[1]
    widths = None if scene.strokes is None else first_width + scene.structure.segment_path.cpu().numpy()
    total = _of_rows(by_points, 0, count, widths)
    return total if by_forms is None else total + _of_rows(by_forms, first_form, count)


def _of_rows(
    by_curves: sparse.csr_matrix, first: int, count: int, widths: NDArray[np.int32] | None = None
) -> sparse.csr_matrix:
    """Return the derivative of the values of all rows [9 R, K] by ``count`` values.

    Args:
        by_curves: of the coordinates of their curves, eight for each row [8 R, V], by the values from ``first`` on.
        widths: the value that is the width of each row [R]; None for none.
    """
    values, columns, ends = by_curves.data, by_curves.indices + first, by_curves.indptr[8::8]
    if widths is not None:
        values, columns = np.insert(values, ends, 1.0), np.insert(columns, ends, widths)
    sizes = np.diff(by_curves.indptr).reshape(-1, CURVE_VALUES - 1)
    sizes = np.column_stack([sizes, np.full(len(sizes), 0 if widths is None else 1)])
    bounds = np.append(0, np.cumsum(sizes))
    return sparse.csr_matrix((values, columns, bounds), shape=(sizes.size, count))
