"""Linear and radial ramps of colour through the pixels of an area."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.ramp_directions import Direction, binned, directions_of, refined
from warpvec.geometry.paints.registry import FLAT, kind_of

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Ramp:
    """Colours along a direction: straight lines between stops.

    Attributes:
        direction: places along the ramp.
        knots: places of the stops, in pixels, ascending [M].
        colors: colours of the stops [M, 3].
        error: root mean square of what the ramp leaves.
    """

    direction: Direction
    knots: Floats
    colors: Floats
    error: float

    def contrast(self, metric: Floats) -> float:
        """Return the largest difference of two stops in a channel, seen by ``metric`` [4, 4] of RGBA."""
        return float(np.ptp(self.colors @ metric[:3], axis=0).max())

    def error_on(self, points: Floats, colors: Floats) -> float:
        """Return the root mean square that the paints leave of the colours [N, 3] of ``points`` [N, 2]."""
        piece = np.searchsorted(self.cuts(), self.direction.places(points)).astype(np.int32)
        x, y = points.astype(np.float32).T
        return float(np.sqrt(((colors - self.paints(1.0).at(piece, x, y)[:, :3]) ** 2).mean()))

    def cuts(self) -> Floats:
        """Return the places at which one paint of two stops follows another."""
        return self.knots[1:-1]

    def paints(self, opacity: float) -> Paints:
        """Return the paints of two stops, or flat ones, of the pieces between the cuts."""
        rows = [self._piece(index) for index in range(len(self.knots) - 1)]
        kind, color, end_color, geometry = (np.array(values) for values in zip(*rows, strict=True))
        alpha = np.full(len(rows), opacity, np.float32)
        first, last = (
            np.round(np.clip(values, 0, 1) * 255).astype(np.float32) / np.float32(255) for values in (color, end_color)
        )
        return Paints(first, alpha, kind.astype(np.int32), geometry.astype(np.float32), last)

    def _piece(self, index: int) -> tuple[int, Floats, Floats, Floats]:
        (start, end), (first, last) = self.knots[index : index + 2], self.colors[index : index + 2]
        if np.abs(last - first).max() < REGIONS.flat_step:
            return FLAT, (first + last) / 2, (first + last) / 2, np.zeros(4)
        kind, geometry = self.direction.kind, self.direction.geometry(start, end)
        if kind_of(kind).has_free_start:
            return kind, first, last, geometry
        return kind, *_stops_from_center(start, end, first, last), geometry


def _stops_from_center(start: float, end: float, first: Floats, last: Floats) -> tuple[Floats, Floats]:
    """Return the colours [3] at the centre and at radius ``end`` of the paint that shows a ring's colours best.

    A paint without a free start has its first stop at the centre. Where the ring's colours, continued inwards, leave
    [0, 1], the colour at the centre is limited, and that at the rim is the best by least squares.
    """
    center = first - (last - first) * start / (end - start)
    limited = np.clip(center, 0.0, 1.0)
    places = np.linspace(start, end, REGIONS.ring_samples) / end
    ring = first + (last - first) * np.linspace(0, 1, REGIONS.ring_samples)[:, None]
    slope = (places[:, None] * (ring - limited)).sum(0) / (places**2).sum()
    return limited, np.clip(np.where(limited == center, last, limited + slope), 0.0, 1.0)


def fit_ramp(points: Floats, colors: Floats, tolerance: float, sample: slice) -> Ramp | None:
    """Return the ramp through the colours [N, 3] of the pixels ``points`` [N, 2], or None if a flat paint does as well.

    Args:
        points: centres x, y of the pixels of an area.
        colors: their colours.
        tolerance: root mean square that a ramp may leave.
        sample: pixels used where all are not needed.
    """
    ramps = []
    few_points, few_colors = points[sample], colors[sample]
    for direction in directions_of(points, colors):
        better = refined(direction, few_points, few_colors)
        ramps.append(_with_stops(better, few_points, few_colors, tolerance))
    flat_error = float(np.sqrt(((few_colors - np.median(few_colors, 0)) ** 2).mean()))
    if not ramps:
        return None
    best = ramps[-1] if ramps[-1].error < REGIONS.radial_gain * max(ramps[0].error, tolerance) else ramps[0]
    return best if best.error < REGIONS.ramp_gain * flat_error else None


def _with_stops(direction: Direction, points: Floats, colors: Floats, tolerance: float) -> Ramp:
    """Return the ramp of fewest stops along ``direction`` that leaves at most ``tolerance``, or the best there is."""
    places = direction.places(points)
    at, means, count = binned(places, colors, REGIONS.ramp_bins)
    knots = np.array([at[0], at[-1]])
    tried = [(knots, *_colors_at_knots(knots, at, means, count))]
    for _ in range(min(REGIONS.knots_max, len(at)) - len(knots)):
        if tried[-1][2] <= tolerance:
            break
        knots = _one_more_knot(knots, at, means, count)
        tried.append((knots, *_colors_at_knots(knots, at, means, count)))
    limit = max(tolerance, REGIONS.knot_gain * tried[-1][2])
    knots, values = next((knots, values) for knots, values, error in tried if error <= limit)
    knots, values = _within_range(*_without_pads(knots, values, direction.kind), direction.kind)
    ramp = Ramp(direction, *_with_rings(knots, values, direction.kind), 0.0)
    return replace(ramp, error=ramp.error_on(points, colors))


def _within_range(knots: Floats, values: Floats, kind: int) -> tuple[Floats, Floats]:
    """Move the stops at the ends to where their colours leave [0, 1]: limiting colours would change the slope."""
    knots, values = knots.copy(), values.copy()
    for end, inner in ((-1, -2), (0, 1)) if kind_of(kind).has_free_start else ((-1, -2),):
        outside = np.maximum(np.abs(values[end] - np.clip(values[end], 0, 1)) - REGIONS.flat_step, 0)
        part = 1 - (outside / np.maximum(np.abs(values[end] - values[inner]), REGIONS.flat_step)).max()
        knots[end] = knots[inner] + part * (knots[end] - knots[inner])
        values[end] = values[inner] + part * (values[end] - values[inner])
    return knots, values


def _with_rings(knots: Floats, values: Floats, kind: int) -> tuple[Floats, Floats]:
    """Return the stops with more of them in the rings that one paint from the centre does not show well."""
    if kind_of(kind).has_free_start:
        return knots, values
    parts = [knots[:1]]
    for index, (start, end) in enumerate(pairwise(knots.tolist())):
        first, last = values[index : index + 2]
        center, rim = _stops_from_center(start, end, first, last)
        error = np.abs(center + (rim - center) * start / end - first).max()
        count = min(int(np.ceil(error / REGIONS.ring_error)), REGIONS.rings_max) if error > REGIONS.flat_step else 1
        parts.append(np.linspace(start, end, count + 1)[1:])
    more = np.concatenate(parts)
    return more, np.stack([np.interp(more, knots, column) for column in values.T], 1)


def _colors_at_knots(knots: Floats, at: Floats, means: Floats, count: Floats) -> tuple[Floats, float]:
    """Return the colours [M, 3] at ``knots`` [M] that fit the means best, and the error that remains."""
    weights = np.stack([np.interp(at, knots, row) for row in np.eye(len(knots))], 1)
    root = np.sqrt(count)[:, None]
    values, *_ = np.linalg.lstsq(root * weights, root * means, rcond=1.0e-9)
    rest = means - weights @ values
    return values, float(np.sqrt((count[:, None] * rest**2).sum() / (count.sum() * means.shape[1])))


def _one_more_knot(knots: Floats, at: Floats, means: Floats, count: Floats) -> Floats:
    """Return ``knots`` with one more, and all inner ones at their best places."""

    def error_of(inner: Floats) -> float:
        return _colors_at_knots(np.sort(np.concatenate([knots[[0, -1]], inner])), at, means, count)[1]

    def with_best(others: Floats) -> Floats:
        choices = [np.append(others, place) for place in at[1:-1]]
        return choices[int(np.argmin([error_of(choice) for choice in choices]))]

    inner = with_best(knots[1:-1])
    for _ in range(REGIONS.knot_sweeps * len(inner) if len(inner) > 1 else 0):
        inner = with_best(inner[1:])
    for step in np.ptp(knots) / REGIONS.ramp_bins * np.repeat(REGIONS.knot_steps, len(inner)):
        choices = [np.append(inner[1:], place) for place in inner[0] + step * np.arange(-1, 2)]
        inner = choices[int(np.argmin([error_of(choice) for choice in choices]))]
    return np.unique(np.concatenate([knots[[0, -1]], inner]))


def _without_pads(knots: Floats, values: Floats, kind: int) -> tuple[Floats, Floats]:
    """Drop stops at the ends where the colour stays: paints continue beyond their ends, radial ones only outwards."""

    def is_flat(first: int) -> bool:
        return bool(np.abs(values[first + 1] - values[first]).max() < REGIONS.flat_step)

    if len(knots) > 2 and is_flat(-2):
        knots, values = knots[:-1], values[:-1]
    if len(knots) > 2 and kind_of(kind).has_free_start and is_flat(0):
        knots, values = knots[1:], values[1:]
    return knots, values
