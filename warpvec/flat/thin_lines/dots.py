"""Find the round dots of a drawing: stipple, dotted lines, halftones, and the dots of letters.

A dot smaller than two pixels has no pixel of its own colour, so that regions and outlines miss it. But the sum of its
ink tells its area. The mean place of the ink is its centre. The spread of the ink tells whether the dot is round.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.price import PRECISION
from warpvec.geometry.forms.registry import CIRCLE, form_of
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene

_NARROW = 3.0 * math.sqrt(2.0)
"""Width in pixels of a disk that just covers three by three pixels; a wider one has a region, and an outline."""


class _Part(NamedTuple):
    """A part of ink that may be a disk.

    Attributes:
        label: its number.
        ink: the picture less its paper in the box around it [h, w, 3], in levels; 0 beside it.
        corner: x and y of the first pixel of the box [2].
        center: of the ink in the box [2] px.
    """

    label: int
    ink: Floats
    corner: Floats
    center: Floats

    def off(self, step: Floats) -> float:
        """Return how far the nearest disk of the ink ``step`` [3] is from the picture, as a share of the ink."""
        found = disk(self.ink.shape[:2], self.center, self.width(step))[..., None] * step
        return float(np.abs(found - self.ink).max() / np.abs(step).max())

    def is_whole(self, step: Floats) -> bool:
        """Return whether it has whole pixels of the ink ``step`` [3], and no others."""
        return bool(np.abs(self.ink - step).max(2)[self.ink.any(2)].max() < 1.0)

    def width(self, step: Floats) -> float:
        """Return the width in pixels of a disk of the ink ``step`` [3]."""
        return 2.0 * float(np.sqrt(self.ink.sum((0, 1)) @ step / (step @ step) / np.pi))


def without_dots(levels: Floats, papers: Floats, inks: Floats, count_max: int) -> tuple[Floats, Scene]:
    """Return a picture without its round dots, and these as circles.

    Wide ones are found by their outlines, unless they are more than the ``count_max`` paths that a drawing may have.

    Args:
        levels: the picture [h, w, 3].
        papers: the colours [m, 3] that dots may lie on.
        inks: the colours [n, 3] that the picture has.
        count_max: the most paths.
    """
    levels, found = levels.copy(), []
    for paper in papers:
        labels, _ = ndimage.label(np.abs(levels - paper).sum(2) >= THIN_LINES.contrast_min, np.ones((3, 3)))
        parts = _parts(levels - paper, labels)
        if len(parts) <= count_max:
            parts = [part for part in parts if max(part.ink.shape[:2]) <= math.ceil(_NARROW) + 1]
        inked = _inked(parts, inks - paper, paper)
        is_many = len(inked) > count_max
        kept = [(part, step) for part, step in inked if is_many or part.width(step) <= _NARROW]
        levels[np.isin(labels, [part.label for part, _ in kept])] = paper
        found += [(*part.corner + part.center, part.width(step), *paper + step) for part, step in kept]
    return levels, _circles(np.array(found).reshape(-1, 6))


def _circles(dots: Floats) -> Scene:
    """Return a scene of ``dots`` [n, 6], the centre, the width and the colour in levels, those of a colour in a row."""
    dots = dots[np.lexsort(dots.T)]
    count, color = len(dots), torch.from_numpy(dots[:, 3:] / 255.0).float()
    parameters = torch.zeros(count, 6, dtype=torch.float64)
    parameters[:, :2], parameters[:, 2] = torch.from_numpy(dots[:, :2]), torch.from_numpy(_shared(dots[:, 2]) / 2.0)
    rows = form_of(CIRCLE).segments(parameters).float().flatten(1, 2)
    canvas, layer = torch.zeros(3), torch.zeros(count, dtype=torch.int64)
    scene = Scene.uniform(rows, color, torch.ones(count), canvas, layer, transparent=True)
    return scene.with_forms(Forms(torch.full((count,), CIRCLE, dtype=torch.int32), parameters.float()))


def _parts(residual: Floats, labels: Integers) -> list[_Part]:
    """Return the parts of ``residual`` [h, w, 3] with ``labels`` [h, w] that are as wide as their spread says."""
    found = []
    for k, box in enumerate(ndimage.find_objects(labels), 1):
        ink = residual[box] * (labels[box] == k)[..., None]
        amount = np.linalg.norm(ink, axis=2)
        places = np.indices(amount.shape)[::-1] + 0.5
        center = (amount * places).sum((1, 2)) / amount.sum()
        # A pixel spreads its ink by a twelfth, and that of a disk is a sixteenth of its squared width.
        spread = (amount * (places - center[:, None, None]) ** 2).sum((1, 2)) / amount.sum() - 1.0 / 12.0
        width = 4.0 * np.sqrt(np.maximum(spread, 0.0))
        # Renderers place an edge to a quarter of a pixel.
        if width.mean() <= min(amount.shape) + 0.5 and width.min() >= max(amount.shape) - 2.5:
            found.append(_Part(k, ink, np.array([box[1].start, box[0].start]), center))
    return found


def _inked(parts: list[_Part], steps: Floats, paper: Floats) -> list[tuple[_Part, Floats]]:
    """Return the ``parts`` that are disks on ``paper`` [3], each with its ink.

    It is one of ``steps`` [n, 3], or else as strong as all parts together can have it. The inks that explain the parts
    best come first: a drawing has few.
    """
    if not parts:
        return []
    sums = np.array([part.ink.sum((0, 1)) for part in parts])
    total = sums.sum(0)
    room = np.maximum(np.where(total < 0.0, paper, 255.0 - paper), 1e-9)
    steps = np.array([*steps, total / max(float(np.abs(total / room).max()), 1e-9)])
    limit, left = 2.0 * THIN_LINES.explained, np.ones(len(parts), bool)
    off = np.full((len(parts), len(steps)), limit)
    sizes = np.linalg.norm(sums, axis=1)[:, None] * np.linalg.norm(steps, axis=1)
    for k, ink in np.argwhere(sums @ steps.T >= THIN_LINES.ink_cosine * np.maximum(sizes, 1e-9)).tolist():
        off[k, ink] = min(parts[k].off(steps[ink]), limit)
    found: list[tuple[_Part, Floats]] = []
    while (off[left] < limit).any():
        known = off[left, :-1]
        ink = int(known.sum(0).argmin()) if (known < limit).any() else -1
        is_best = left & (off[:, ink] < limit)
        some = [part for part, is_its in zip(parts, is_best, strict=True) if is_its]
        # Whole pixels are meant as such, unless most dots are none.
        if 2 * sum(part.is_whole(steps[ink]) for part in some) < len(some):
            found += [(part, steps[ink]) for part in some]
        left &= ~is_best
    return found


def disk(shape: tuple[int, ...], center: Floats, width: float) -> Floats:
    """Return the share of each pixel [h, w] of a picture of this ``shape`` that a disk covers, of wide ones about."""
    steps = 8 if width <= _NARROW else 1
    y, x = np.indices((shape[0] * steps, shape[1] * steps))
    away = np.hypot((x + 0.5) / steps - center[0], (y + 0.5) / steps - center[1])
    fine = (steps * (width / 2.0 - away) + 0.5).clip(0.0, 1.0)
    found: Floats = fine.reshape(shape[0], steps, shape[1], steps).mean((1, 3))
    return found


def _shared(width: Floats) -> Floats:
    """Return the ``width`` [n] of dots with one value for those that nobody can tell apart."""
    order, found, first = np.argsort(width, kind="stable"), width.copy(), 0
    for k in range(1, len(order) + 1):
        if k == len(order) or width[order[k]] > width[order[first]] + PRECISION:
            found[order[first:k]] = width[order[first:k]].mean()
            first = k
    return found
