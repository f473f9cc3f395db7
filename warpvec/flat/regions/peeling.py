"""Areas that one ramp shows in part: a soft edge has joined shapes, or a shape is as bright as the ramp somewhere."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Mask, Places, interpolated
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.ramp_directions import Direction, block_slopes, directions_from, refined
from warpvec.flat.regions.ramp_fitting import Ramp, ramp_along

Floats = NDArray[np.floating[Any]]


class Peel(NamedTuple):
    """The ramp of most of an area, and the pixels of the area that show it: a mask [N]."""

    ramp: Ramp
    shown: Mask


def peel(points: Floats, colors: Floats, tolerance: float) -> Peel | None:
    """Return the ramp that shows most of the ``colors`` [N, 3] of the pixels ``points`` [N, 2], or None.

    Pixels that differ from it are left out, and it is fitted anew to the others, again and again.
    """
    few = slice(None, None, -(-len(points) // REGIONS.paint_samples_max))
    best: Peel | None = None
    for direction in directions_from(points, *_usual_slopes(points, colors)):
        found = _peeled(direction, points[few], colors[few])
        if found is None:
            continue
        direction, is_shown = found
        ramp = ramp_along(
            direction, points[few][is_shown], colors[few][is_shown], tolerance, int(is_shown.mean() * len(points))
        )
        limit = max(REGIONS.peel_rest, 3.0 * ramp.error)
        if ramp.error > REGIONS.peel_error + tolerance:
            continue
        shown = ramp.differences(points, colors) <= limit
        if shown.mean() >= REGIONS.peel_share and (best is None or shown.sum() > REGIONS.peel_gain * best.shown.sum()):
            best = Peel(ramp, shown)
    return best


def _usual_slopes(points: Floats, colors: Floats) -> tuple[Floats, Floats]:
    """Return the centres and slopes of blocks, without those of edges, which are far steeper."""
    centers, slopes = block_slopes(points, colors)
    if not len(centers):
        return centers, slopes
    steepness = np.sqrt((slopes**2).sum((1, 2)))
    usual = steepness <= REGIONS.peel_slope * np.median(steepness)
    return centers[usual], slopes[usual]


def _peeled(direction: Direction, points: Floats, colors: Floats) -> tuple[Direction, Mask] | None:
    """Return the direction of the ramp of most pixels, and these [N]; None if too few are left."""
    shown = np.ones(len(points), bool)
    for _ in range(REGIONS.peel_rounds):
        rest = _differences(direction, points, colors, shown)
        now = rest <= max(REGIONS.peel_rest, REGIONS.peel_spread * float(np.median(rest[shown])))
        if now.sum() < REGIONS.peel_share * len(points):
            return None
        is_same, shown = bool((now == shown).all()), now
        if is_same:
            break
        direction = refined(direction, points[shown], colors[shown])
    return direction, shown


def _differences(direction: Direction, points: Floats, colors: Floats, shown: Mask) -> Floats:
    """Return by how much each pixel [N] differs from the usual colour at its place among those ``shown``."""
    places = direction.places(points)
    knots, usual = _usual_colors(places[shown], colors[shown])
    profile = interpolated(places, knots, usual)
    return np.abs(colors - profile).max(1)


def _usual_colors(places: Floats, colors: Floats) -> tuple[Floats, Floats]:
    """Return places [B] and the median colours [B, 3] there: those of less than half of the pixels do not count."""
    order = np.argsort(places, kind="stable")
    parts = [part for part in np.array_split(order, REGIONS.profile_bins) if len(part)]
    return np.array([places[part].mean() for part in parts]), np.stack([np.median(colors[p], 0) for p in parts])


def parts_of(pixels: Places, shown: Mask, width: int) -> tuple[Places, list[Places]]:
    """Return the pixels of an area that a ramp shows, and the connected parts of the others.

    Wisps of the others, and those in which no square of pixels lies, are in none: they are mixed at edges.
    """
    rows, columns = np.divmod(pixels, width)
    top, left = rows.min(), columns.min()
    other = np.zeros((np.ptp(rows) + 1, np.ptp(columns) + 1), bool)
    other[rows[~shown] - top, columns[~shown] - left] = True
    square = np.ones((REGIONS.clean_seed_width,) * 2, bool)
    numbers, count = ndimage.label(ndimage.binary_opening(other, square))
    found = numbers[rows - top, columns - left]
    parts = [pixels[found == number] for number in range(1, count + 1)]
    return pixels[shown], [part for part in parts if len(part) >= REGIONS.clean_seed_area]
