"""Find out whether the pixels of a picture are meant: pixel art and codes."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Integers, Mask
from warpvec.flat.constants.pixels import PIXELS
from warpvec.flat.pixels.cells import Cells, find_cells


def are_pixels_meant(image: Floats32, tolerance: int, is_enlarged: bool) -> bool:
    """Return whether each pixel of ``image`` [h, w, 3 or 4] is a square that somebody has placed.

    Then it has few colours, none of them only between its neighbours, and its outlines turn often.

    Args:
        image: the picture before its enlargement, in [0, 1].
        tolerance: largest difference of a channel, in levels, between colours that were one.
        is_enlarged: whether it was enlarged, with whole pixels.
    """
    longest = max(image.shape[:2])
    if longest > (PIXELS.chosen_side_max if is_enlarged else PIXELS.given_side_max):
        return False
    cells = _placed_cells(image, tolerance)
    if cells is None:
        return False
    sides, corners = sides_and_corners(cells)
    run_max = PIXELS.small_run_max if longest <= PIXELS.small_side else PIXELS.run_max
    is_code = len(cells.colors) > 2 or corners >= PIXELS.code_corners * cells.label.size
    return corners >= PIXELS.corners_min and sides / corners <= run_max and is_code


def are_rectangles(image: Floats32) -> bool:
    """Return whether ``image`` [h, w, 3 or 4] consists of rectangles of whole pixels, without anti-aliasing.

    A larger picture of such rectangles looks like an enlargement of it, but nothing of it was lost.
    """
    cells = _placed_cells(image, 0)
    if cells is None:
        return False
    sides, corners = sides_and_corners(cells)
    least = PIXELS.rectangle_run_min if corners < PIXELS.corners_min else PIXELS.run_max
    return corners > 0 and sides / corners >= least


def _placed_cells(image: Floats32, tolerance: int) -> Cells | None:
    """Return the cells of ``image`` [h, w, 3 or 4]; None if it has many colours, or anti-aliasing."""
    cells = find_cells(image, tolerance, PIXELS.colors_max)
    if not 2 <= len(cells.colors) <= min(PIXELS.chosen_colors_max, cells.label.size**0.5):
        return None
    given = find_cells(image, 0, cells.label.size) if tolerance else cells
    share = antialiased_share(given, PIXELS.between_levels + tolerance)
    return cells if share <= PIXELS.between_share_max else None


def antialiased_share(cells: Cells, least: int) -> float:
    """Return the share of pixels between two opposite neighbours by ``least`` levels, among those at edges."""
    colors = cells.colors.copy()
    colors[:, :3] = colors[:, :3] * colors[:, 3:] // 255
    is_between = np.zeros(cells.label.shape, bool)
    is_edge = np.zeros(cells.label.shape, bool)
    for label, between, edge in ((cells.label, is_between, is_edge), (cells.label.T, is_between.T, is_edge.T)):
        before, middle, after = label[:-2], label[1:-1], label[2:]
        between[1:-1] |= _lies_between(colors[before], colors[middle], colors[after], least)
        is_step = np.abs(colors[label[1:]] - colors[label[:-1]]).max(2) >= least
        edge[1:] |= is_step
        edge[:-1] |= is_step
    return float(is_between.sum() / max(int(is_edge.sum()), 1))


def _lies_between(before: Integers, middle: Integers, after: Integers, least: int) -> Mask:
    """Return where ``middle`` [h, w, 4] is a mix of ``before`` and ``after``, and clearly neither."""
    low, high = np.minimum(before, after), np.maximum(before, after)
    is_inside = ((middle >= low) & (middle <= high)).all(2)
    difference = [np.abs(middle - other).max(2) >= least for other in (before, after)]
    span = (after - before).astype(np.float64)
    share = ((middle - before) * span).sum(2) / np.maximum((span**2).sum(2), 1.0)
    is_mix = np.abs(before + share[..., None] * span - middle).max(2) < least
    return np.asarray(is_inside & difference[0] & difference[1] & is_mix)


def sides_and_corners(cells: Cells) -> tuple[int, int]:
    """Return the number of sides between pixels of two colours, and of corners at which these sides turn."""
    label = cells.label
    level, upright = label[1:] != label[:-1], label[:, 1:] != label[:, :-1]
    meets_level = np.pad(level, ((0, 0), (1, 1)))
    turns = (meets_level[:, 1:-1][:, 1:] | meets_level[:, 1:-1][:, :-1]) & (upright[1:] | upright[:-1])
    return int(level.sum() + upright.sum()), int(turns.sum())
