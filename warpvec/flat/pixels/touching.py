"""Which pixels that touch by a corner alone are one stroke.

Source: Kopf and Lischinski, Depixelizing Pixel Art, 2011.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Integers, Mask

APART, FALLING, RISING = 0, 1, 2
"""Nothing is joined at a corner; the pixels on its upper left and lower right are; those on the other diagonal."""

_AROUND = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1) if down or right]

_ISLAND = 5
"""Votes for a pixel that would else be alone: as published."""

_WINDOW = 4
"""Half of the side of the square in which the sparser colour is the stroke: as published."""

_CURVE_MAX = 64
"""Most pixels of a curve that count: a longer one wins anyway."""


def joined_corners(label: Integers) -> Integers:
    """Return for each inner corner of the pixels of ``label`` [h, w] which diagonal is one stroke [h - 1, w - 1].

    Where both diagonals have one colour each, the longer curve, the sparser colour and the pixel that would else be
    alone win.
    """
    is_falling, is_rising = label[:-1, :-1] == label[1:, 1:], label[:-1, 1:] == label[1:, :-1]
    is_even = is_falling & is_rising & (label[:-1, :-1] == label[:-1, 1:])
    found = np.where(is_falling & ~is_even, FALLING, APART) + np.where(is_rising & ~is_even, RISING, APART)
    graph = _Graph(label, is_falling & ~is_even, is_rising & ~is_even)
    for row, column in np.argwhere(found == FALLING + RISING).tolist():
        falling = graph.votes((row, column), (row + 1, column + 1))
        rising = graph.votes((row, column + 1), (row + 1, column))
        found[row, column] = FALLING if falling > rising else RISING if rising > falling else APART
    return found


class _Graph:
    """Pixels of one colour that touch, by a side or by a corner at which the colours differ."""

    def __init__(self, label: Integers, is_falling: Mask, is_rising: Mask) -> None:
        self._label = label
        height, width = label.shape
        links = np.zeros((height, width, 3, 3), bool)  # by the step down and right, plus 1
        for (down, right), is_linked in {
            (0, 1): label[:, :-1] == label[:, 1:], (1, 0): label[:-1] == label[1:],
            (1, 1): is_falling, (1, -1): is_rising,
        }.items():  # fmt: skip
            start = (slice(0, height - down), slice(max(-right, 0), width - max(right, 0)))
            end = (slice(down, height), slice(max(right, 0), width - max(-right, 0)))
            links[(*start, down + 1, right + 1)] = links[(*end, 1 - down, 1 - right)] = is_linked
        self._links, self._degree = links, links.sum((2, 3))

    def votes(self, one: tuple[int, int], other: tuple[int, int]) -> int:
        """Return the votes for the diagonal from a pixel to another, each as row and column."""
        islands = sum(int(self._degree[pixel]) == 1 for pixel in (one, other))
        return self._curve(one, other) - self._crowd(one) + _ISLAND * islands

    def _curve(self, one: tuple[int, int], other: tuple[int, int]) -> int:
        """Return the number of pixels of the curve, without forks, that the diagonal is part of."""
        count = 0
        for before, pixel in ((one, other), (other, one)):
            start = pixel
            while self._degree[pixel] == 2 and count < _CURVE_MAX:
                count += 1
                row, column = pixel
                ahead = [
                    (row + down, column + right)
                    for down, right in _AROUND
                    if self._links[row, column, down + 1, right + 1] and (row + down, column + right) != before
                ]
                before, pixel = pixel, ahead[0]
                if pixel == start:
                    break
        return count

    def _crowd(self, pixel: tuple[int, int]) -> int:
        """Return how many pixels of the colour of ``pixel`` are joined to it in the square around it."""
        row, column = pixel
        part = self._label[max(row - _WINDOW, 0) : row + _WINDOW, max(column - _WINDOW, 0) : column + _WINDOW]
        areas, _ = ndimage.label(part == self._label[pixel], np.ones((3, 3)))
        return int((areas == areas[min(row, _WINDOW), min(column, _WINDOW)]).sum())
