"""Undo the rims that a kernel with negative weights has left at edges when a picture was reduced.

Of all pictures of a finer grid that become the given one, the one with the least total variation has clean edges; the
means over its pixels have no rims. The even colours beside an edge bound what lies there. Source of the method: Condat,
A primal-dual splitting method for convex optimization, 2013.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_matrix

from warpvec.arrays import Floats32, Mask
from warpvec.condition.constants import CONDITION
from warpvec.condition.edge_models import REDUCTIONS
from warpvec.condition.even_colors import EvenAreas, find_even_areas, limits, on_even_colors


class _Reduction:
    """The reduction of a fine picture [side h, C, side w] to ``shape`` [h, w] by a kernel, and its adjoint.

    Channels lie between rows and columns, as their sums are found fastest so.
    """

    def __init__(self, shape: tuple[int, int], kernel: str) -> None:
        self._matrices = [_reducing(side, kernel) for side in shape]
        self._adjoints = [matrix.T.tocsr() for matrix in self._matrices]

    def reduced(self, fine: Floats32) -> Floats32:
        return _on_both_axes(self._matrices, fine)

    def adjoint(self, small: Floats32) -> Floats32:
        return _on_both_axes(self._adjoints, small)


def _reducing(side: int, kernel: str) -> csr_matrix:
    """Return the weights [side, fine side] of a reduction by ``kernel``."""
    fine = (np.arange(side * CONDITION.fineness) + 0.5) / CONDITION.fineness
    weights = REDUCTIONS[kernel].weight(np.abs(np.arange(side)[:, None] + 0.5 - fine))
    return csr_matrix((weights / weights.sum(1, keepdims=True)).astype(np.float32))


def _on_both_axes(matrices: list[csr_matrix], image: Floats32) -> Floats32:
    for matrix in matrices:
        rows = matrix @ image.reshape(len(image), -1)
        image = rows.reshape(-1, *image.shape[1:]).swapaxes(0, 2)
    return image


def without_rims(pixels: Floats32, kernel: str, seconds: float = math.inf) -> Floats32:
    """Return ``pixels`` as means over finer pixels would be, or themselves if that takes too long.

    Args:
        pixels: a picture [h, w, 3 or 4] in [0, 1] that was reduced by ``kernel``. Transparent ones are reduced with
            premultiplied colours, and these are meant here.
        kernel: one of `warpvec.condition.reduction.RIMMED`.
        seconds: how much time is left for the whole drawing.
    """
    areas = find_even_areas(pixels)
    count = unrimmed_pixels(areas)
    if count > min(CONDITION.unrimmed_pixels_max, CONDITION.unrimmed_share * CONDITION.unrimmed_speed * seconds):
        return pixels
    low, high = limits(*on_even_colors(pixels, pixels, areas))
    result, margin = pixels.copy(), CONDITION.unrimmed_margin
    for rows, columns in _blocks(~areas.is_still):
        part = tuple(slice(max(each.start - margin, 0), each.stop + margin) for each in (rows, columns))
        means = _means(pixels[part], low[part], high[part], kernel)
        top, left = rows.start - part[0].start, columns.start - part[1].start
        height, width = rows.stop - rows.start, columns.stop - columns.start
        result[rows, columns] = means[top : top + height, left : left + width]
    return on_even_colors(result, pixels, areas)[0]


def unrimmed_pixels(areas: EvenAreas) -> int:
    """Return the number of pixels that are looked at to undo the rims of a picture with these even ``areas``."""
    margin = 2 * CONDITION.unrimmed_margin
    return sum(
        (rows.stop - rows.start + margin) * (columns.stop - columns.start + margin)
        for rows, columns in _blocks(~areas.is_still)
    )


def _blocks(is_open: Mask) -> Iterator[tuple[slice, slice]]:
    """Yield the parts of a picture, none of them large, that all pixels which are open [h, w] lie in."""
    side = CONDITION.unrimmed_block
    for top in range(0, is_open.shape[0], side):
        for left in range(0, is_open.shape[1], side):
            block = is_open[top : top + side, left : left + side]
            if block.any():
                rows, columns = np.flatnonzero(block.any(1)), np.flatnonzero(block.any(0))
                yield (
                    slice(top + int(rows[0]), top + int(rows[-1]) + 1),
                    slice(left + int(columns[0]), left + int(columns[-1]) + 1),
                )


def _means(pixels: Floats32, low: Floats32, high: Floats32, kernel: str) -> Floats32:
    """Return ``pixels`` [h, w, C] as means of a fine picture, whose values lie between ``low`` and ``high``."""
    (height, width), side = pixels.shape[:2], CONDITION.fineness
    given, least, most = (np.ascontiguousarray(each.swapaxes(1, 2)) for each in (pixels, low, high))
    fine = _finer(given, least, most, _Reduction((height, width), kernel))
    means = fine.reshape(height, side, -1, width, side).mean((1, 4))
    return np.asarray(np.rint(255.0 * means) / 255.0, np.float32).swapaxes(1, 2)


def _finer(pixels: Floats32, low: Floats32, high: Floats32, reduction: _Reduction) -> Floats32:
    """Return the fine picture [side h, C, side w] of least variation that becomes ``pixels`` [h, C, w].

    All arrays are changed in place, as new ones would take most of the time.
    """
    weight, side = CONDITION.fine_weight, CONDITION.fineness
    step = 1.0 / (0.8 * weight + 3.0 * 8.0**0.5)
    dual_step = 0.95 * (1.0 / step - 0.8 * weight) / 8.0
    fine, low, high = (each.repeat(side, 0).repeat(side, 2) for each in (pixels, low, high))
    down, across, new, buffer = (np.zeros_like(fine) for _ in range(4))
    for _ in range(CONDITION.fine_rounds):
        pull = reduction.adjoint(_unexplained(pixels, reduction.reduced(fine)))
        np.multiply(pull, weight * side**2, out=new)
        _add_adjoint_of_differences(down, across, new)
        new *= -step
        new += fine
        np.clip(new, low, high, out=new)
        np.multiply(new, 2.0, out=buffer)
        np.subtract(buffer, fine, out=fine)  # ahead of the new one
        _add_differences(fine, dual_step, down, across, buffer)
        _shorten(down, across, buffer)
        fine, new = new, fine
    return fine


def _unexplained(pixels: Floats32, reduced: Floats32) -> Floats32:
    """Return ``reduced`` less ``pixels``; a pixel at black or white may have been cut off there."""
    half_level = 0.5 / 255.0
    rest = reduced - pixels
    rest = np.where(pixels >= 1.0 - half_level, np.minimum(rest, 0.0), rest)
    return np.asarray(np.where(pixels <= half_level, np.maximum(rest, 0.0), rest), np.float32)


def _add_adjoint_of_differences(down: Floats32, across: Floats32, total: Floats32) -> None:
    total[:-1] -= down[:-1]
    total[1:] += down[:-1]
    total[..., :-1] -= across[..., :-1]
    total[..., 1:] += across[..., :-1]


def _add_differences(image: Floats32, weight: float, down: Floats32, across: Floats32, buffer: Floats32) -> None:
    """Add ``weight`` times the differences of ``image`` to ``down`` and ``across``."""
    for ahead, behind, part, total in (
        (image[1:], image[:-1], buffer[:-1], down[:-1]),
        (image[..., 1:], image[..., :-1], buffer[..., :-1], across[..., :-1]),
    ):
        np.subtract(ahead, behind, out=part)
        part *= weight
        total += part


def _shorten(down: Floats32, across: Floats32, buffer: Floats32) -> None:
    """Divide ``down`` and ``across`` [h, C, w] by the length of both together in each pixel, where that exceeds 1."""
    np.multiply(down, down, out=buffer)
    length = buffer.sum(1)
    np.multiply(across, across, out=buffer)
    length += buffer.sum(1)
    np.sqrt(length, out=length)
    np.maximum(length, 1.0, out=length)
    down /= length[:, None]
    across /= length[:, None]
