"""How many lines are too thin to cover any pixel by half, so that no outline of ink shows them."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.mono import MONO


def faint_line_count(coverage: Floats) -> int:
    """Return the number of connected marks in ``coverage`` [h, w] that have ink, but no pixel with half of it."""
    is_near_ink = ndimage.maximum_filter(coverage > CURVES.contour_level, MONO.faint_window)
    labels, count = ndimage.label((coverage > MONO.faint_level) & ~is_near_ink, np.ones((3, 3)))
    return int((np.bincount(labels.ravel(), minlength=count + 1)[1:] >= MONO.faint_pixels).sum())
