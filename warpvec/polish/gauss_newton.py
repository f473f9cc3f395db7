"""The Gauss-Newton matrix of a drawing: how the pixels change with each pair of its values.

With J the derivative of all pixels by all values, it is J^T J in the scale of the loss. Few values meet in one pixel,
so J is sparse. Its columns of points and forms follow from samples of the outlines, those of paints from the visible
share of each path. Opacities are left to `Variables.strength`.

J is never made. Curves change a pixel by its winding, in all channels together, so products over pixels are first
taken by curves, four points and a width each, of which there are few (`NormalMatrix`); then the values that move these
follow.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from torch import Tensor

from warpvec.polish.damped_steps import sum_of
from warpvec.polish.normal_matrix import NormalMatrix
from warpvec.polish.paint_slopes import PaintSlopes, paint_value_count
from warpvec.polish.tension import tension_matrix
from warpvec.polish.variables import Variables


def gauss_newton(variables: Variables, x: Tensor, held: Tensor) -> sparse.csc_matrix:
    """Return the matrix [K, K] in float64 at the values ``x`` [K]; see `normal_entries`."""
    return sum_of(normal_entries(variables, x, held))


def normal_entries(variables: Variables, x: Tensor, held: Tensor) -> list[sparse.coo_matrix]:
    """Return matrices [K, K] whose sum is the Gauss-Newton matrix, in float64, at the values ``x`` [K].

    Rows and columns of opacities are empty. The next call overwrites their memory.

    Those of locked paths are of no use: their outlines, and what their gradients do away from outlines, are left out.
    Handles that are ``held`` [R, 2] do not get longer or shorter; see `Variables.held`.
    """
    scene, target = variables.shown(x), variables.target
    height, width = target.size
    is_free = None if variables.locked is None else ~variables.locked.cpu().numpy()
    here, value_count, is_flat = scene.to("cpu"), paint_value_count(scene), scene.gradients is None
    found = NormalMatrix(here, target.size, is_free, target.matte_scale, value_count, is_flat)
    paints = None if is_flat else PaintSlopes(scene, width, height, found.pixels.astype(np.int64), is_free)
    for part in target.pixel_slopes(scene):
        found.add(part)
        if paints is not None:
            paints.add(part)
    first = 2 * variables.point_count
    rows, factor = variables.row_slopes(x, held), 2.0 * target.error_scale
    by_paints = None if paints is None else paints.at_pixels()
    entries = [found.entries_of(rows, len(x), factor, by_paints)]
    if variables.tension is not None:
        entries.append(tension_matrix(here, variables.tension.to(here.segments.device), rows, len(x)))
    if paints is None or by_paints is None:
        return entries
    by_values = _among(by_paints, first, len(x))
    own = by_values.T.tocsr() @ by_values + paints.elsewhere(first, len(x))
    return [*entries, (factor * own).tocoo()]


def _among(slopes: sparse.csr_matrix, first: int, count: int) -> sparse.csr_matrix:
    """Return ``slopes`` [P, V] as columns of ``count`` values, from the column ``first`` on."""
    return sparse.csr_matrix((slopes.data, slopes.indices + first, slopes.indptr), shape=(slopes.shape[0], count))
