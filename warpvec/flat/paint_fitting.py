"""The paints that the pure pixels of areas show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.assignment import Assignment
from warpvec.flat.denoising import Tolerances
from warpvec.flat.paints import Paints
from warpvec.flat.ramp_directions import Direction
from warpvec.flat.ramp_fitting import Ramp, fit_ramp
from warpvec.flat.region_growing import NONE

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

SAMPLES_MAX = 4096
"""Pixels of an area that its paint is fitted to, evenly taken from all of them."""

RAMP_AREA_MIN, NOISY_RAMP_AREA_MIN = 64, 400
"""Smaller areas are flat in clean and in noisy pictures: they show too little of a ramp, and ringing looks like one."""

RAMP_CONTRAST = 4 / 255
"""Difference of the stops of a ramp, beside the noise; less is not seen."""

FLAT_DEVIATION = 0.8 / 255
"""Root mean square that rounding and a few mixed pixels leave in a flat area of a clean picture."""

NOISE_DEVIATION = 0.35
"""Part of the noise of a picture that is the root mean square deviation in flat areas."""


@dataclass(frozen=True, eq=False)
class Seam:
    """A curve where two paints of one ramp meet.

    Attributes:
        before: region on the side of smaller places.
        after: region on the other side.
        direction: places along the ramp.
        place: where they meet, in pixels.
    """

    before: int
    after: int
    direction: Direction
    place: float


def fit_paints(image: Floats, labels: Integers, tolerances: Tolerances) -> tuple[Paints, Integers, list[Seam]]:
    """Fit the paints of the areas ``labels`` [h, w] of ``image`` [h, w, 4], sRGB with straight alpha.

    Returns the paints, the labels with areas split whose ramp has more than two stops, and the seams of those.
    """
    order = np.argsort(labels.ravel(), kind="stable")
    count = np.bincount(labels[labels != NONE], minlength=labels.max() + 1)
    start = (labels == NONE).sum() + np.cumsum(count) - count
    colors, labels = image.reshape(-1, 4), labels.copy()
    values = np.zeros((len(count), 4), np.float32)
    paints, ramps = [], []
    limit = FLAT_DEVIATION + NOISE_DEVIATION * tolerances.noise
    area_min = NOISY_RAMP_AREA_MIN if tolerances.noise > 0 else RAMP_AREA_MIN
    for index, (size, first) in enumerate(zip(count.tolist(), start.tolist(), strict=True)):
        pixels = order[first : first + size]
        sample = colors[pixels[:: -(-size // SAMPLES_MAX)]]
        values[index] = np.median(sample, 0)
        deviation = np.sqrt(((sample - values[index])[:, :3] ** 2).mean())
        if size >= area_min and values[index, 3] > 0 and deviation > limit:
            ramp = _ramp_of(pixels, colors, labels.shape[1], limit)
            if ramp is not None and ramp.contrast() >= RAMP_CONTRAST + tolerances.noise:
                ramps.append((index, pixels, ramp))
    paints = flat_paints(values)
    return _with_ramps(paints, labels, ramps)


def _ramp_of(pixels: NDArray[np.intp], colors: Floats, width: int, tolerance: float) -> Ramp | None:
    points = np.stack([pixels % width, pixels // width], 1) + 0.5
    sample = slice(None, None, -(-len(pixels) // SAMPLES_MAX))
    return fit_ramp(points, colors[pixels, :3].astype(np.float64), tolerance, sample)


def _with_ramps(
    paints: Paints, labels: Integers, ramps: list[tuple[int, NDArray[np.intp], Ramp]]
) -> tuple[Paints, Integers, list[Seam]]:
    """Replace flat paints by ramps, and split the areas of ramps of several pieces."""
    seams: list[Seam] = []
    width, flat_labels = labels.shape[1], labels.reshape(-1)
    for index, pixels, ramp in ramps:
        pieces = ramp.paints(float(paints.opacity[index]))
        points = np.stack([pixels % width, pixels // width], 1) + 0.5
        piece = np.searchsorted(ramp.cuts(), ramp.direction.places(points))
        names = np.array([index, *range(len(paints), len(paints) + len(pieces) - 1)], np.int32)
        flat_labels[pixels] = names[piece]
        for place, before, after in zip(ramp.cuts().tolist(), names[:-1].tolist(), names[1:].tolist(), strict=True):
            seams.append(Seam(before, after, ramp.direction, place))
        paints = paints.replaced(index, pieces.select(np.array([0]))).joined(pieces.select(np.arange(1, len(pieces))))
    return paints, labels, seams


def smooth_seams(assignment: Assignment, seams: list[Seam]) -> None:
    """Give the pixels on ``seams`` shares of both regions, as if the seam were an edge between them."""
    for seam in seams:
        sides = (seam.before, seam.after)
        rows, columns = np.nonzero(np.isin(assignment.label, sides) & np.isin(assignment.other, sides))
        beyond = seam.direction.places(np.stack([columns, rows], 1) + 0.5) - seam.place
        share = np.clip(0.5 + np.abs(beyond), 0.5, 1.0).astype(np.float32)
        label, other = (np.where((beyond > 0) ^ swap, seam.after, seam.before) for swap in (False, True))
        assignment.label[rows, columns] = label
        assignment.other[rows, columns] = np.where(share < 1, other, label)
        assignment.share[rows, columns] = share


def flat_paints(values: Floats) -> Paints:
    """Return flat paints of sRGB and straight alpha [K, 4], rounded to 8 bits."""
    values = np.round(values * 255).astype(np.float32) / np.float32(255)
    values[values[:, 3] == 0] = 0
    color, count = values[:, :3], len(values)
    return Paints(color, values[:, 3], np.zeros(count, np.int32), np.zeros((count, 4), np.float32), color.copy())
