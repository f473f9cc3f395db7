"""The paints that the pure pixels of areas show."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats, Floats32, Integers32, Places
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.banding import split_into_bands
from warpvec.flat.regions.color_moments import moments_of
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.peeling import parts_of, peel
from warpvec.flat.regions.ramp_fitting import Ramp, fit_ramp
from warpvec.flat.regions.ramp_refitting import refitted
from warpvec.flat.regions.region_growing import NONE, pixels_of, points_of
from warpvec.watch.watch import UNWATCHED, Watch


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
) -> tuple[Paints, Integers32]:
    """Fit the paints of the areas ``labels`` [h, w] of ``image`` [h, w, 4], sRGB with straight alpha.

    Once the ``watch`` is over, the areas that are left get flat paints.

    Returns the paints, and the labels with areas split that no paint shows.
    """
    colors, labels = image.reshape(-1, 4), labels.copy()
    areas = pixels_of(labels)
    fits = fit_areas(areas, colors, labels.shape[1], tolerances, watch)
    areas = _peel_areas(areas, fits, colors, labels, tolerances, watch)
    alpha = colors[:, 3:]
    seen = np.concatenate([colors[:, :3] * alpha, alpha], 1)
    bands = split_into_bands(areas, seen, fits.errors, tolerances.noise)
    for index in range(len(bands)):
        if index >= len(areas) or len(bands[index]) < len(areas[index]):
            fits.ramps.pop(index, None)
            fits.values[index : index + 1] = [np.median(colors[_few(bands[index])], 0)]
            labels.reshape(-1)[bands[index]] = index
    paints = flat_paints(np.stack(fits.values))
    for index, ramp in fits.ramps.items():
        paints = paints.replaced(index, ramp.paint(float(paints.opacity[index])))
    return paints, labels


def _peel_areas(
    areas: list[Places], fits: FittedPaints, colors: Floats32, labels: Integers32, tolerances: Tolerances, watch: Watch
) -> list[Places]:
    """Divide areas that no paint shows into the part that a ramp shows, and what is left, and add the paints of these.

    Pixels that belong to no part get no label.
    """
    areas, width = list(areas), labels.shape[1]
    waiting = [(index, REGIONS.peel_depth) for index in range(len(areas))]
    while waiting and not watch.is_over():
        index, depth = waiting.pop()
        pixels = areas[index]
        # What noise leaves of a ramp is less than its loudest differences; of flat areas, ringing leaves about as much.
        noise = tolerances.noise * (REGIONS.noise_deviation if index in fits.ramps else 1.0)
        if depth == 0 or not _may_be_several(len(pixels), fits.values[index], fits.errors[index], noise):
            continue
        found = peel(points_of(pixels, width), colors[pixels, :3].astype(np.float64), _stop_limit(tolerances))
        if found is None:
            continue
        areas[index], rest = parts_of(pixels, found.shown, width)
        ramp = refitted(found.ramp, points_of(areas[index], width), colors[areas[index], :3].astype(np.float64))
        fits.ramps[index], fits.errors[index] = ramp, ramp.error
        fits.values[index] = np.median(colors[_few(areas[index])], 0)
        more = fit_areas(rest, colors, width, tolerances, watch)
        fits.ramps.update({len(areas) + number: ramp for number, ramp in more.ramps.items()})
        fits.values.extend(more.values)
        fits.errors.extend(more.errors)
        waiting += [(len(areas) + number, depth - 1) for number in range(len(rest))]
        areas += rest
        labels.reshape(-1)[pixels] = NONE
        for number in (index, *range(len(areas) - len(rest), len(areas))):
            labels.reshape(-1)[areas[number]] = number
    return areas


def _may_be_several(size: int, value: Floats32, error: float, noise: float) -> bool:
    """Return whether an area of ``size`` pixels, whose paint leaves an ``error``, may consist of several paints."""
    is_opaque = bool(value[3] == 1)
    return is_opaque and size >= REGIONS.peel_area_min and error > REGIONS.peel_error_min + noise


def fit_areas(
    areas: list[Places], colors: Floats32, width: int, tolerances: Tolerances, watch: Watch = UNWATCHED
) -> FittedPaints:
    """Fit paints to areas of pixels, numbered by rows of ``width``, whose ``colors`` are sRGB with straight alpha.

    Once the ``watch`` is over, the areas that are left get flat paints, the smallest ones.
    """
    few = [_few(pixels) for pixels in areas]
    is_even = _are_even(few, colors)  # most of the thousands of areas of a pattern, without a median of each
    values = [colors[own[0]] if even else np.median(colors[own], 0) for own, even in zip(few, is_even, strict=True)]
    ramps = _find_ramps(areas, colors, values, width, tolerances, watch)
    errors = [
        0.0 if is_even[index] and index not in ramps else _error_of(colors[own], values[index], ramps.get(index))
        for index, own in enumerate(few)
    ]
    return FittedPaints(values, ramps, errors)


def _are_even(areas: list[Places], colors: Floats32) -> list[bool]:
    """Return which ``areas`` have pixels of one colour only."""
    if not areas:
        return []
    sizes = np.array([len(pixels) for pixels in areas])
    first = colors[[pixels[0] for pixels in areas]]
    is_alike = (colors[np.concatenate(areas)] == np.repeat(first, sizes, 0)).all(1)
    even: list[bool] = np.logical_and.reduceat(is_alike, np.cumsum(sizes) - sizes).tolist()
    return even


def _error_of(colors: Floats32, value: Floats32, ramp: Ramp | None) -> float:
    """Return the root mean square that the paint of an area leaves of its colours [N, 4]: of these or of opacity."""
    color, opacity = (float(np.sqrt((part**2).mean())) for part in np.split(colors - value, [3], 1))
    if value[3] == 0 or (ramp is not None and ramp.colors.shape[1] > 3):
        return opacity if ramp is None else ramp.error
    return max(color if ramp is None else ramp.error, opacity)


def _few(pixels: Places) -> Places:
    return pixels[:: -(-len(pixels) // REGIONS.paint_samples_max)]


def _find_ramps(
    areas: list[Places], colors: Floats32, values: list[Floats32], width: int, tolerances: Tolerances,
    watch: Watch,
) -> dict[int, Ramp]:  # fmt: skip
    """Return the ramps of the areas that are not flat, the largest first. Parts of one ramp get the same one."""
    least = REGIONS.shared_area_min if tolerances.noise > 0 else REGIONS.plain_area_min
    ramps: dict[int, Ramp] = {}
    for index in sorted(range(len(areas)), key=lambda index: -len(areas[index])):
        if watch.is_over():
            break
        pixels = areas[index]
        if len(pixels) < least or values[index][3] == 0:
            continue
        if len(pixels) < REGIONS.shared_area_min:
            ramp = _plain_ramp(points_of(pixels, width), colors[pixels])
        else:
            ramp = _own_or_shared_ramp(ramps, pixels, colors, values[index], width, tolerances)
        if ramp is not None and ramp.contrast(tolerances.metric) >= REGIONS.ramp_contrast + tolerances.noise:
            ramps[index] = ramp
    return ramps


def _own_or_shared_ramp(
    ramps: dict[int, Ramp], pixels: Places, colors: Floats32, value: Floats32, width: int, tolerances: Tolerances
) -> Ramp | None:
    """Return the ramp of an area whose median colour is ``value``: one of the known ``ramps``, its own, or None."""
    limit = REGIONS.flat_deviation + REGIONS.noise_deviation * tolerances.noise
    area_min = REGIONS.noisy_ramp_area_min if tolerances.noise > 0 else REGIONS.ramp_area_min
    few = _few(pixels)
    channels = _channels(colors[few], tolerances)
    deviation = float(np.sqrt(((colors[few] - value)[:, :channels] ** 2).mean()))
    gain = REGIONS.shared_gain if len(pixels) >= REGIONS.shared_small * area_min else REGIONS.shared_small_gain
    shared = _shared_ramp(ramps, few, colors[:, :channels], width, gain * deviation, limit)
    is_small = len(pixels) < area_min
    least_of_small = math.inf if tolerances.noise > 0 else REGIONS.small_ramp_deviation
    if shared is not None or deviation <= (least_of_small if is_small else limit):
        return shared
    ramp = ramp_of_pixels(points_of(pixels, width), colors[pixels, :channels].astype(np.float64), tolerances)
    is_poor = is_small and ramp is not None and ramp.error > REGIONS.small_ramp_rest
    return None if is_poor else ramp


def _plain_ramp(points: Floats, colors: Floats32) -> Ramp | None:
    """Return the linear ramp of two stops that opaque ``colors`` [N, 4] of few ``points`` [N, 2] show, or None."""
    if (colors[:, 3] < 1).any():
        return None
    shown = colors[:, :3].astype(np.float64)
    if np.sqrt(((shown - shown.mean(0)) ** 2).mean()) <= REGIONS.small_ramp_deviation:
        return None
    ramp = moments_of(np.zeros(len(points), np.int64), shown, points, 1)[0].ramp().between(points)
    return ramp if ramp.error <= REGIONS.small_ramp_rest else None


def ramp_of_pixels(
    points: NDArray[np.floating[Any]], colors: NDArray[np.floating[Any]], tolerances: Tolerances
) -> Ramp | None:
    """Return the ramp of the colours [N, 3 or 4] of ``points`` [N, 2], or None if a flat paint does as well."""
    sample = slice(None, None, -(-len(points) // REGIONS.paint_samples_max))
    ramp = fit_ramp(points, colors, _stop_limit(tolerances), sample)
    return None if ramp is None else refitted(ramp, points, colors)


def _shared_ramp(
    ramps: dict[int, Ramp], pixels: Places, colors: Floats32, width: int, error_max: float, limit: float
) -> Ramp | None:
    """Return the first of ``ramps`` that shows ``pixels`` with less than ``error_max`` and about as well as its own."""
    points, shown = points_of(pixels, width), colors[pixels].astype(np.float64)
    for ramp in ramps.values():
        if ramp.colors.shape[1] == shown.shape[1] and ramp.error_on(points, shown) < min(
            error_max, REGIONS.shared_error * max(ramp.error, limit)
        ):
            return ramp
    return None


def _stop_limit(tolerances: Tolerances) -> float:
    """Return the root mean square that a ramp may leave where a stop more would leave less."""
    return REGIONS.stop_deviation + REGIONS.noise_deviation * tolerances.noise


def _channels(colors: Floats32, tolerances: Tolerances) -> int:
    """Return 4 if the opacity of the pixels with these straight ``colors`` [N, 4] changes, and 3 if colours do only."""
    low, high = np.quantile(colors[:, 3], [0.02, 0.98])
    changes = high - low >= REGIONS.opacity_change + tolerances.noise
    return 4 if changes and low >= REGIONS.opacity_min else 3


def flat_paints(values: Floats32) -> Paints:
    """Return flat paints of sRGB and straight alpha [K, 4], rounded to 8 bits."""
    values = np.round(values * 255).astype(np.float32) / np.float32(255)
    values[values[:, 3] == 0] = 0
    color, count = values[:, :3], len(values)
    return Paints(color, values[:, 3], np.zeros(count, np.int32), np.zeros((count, 4), np.float32), color.copy())
