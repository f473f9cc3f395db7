"""The paints that the pure pixels of areas show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats32, Integers32, Places
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.banding import split_into_bands
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.ramp_directions import Direction
from warpvec.flat.regions.ramp_fitting import Ramp, fit_ramp
from warpvec.flat.regions.region_growing import pixels_of
from warpvec.watch.watch import UNWATCHED, Watch


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


@dataclass(frozen=True, eq=False)
class FittedPaints:
    """The paints of areas.

    Attributes:
        values: median colour of each area, sRGB with straight alpha [4].
        ramps: the ramps of those that are not flat.
        errors: root mean square that the paint of each area leaves.
    """

    values: list[Floats32]
    ramps: dict[int, Ramp]
    errors: list[float]


def fit_paints(
    image: Floats32, labels: Integers32, tolerances: Tolerances, watch: Watch = UNWATCHED
) -> tuple[Paints, Integers32, list[Seam]]:
    """Fit the paints of the areas ``labels`` [h, w] of ``image`` [h, w, 4], sRGB with straight alpha.

    Once the ``watch`` is over, the areas that are left get flat paints.

    Returns the paints, the labels with areas split whose ramp has more than two stops, and the seams of those.
    """
    colors, labels = image.reshape(-1, 4), labels.copy()
    areas = pixels_of(labels)
    fits = fit_areas(areas, colors, labels.shape[1], tolerances, watch)
    alpha = colors[:, 3:]
    seen = np.concatenate([colors[:, :3] * alpha, alpha], 1)
    bands = split_into_bands(areas, seen, fits.errors, tolerances.noise)
    for index in range(len(bands)):
        if index >= len(areas) or len(bands[index]) < len(areas[index]):
            fits.ramps.pop(index, None)
            fits.values[index : index + 1] = [np.median(colors[_few(bands[index])], 0)]
            labels.reshape(-1)[bands[index]] = index
    return _with_ramps(flat_paints(np.stack(fits.values)), labels, bands, fits.ramps)


def fit_areas(
    areas: list[Places], colors: Floats32, width: int, tolerances: Tolerances, watch: Watch = UNWATCHED
) -> FittedPaints:
    """Fit paints to areas of pixels, numbered by rows of ``width``, whose ``colors`` are sRGB with straight alpha.

    Once the ``watch`` is over, the areas that are left get flat paints, the smallest ones.
    """
    values = [np.median(colors[_few(pixels)], 0) for pixels in areas]
    ramps = _find_ramps(areas, colors, values, width, tolerances, watch)
    errors = [
        _error_of(colors[_few(pixels)], value, ramps.get(index))
        for index, (pixels, value) in enumerate(zip(areas, values, strict=True))
    ]
    return FittedPaints(values, ramps, errors)


def _error_of(colors: Floats32, value: Floats32, ramp: Ramp | None) -> float:
    """Return the root mean square that the paint of an area leaves of its colours [N, 4]: of these or of opacity."""
    color, opacity = (float(np.sqrt((part**2).mean())) for part in np.split(colors - value, [3], 1))
    if value[3] == 0:
        return opacity
    return max(color if ramp is None else ramp.error, opacity)


def _few(pixels: Places) -> Places:
    return pixels[:: -(-len(pixels) // REGIONS.paint_samples_max)]


def _find_ramps(
    areas: list[Places], colors: Floats32, values: list[Floats32], width: int, tolerances: Tolerances,
    watch: Watch,
) -> dict[int, Ramp]:  # fmt: skip
    """Return the ramps of the areas that are not flat, the largest first. Parts of one ramp get the same one."""
    limit = REGIONS.flat_deviation + REGIONS.noise_deviation * tolerances.noise
    area_min = REGIONS.noisy_ramp_area_min if tolerances.noise > 0 else REGIONS.ramp_area_min
    ramps: dict[int, Ramp] = {}
    for index in sorted(range(len(areas)), key=lambda index: -len(areas[index])):
        if watch.is_over():
            break
        pixels, few = areas[index], _few(areas[index])
        if len(pixels) < REGIONS.shared_area_min or values[index][3] == 0:
            continue
        deviation = float(np.sqrt(((colors[few] - values[index])[:, :3] ** 2).mean()))
        gain = REGIONS.shared_gain if len(pixels) >= REGIONS.shared_small * area_min else REGIONS.shared_small_gain
        ramp = _shared_ramp(ramps, few, colors, width, gain * deviation, limit)
        if ramp is None and len(pixels) >= area_min and deviation > limit:
            sample = slice(None, None, -(-len(pixels) // REGIONS.paint_samples_max))
            ramp = fit_ramp(_points(pixels, width), colors[pixels, :3].astype(np.float64), limit, sample)
        if ramp is not None and ramp.contrast(tolerances.metric) >= REGIONS.ramp_contrast + tolerances.noise:
            ramps[index] = ramp
    return ramps


def _shared_ramp(
    ramps: dict[int, Ramp], pixels: Places, colors: Floats32, width: int, error_max: float, limit: float
) -> Ramp | None:
    """Return the first of ``ramps`` that shows ``pixels`` with less than ``error_max`` and about as well as its own."""
    points, shown = _points(pixels, width), colors[pixels, :3].astype(np.float64)
    for ramp in ramps.values():
        if ramp.error_on(points, shown) < min(error_max, REGIONS.shared_error * max(ramp.error, limit)):
            return ramp
    return None


def _points(pixels: Places, width: int) -> NDArray[np.floating[Any]]:
    """Return the centres x, y [N, 2] of pixels numbered by rows."""
    return np.stack([pixels % width, pixels // width], 1) + 0.5


def _with_ramps(
    paints: Paints, labels: Integers32, areas: list[Places], ramps: dict[int, Ramp]
) -> tuple[Paints, Integers32, list[Seam]]:
    """Replace flat paints by ramps, and split the areas of ramps of several pieces."""
    seams: list[Seam] = []
    flat_labels = labels.reshape(-1)
    for index, ramp in ramps.items():
        pieces = ramp.paints(float(paints.opacity[index]))
        places = ramp.direction.places(_points(areas[index], labels.shape[1]))
        names = np.array([index, *range(len(paints), len(paints) + len(pieces) - 1)], np.int32)
        flat_labels[areas[index]] = names[np.searchsorted(ramp.cuts(), places)]
        for place, before, after in zip(ramp.cuts().tolist(), names[:-1].tolist(), names[1:].tolist(), strict=True):
            seams.append(Seam(before, after, ramp.direction, place))
        first, others = (pieces.select(np.arange(*ends, dtype=np.int32)) for ends in ((0, 1), (1, len(pieces))))
        paints = paints.replaced(index, first).joined(others)
    return paints, labels, seams


def smooth_seams(assignment: Assignment, seams: list[Seam]) -> None:
    """Give the pixels on ``seams`` shares of both regions, as if the seam were an edge between them."""
    width = assignment.label.shape[1]
    for seam in seams:
        sides = (seam.before, seam.after)
        pixels = np.flatnonzero(np.isin(assignment.label, sides) & np.isin(assignment.other, sides))
        rows, columns = np.divmod(pixels, width)
        beyond = seam.direction.places(_points(pixels, width)) - seam.place
        share = np.clip(0.5 + np.abs(beyond), 0.5, 1.0).astype(np.float32)
        label, other = (np.where((beyond > 0) ^ swap, seam.after, seam.before) for swap in (False, True))
        assignment.label[rows, columns] = label
        assignment.other[rows, columns] = np.where(share < 1, other, label)
        assignment.share[rows, columns] = share


def flat_paints(values: Floats32) -> Paints:
    """Return flat paints of sRGB and straight alpha [K, 4], rounded to 8 bits."""
    values = np.round(values * 255).astype(np.float32) / np.float32(255)
    values[values[:, 3] == 0] = 0
    color, count = values[:, :3], len(values)
    return Paints(color, values[:, 3], np.zeros(count, np.int32), np.zeros((count, 4), np.float32), color.copy())
