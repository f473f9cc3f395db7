"""Parts of a layer that are made of squares of pixels, such as the modules of a QR code in a poster.

They show in whole pixels, and each of their sides is longer than a pixel. Slopes and curves have steps of one pixel, or
anti-aliasing. So the outlines are known exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.layers.covering import Cover
from warpvec.flat.pixels.outlines import rectilinear_loops


class _Part(NamedTuple):
    """A connected part of a layer, in a box with a pixel around it where there is one.

    Attributes:
        box: rows and columns in the layer.
        covered: its pixels, and its holes in which layers above alone are seen [h, w].
        loops: corners [n, 2] of its outlines, in the layer.
        is_free: whether no layer above is seen beside it.
    """

    box: tuple[slice, slice]
    covered: Mask
    loops: list[Integers]
    is_free: bool


def without_modules(cover: Cover) -> tuple[list[Floats], Cover]:
    """Return the corners [n, 2] of the outlines of the parts of squares in ``cover``, and what is left of it.

    They go on beneath what they enclose, and end at other shapes. A part that ends at a shape above
    it is a code only if it has many corners. With few, it may be a rectangle, and the shape hides some of it.
    """
    parts = [part for part in _whole_parts(cover) if part.loops]
    has_many = sum(len(loop) for part in parts for loop in part.loops) >= LAYERS.module_corners_min
    parts = [part for part in parts if has_many or part.is_free]
    if not parts:
        return [], cover
    taken = np.zeros(cover.shown.shape, bool)
    for part in parts:
        taken[part.box] |= part.covered
    rest = {name: np.where(taken, 0.0, getattr(cover, name)) for name in ("coverage", "shown")}
    loops = [loop.astype(np.float64) for part in parts for loop in part.loops]
    return loops, replace(cover, **rest, above=cover.above & ~taken)


def _whole_parts(cover: Cover) -> Iterator[_Part]:
    """Yield the connected parts of ``cover`` that show in whole pixels."""
    label, count = ndimage.label(cover.shown > 0.0, np.ones((3, 3)))
    least = ndimage.minimum(cover.shown, label, np.arange(1, count + 1)) if count else []
    for index, (box, value) in enumerate(zip(ndimage.find_objects(label), least, strict=True), 1):
        if value == 1.0:
            wide = tuple(slice(max(0, side.start - 1), side.stop + 1) for side in box)
            yield _part_of(label[wide] == index, cover.above[wide], (wide[0], wide[1]))


def _part_of(shown: Mask, above: Mask, box: tuple[slice, slice]) -> _Part:
    covered = _with_hidden_holes(shown, above)
    loops = rectilinear_loops(covered)
    sides = [int(np.abs(np.roll(loop, -1, 0) - loop).max(1).min()) for loop in loops]
    is_made_of_squares = min(sides) >= LAYERS.module_side_min
    beside = ndimage.binary_dilation(covered, np.ones((3, 3))) & above & ~covered
    corner = np.array([box[1].start, box[0].start])
    return _Part(box, covered, [loop + corner for loop in loops] if is_made_of_squares else [], not beside.any())


def _with_hidden_holes(part: Mask, above: Mask) -> Mask:
    """Return ``part`` [h, w] with those of its holes in which layers ``above`` alone are seen."""
    label, count = ndimage.label(np.pad(~part, 1, constant_values=True))
    inside = label[1:-1, 1:-1]
    is_hidden = ndimage.minimum(above, inside, np.arange(count + 1)) > 0
    is_hidden[[0, label[0, 0]]] = True, False  # the part itself, and what is around it
    return np.asarray(is_hidden[inside])
