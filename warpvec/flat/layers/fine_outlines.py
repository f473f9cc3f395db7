"""Outlines of thin parts on a grid finer than pixels: a stroke narrower than a pixel may cover no pixel by half.

Each pixel has as much ink as its coverage says. Which of its sub-pixels have it, their surroundings tell: ink goes on
beside ink, rather along a line, as strokes do, and in the end along rows and columns, as sides of stems do. Source of
the idea: sub-pixel mapping in remote sensing, Atkinson, 1997.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from PIL import Image
from scipy import ndimage

from warpvec.arrays import Floats, Floats32
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.curves.contours import interpolated_contours

_MARGIN = 2
"""Pixels around the coverage, so that the ink falls to nothing there."""

_STEPS = range(-(LETTERING.line // 2), LETTERING.line // 2 + 1)
_ANGLES = [math.pi * k / LETTERING.directions for k in range(LETTERING.directions)]
_LINES = [[(round(step * math.sin(angle)), round(step * math.cos(angle))) for step in _STEPS] for angle in _ANGLES]
"""Offsets of the sub-pixels of a line through one, down and right, for each direction."""


def fine_contours_of(coverage: Floats, along_share: float = LETTERING.along_share) -> list[Floats]:
    """Return the closed contours [n, 2] of ``coverage`` [h, w] as `warpvec.flat.curves.contours.contours_of` does.

    With an ``along_share`` of 0, ink does not prefer rows and columns: of all shapes with this coverage, the outline is
    about the shortest, so that ends and corners are as round as pixels allow.
    """
    fine = fine_coverage(np.pad(coverage, _MARGIN, mode="edge"), along_share)  # a shape goes on beyond the end
    edge = _MARGIN * LETTERING.fineness
    for side in (fine[:edge], fine[-edge:], fine[:, :edge], fine[:, -edge:]):
        side[...] = 0.0
    return interpolated_contours(fine, _MARGIN, LETTERING.fineness)


def fine_coverage(coverage: Floats, along_share: float = LETTERING.along_share) -> Floats:
    """Return the coverage [f h, f w] of sub-pixels, whose mean in each pixel is its ``coverage`` [h, w].

    Almost all sub-pixels are full or empty. Ink goes along rows and columns by ``along_share``.
    """
    whole = coverage.astype(np.float32)  # doubles would take twice the time
    fine = np.clip(_enlarged(whole), 0.0, 1.0)
    pixels = fine.reshape(len(coverage), LETTERING.fineness, -1, LETTERING.fineness).transpose(0, 2, 1, 3)
    is_mixed = (whole > 0.0) & (whole < 1.0)
    pixels[~is_mixed] = whole[~is_mixed, None, None]  # a view of ``fine``
    share = whole[is_mixed][:, None]
    for around_of in _rounds(along_share):
        around = around_of(fine).reshape(pixels.transpose(0, 2, 1, 3).shape).transpose(0, 2, 1, 3)[is_mixed]
        pixels[is_mixed] = _filled(around.reshape(len(share), LETTERING.fineness**2), share).reshape(around.shape)
    return fine.astype(np.float64)


def _enlarged(values: Floats32) -> Floats32:
    """Return ``values`` [h, w] interpolated at the sub-pixels of their pixels [f h, f w]."""
    height, width = values.shape
    size = LETTERING.fineness * width, LETTERING.fineness * height
    return np.asarray(Image.fromarray(values).resize(size, Image.Resampling.BICUBIC))


def _rounds(along_share: float) -> Iterator[Callable[[Floats32], Floats32]]:
    """Yield how each round measures the ink around sub-pixels: along lines, and at last along rows and columns."""
    last = partial(_surroundings, along_share=along_share)
    for _ in range(LETTERING.rounds):
        yield _strokes if along_share > 0.0 else last
    yield last


def _strokes(fine: Floats32) -> Floats32:
    """Return how much ink is around each sub-pixel of ``fine`` [f h, f w], and on the line of most ink through it."""
    reach = LETTERING.line // 2
    wide, (height, width) = np.pad(fine, reach), fine.shape
    most = np.zeros_like(fine)
    for line in _LINES:
        parts = (wide[reach + y : reach + y + height, reach + x : reach + x + width] for y, x in line)
        np.maximum(most, sum(parts, np.zeros_like(fine)), out=most)
    near = ndimage.gaussian_filter(fine, LETTERING.line_near)
    share = LETTERING.line_share
    return np.asarray((1.0 - share) * near + share / LETTERING.line * most, np.float32)


def _surroundings(fine: Floats32, along_share: float) -> Floats32:
    """Return how much ink is around each sub-pixel of ``fine`` [f h, f w], and along its row and column."""
    near = ndimage.gaussian_filter(fine, LETTERING.near)
    along = (ndimage.uniform_filter1d(fine, LETTERING.along, axis) for axis in (0, 1))
    return np.asarray((1.0 - along_share) * near + along_share / 2.0 * sum(along), np.float32)


def _filled(around: Floats32, share: Floats32) -> Floats32:
    """Return the ink [n, f f] of the sub-pixels of n pixels, most where most is ``around`` [n, f f].

    Its mean in each pixel is ``share`` [n, 1]. The level that parts ink from none is found by halving.
    """
    reach = 1.0 / LETTERING.steepness
    low, high = (extreme(axis=1, keepdims=True) for extreme in (around.min, around.max))
    low, high = low - reach, high + reach
    for _ in range(LETTERING.halvings):
        level = (low + high) / 2.0
        is_over = _ink(around, level).mean(1, keepdims=True) > share
        low, high = np.where(is_over, level, low), np.where(is_over, high, level)
    return _ink(around, (low + high) / 2.0)


def _ink(around: Floats32, level: Floats32) -> Floats32:
    return np.clip(0.5 + LETTERING.steepness * (around - level), 0.0, 1.0)
