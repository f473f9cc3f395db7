"""Runs along closed outlines."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Mask


def closed_runs(mask: Mask) -> list[tuple[int, int]]:
    """Return the first and one past the last of each run of a closed ``mask`` [n], in order.

    The last run may go on past the end. There is no run if the mask holds everywhere.
    """
    if mask.all():
        return []
    begin = int(np.argmin(mask))
    change = np.diff(np.concatenate([[0], np.roll(mask, -begin).astype(np.int8), [0]]))
    firsts, lasts = ((np.flatnonzero(change == sign) + begin).tolist() for sign in (1, -1))
    return list(zip(firsts, lasts, strict=True))
