"""Connected parts of a graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warpvec.arrays import Integers


def connected_parts(first: NDArray[np.integer], second: NDArray[np.integer], count: int) -> Integers:
    """Return which part [count] each of ``count`` nodes is in; edges join nodes ``first`` [E] to ``second`` [E].

    Parts are numbered from 0, in the order of their first nodes.
    """
    links = coo_array((np.ones(len(first), bool), (first, second)), (count, count))
    return connected_components(links, directed=False)[1].astype(np.int64)
