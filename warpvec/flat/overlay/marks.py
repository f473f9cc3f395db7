"""Rows of small marks of one ink: what words over several grounds can be."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers, Integers32, Mask
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.overlay import OVERLAY
from warpvec.flat.regions.box_gaps import are_close

EIGHT_NEIGHBORS = np.ones((3, 3), bool)
"""A pixel and those that touch it, at corners too."""


class Row(NamedTuple):
    """Marks in a row.

    Attributes:
        top: first row of the part of the picture around them.
        left: first column of it.
        core: pixels of this part that have ink for certain [h, w].
    """

    top: int
    left: int
    core: Mask

    @property
    def window(self) -> tuple[slice, slice]:
        """The part of the picture around them."""
        height, width = self.core.shape
        return slice(self.top, self.top + height), slice(self.left, self.left + width)


def median_ground(picture: Floats32) -> Floats32:
    """Return the median colour [h, w, C] around each pixel of ``picture`` [h, w, C], found at half its size."""
    half = picture[::2, ::2]
    found = [ndimage.median_filter(half[..., channel], OVERLAY.window // 2) for channel in range(picture.shape[-1])]
    whole = np.repeat(np.repeat(np.stack(found, -1), 2, 0), 2, 1)
    return whole[: picture.shape[0], : picture.shape[1]]


def rows_of(share: Floats32) -> Iterator[Row]:
    """Yield the rows of at least three letters, by the ``share`` [h, w] of their ink in each pixel."""
    parts, _ = ndimage.label(share >= OVERLAY.core_min, EIGHT_NEIGHBORS)
    found = ndimage.find_objects(parts)
    boxes = np.array([(y.start, x.start, y.stop - 1, x.stop - 1) for y, x in found], np.int64).reshape(-1, 4)
    sides = np.sort(boxes[:, 2:] - boxes[:, :2] + 1, 1)
    is_mark = (sides <= [OVERLAY.mark_height_max, OVERLAY.mark_width_max]).all(1)
    number = np.flatnonzero(is_mark) + 1
    if not OVERLAY.letters_min <= is_mark.sum() <= OVERLAY.marks_max:
        return
    groups = _groups(boxes[is_mark])
    for group in range(int(groups.max()) + 1):
        row = _row(parts, number[groups == group], boxes[is_mark][groups == group])
        if _is_word(np.where(row.core, share[row.window], 0.0)):
            yield row


def _groups(boxes: Integers) -> Integers:
    """Return the row [n] of each of the ``boxes`` [n, 4]."""
    places = boxes.astype(np.float32)
    first, second = np.nonzero(are_close(places[:, None], places))
    return connected_parts(first, second, len(boxes))


def _row(parts: Integers32, numbers: Integers, boxes: Integers) -> Row:
    """Return the row of the ``parts`` [h, w] with these ``numbers`` [n] and ``boxes`` [n, 4]."""
    top, left = np.maximum(boxes[:, :2].min(0) - OVERLAY.margin, 0).tolist()
    bottom, right = (boxes[:, 2:].max(0) + 1 + OVERLAY.margin).tolist()
    return Row(top, left, np.isin(parts[top:bottom, left:right], numbers))


def _is_word(share: Floats32) -> bool:
    """Return whether marks, by the ``share`` [h, w] of their ink, are letters in a row."""
    parts, _ = ndimage.label(share >= OVERLAY.letter_share_min, EIGHT_NEIGHBORS)
    boxes = np.array([(y.start, x.start, y.stop, x.stop) for y, x in ndimage.find_objects(parts)], float).reshape(-1, 4)
    sides = boxes[:, 2:] - boxes[:, :2]
    letters = boxes[sides.max(1) >= OVERLAY.letter_height_min]
    if len(letters) < OVERLAY.letters_min:
        return False
    height = float(np.median((letters[:, 2:] - letters[:, :2]).max(1)))
    return _off_line((letters[:, :2] + letters[:, 2:]) / 2.0) <= OVERLAY.row_error_max * height


def _off_line(points: Floats) -> float:
    """Return the root mean square distance of ``points`` [n, 2] from the line that fits them best."""
    offset = points - points.mean(0)
    return float(np.linalg.svd(offset, compute_uv=False)[-1] / np.sqrt(len(points)))
