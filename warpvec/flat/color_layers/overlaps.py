"""Find the paths of a drawing that overlap. Their order shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from warpvec.flat.constants.drawing import DRAWING
from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import TILE
from warpvec.rendering.exact import ExactRenderer


def overlapping_paths(scene: Scene, height: int, width: int) -> NDArray[np.bool_]:
    """Return which paths of ``scene`` overlap on a canvas of ``height`` x ``width`` pixels, as an array [N, N].

    Paths overlap if both cover a part of one square of some pixels. No pair that overlaps is left out, but paths that
    pass each other closely count too.
    """
    side = max(DRAWING.overlap_side, -(-max(height, width) // DRAWING.overlap_squares))
    rows, columns = (-(-length // side) for length in (height, width))
    renderer = ExactRenderer(rows * TILE, columns * TILE)
    path, square = renderer.covered_tiles(scene.scaled(TILE / side, TILE / side))
    ones = np.ones(len(path), np.int32)
    covered = sparse.csr_array((ones, (path.numpy(), square.numpy())), shape=(len(scene), rows * columns))
    both: NDArray[np.bool_] = (covered @ covered.T).toarray() > 0
    np.fill_diagonal(both, False)
    return both
