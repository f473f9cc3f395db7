"""Find parts of ink that may be dashes, and measure their places, directions, sizes and looks."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.geometry.strokes import BUTT

_FINE = 4
"""Parts of a pixel's side by which the ink of a dash in it is counted."""


class Mark(NamedTuple):
    """A part of ink that may be a dash.

    Attributes:
        label: its number.
        ink: the picture less its paper in the box around it [h, w, 3], in levels; 0 beside it.
        corner: x and y of the first pixel of the box [2].
        center: of its ink [2] px.
        along: its direction [2].
        length: in pixels, if its ends are straight.
        width: in pixels, by the spread of its ink across.
    """

    label: int
    ink: Floats
    corner: Floats
    center: Floats
    along: Floats
    length: float
    width: float

    def size(self, step: Floats, cap: int) -> tuple[float, float]:
        """Return the length of its centre line and its width in pixels, with the ink ``step`` [3] and a ``cap``."""
        area = float(self.ink.sum((0, 1)) @ step / (step @ step))
        if cap == BUTT:
            return self.length, area / self.length
        return _round_size(area, area * self.length**2 / 12.0)

    def off(self, look: Look) -> float:
        """Return how far its picture is from a dash of a ``look`` in its place, in squared levels."""
        height, width = self.ink.shape[:2]
        y, x = (np.indices((height * _FINE, width * _FINE)) + 0.5) / _FINE
        x, y = x + self.corner[0] - self.center[0], y + self.corner[1] - self.center[1]
        ahead = np.abs(self.along[0] * x + self.along[1] * y) - look.length / 2.0
        beside = np.abs(self.along[0] * y - self.along[1] * x)
        if look.cap == BUTT:
            inside = _soft(ahead) * _soft(beside - look.width / 2.0)
        else:
            inside = _soft(np.hypot(np.maximum(ahead, 0.0), beside) - look.width / 2.0)
        share = inside.reshape(height, _FINE, width, _FINE).mean((1, 3))
        return float(np.square(share[..., None] * look.color - self.ink).sum())

    @property
    def is_long(self) -> bool:
        """Whether it has a direction."""
        return self.length > 1.5 * self.width


class Look(NamedTuple):
    """How a dash is drawn: its colour [3] in levels, the width and length of its centre line in pixels, its ends."""

    color: Floats
    width: float
    length: float
    cap: int


def _soft(outside: Floats) -> Floats:
    """Return how much of each part of a pixel lies within an edge that is so many pixels away, negative inside."""
    return np.asarray((0.5 - _FINE * outside).clip(0.0, 1.0))


def _round_size(area: float, moment: float) -> tuple[float, float]:
    """Return the length of the centre line and the width of a dash with half disks as ends, in pixels.

    Args:
        area: in squared pixels.
        moment: the squared distances along it of its area from its middle, summed up.
    """

    def off(width: float) -> float:
        length, radius = area / width - math.pi * width / 4.0, width / 2.0
        ends = math.pi * radius**2 * length**2 / 4.0 + 4.0 / 3.0 * radius**3 * length + math.pi * radius**4 / 4.0
        return width * length**3 / 12.0 + ends - moment

    widest = math.sqrt(4.0 * area / math.pi)  # that of a disk, which is the shortest
    if off(widest) >= 0.0:
        return 0.0, widest
    from scipy.optimize import brentq  # pictures without dashes need not load it

    width = float(brentq(off, 1e-2 * widest, widest))
    return area / width - math.pi * width / 4.0, width


def find_marks(residual: Floats, labels: Integers) -> list[Mark]:
    """Return the parts of ``residual`` [h, w, 3] with ``labels`` [h, w] that are thin bars, or nearly so, or dots."""
    found = []
    for k, box in enumerate(ndimage.find_objects(labels), 1):
        if max(part.stop - part.start for part in box) > THIN_LINES.dash_max:
            continue
        ink = residual[box] * (labels[box] == k)[..., None]
        amount = np.linalg.norm(ink, axis=2)
        places = np.indices(amount.shape)[::-1].reshape(2, -1) + 0.5
        weight = amount.ravel() / amount.sum()
        center = places @ weight
        away = places - center[:, None]
        # A pixel spreads its ink by a twelfth.
        spread, axes = np.linalg.eigh((weight * away) @ away.T - np.eye(2) / 12.0)
        width, length = np.sqrt(12.0 * np.maximum(spread, 0.0)).tolist()
        is_filled = amount.sum() >= 0.8 * length * width * amount.max()
        if is_filled and width <= THIN_LINES.dash_width_max:
            corner = np.array([box[1].start, box[0].start], np.float64)
            found.append(Mark(k, ink, corner, corner + center, axes[:, 1], length, width))
    return found
