"""Whether a picture of two colours, without any between, is said more briefly by its pixels or by smooth outlines."""

from __future__ import annotations

import math

import numpy as np

from warpvec.arrays import Floats32, Mask
from warpvec.flat.mono import mono_tracing
from warpvec.flat.pixels.cells import find_cells
from warpvec.flat.pixels.choice import sides_and_corners
from warpvec.flat.price import words_of
from warpvec.image.luma import LUMA
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg
from warpvec.watch.decisions import Decision, are_wanted, note


def are_pixels_shorter(image: Floats32) -> bool:
    """Return whether outlines along pixels say an ``image`` [h, w, 3] of two colours in fewer nats than smooth ones.

    A corner of an outline along pixels is one number, its next row or column. Smooth outlines leave pixels on the wrong
    side; each of these is named by its place.
    """
    cells = find_cells(image)
    if len(cells.colors) != 2:
        return False
    darker = int(np.argmin(cells.colors[:, :3] @ np.array(LUMA)))
    is_ink = cells.label == darker
    exact = sides_and_corners(cells)[1] * math.log(max(is_ink.shape))
    smooth = _smooth_nats(is_ink)
    if are_wanted():
        note(Decision("two colours", None, "smooth outlines", "whole pixels", smooth - exact, 0.0, exact <= smooth))
    return exact <= smooth


def _smooth_nats(is_ink: Mask) -> float:
    """Return the nats of smooth outlines of the ink [h, w], with those of the pixels that they miss."""
    height, width = is_ink.shape
    gray = np.where(is_ink, 0.0, 1.0).astype(np.float32)[..., None].repeat(3, 2)
    scene = mono_tracing(gray).scene
    shown = draw(write_svg(scene, width, height), width, height)[..., 0] < 128
    return words_of(scene).nats(max(is_ink.shape)) + int((shown != is_ink).sum()) * math.log(is_ink.size)
