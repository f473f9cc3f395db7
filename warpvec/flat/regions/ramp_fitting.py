"""Linear, radial and elliptic ramps of colour through the pixels of an area."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.ramp_directions import Direction, binned, directions_of, refined
from warpvec.flat.regions.stop_places import stop_places
from warpvec.geometry.paints.registry import kind_of
from warpvec.geometry.stops import STOPS_MAX

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Ramp:
    """Colours along a direction: straight lines between stops.

    Attributes:
        direction: places along the ramp.
        knots: places of the stops, in pixels, ascending [M].
        colors: colours of the stops [M, 3], or colours and opacities [M, 4].
        error: root mean square of what the ramp leaves.
    """

    direction: Direction
    knots: Floats
    colors: Floats
    error: float

    def contrast(self, metric: Floats) -> float:
        """Return the largest difference of two stops in a channel, seen by ``metric`` [4, 4] of RGBA."""
        return float(np.ptp(self.colors @ metric[: self.colors.shape[1]], axis=0).max())

    def error_on(self, points: Floats, colors: Floats) -> float:
        """Return the root mean square that the paint leaves of the colours [N, 3 or 4] of ``points`` [N, 2]."""
        return float(np.sqrt(((colors - self.shown(points)) ** 2).mean()))

    def differences(self, points: Floats, colors: Floats) -> Floats:
        """Return by how much the colours [N, 3 or 4] of ``points`` [N, 2] differ in some channel [N]."""
        return np.abs(colors - self.shown(points)).max(1)

    def shown(self, points: Floats) -> Floats:
        """Return the colours [N, 3], or colours and opacities [N, 4], that the paint has at ``points`` [N, 2]."""
        x, y = points.astype(np.float32).T
        values = self.paint(1.0).at(np.zeros(len(x), np.int32), x, y)
        values[:, :3] /= np.maximum(values[:, 3:], np.float32(1e-6))
        return values[:, : self.colors.shape[1]]

    def paint(self, opacity: float) -> Paints:
        """Return the paint of the ramp, the only one of the result; a ramp of opacities has its own ``opacity``."""
        start, end = self._ends()
        knots = (self.knots - start) / (end - start)
        levels = np.round(np.clip(self.colors[:, :3], 0, 1) * 255).astype(np.float32) / np.float32(255)
        colors = np.stack([levels[0], levels[-1]])
        if self._starts_at_center():
            center = self.colors[0] - (self.colors[1] - self.colors[0]) * self.knots[0] / np.ptp(self.knots)
            knots, colors[0] = np.array([0.0, 1.0]), np.round(center * 255) / 255
        shown = np.ones((1, STOPS_MAX), np.float32)
        if self.colors.shape[1] > 3:
            opacity = REGIONS.translucent_max
            shown[0, : len(knots)] = np.clip(self.colors[:, 3] / opacity, 0, 1)
        count, inner = len(knots), np.zeros((1, STOPS_MAX - 2, 3), np.float32)
        offset = np.ones((1, STOPS_MAX), np.float32)
        offset[0, :count], inner[0, : count - 2] = knots, levels[1:-1]
        kind, geometry = self.direction.kind, self.direction.geometry(start, end)[None].astype(np.float32)
        number, alpha = np.array([kind], np.int32), np.array([opacity], np.float32)
        return Paints(
            colors[:1], alpha, number, geometry, colors[1:], np.array([count], np.int32), offset, inner, shown
        )

    def _ends(self) -> tuple[float, float]:
        """Return the places where the gradient starts and ends; without a free start it starts at its centre."""
        start = float(self.knots[0]) if kind_of(self.direction.kind).has_free_start else 0.0
        return start, float(self.knots[-1])

    def _starts_at_center(self) -> bool:
        """Return whether the ramp has two stops whose colours go on to a centre: most gradients begin there."""
        if kind_of(self.direction.kind).has_free_start or self.colors.shape != (2, 3):
            return False
        center = self.colors[0] - (self.colors[1] - self.colors[0]) * self.knots[0] / np.ptp(self.knots)
        return bool(np.abs(center - np.clip(center, 0, 1)).max() < REGIONS.flat_step / 2)


def fit_ramp(points: Floats, colors: Floats, tolerance: float, sample: slice) -> Ramp | None:
    """Return the ramp through the colours [N, 3 or 4] of ``points`` [N, 2], or None if a flat paint does as well.

    Args:
        points: centres x, y of the pixels of an area.
        colors: their colours.
        tolerance: root mean square that a ramp may leave.
        sample: pixels used where all are not needed.
    """
    few_points, few_colors = points[sample], colors[sample]
    best: Ramp | None = None
    for direction in directions_of(points, colors):
        if best is not None and best.error <= tolerance:
            break
        ramp = ramp_along(refined(direction, few_points, few_colors), few_points, few_colors, tolerance, len(points))
        if best is None or ramp.error < REGIONS.radial_gain * max(best.error, tolerance):
            best = ramp
    flat_error = float(np.sqrt(((few_colors - np.median(few_colors, 0)) ** 2).mean()))
    is_plain = flat_error > REGIONS.plain_ramp_error + tolerance
    gain = REGIONS.plain_ramp_gain if is_plain else REGIONS.ramp_gain
    return best if best is not None and best.error < gain * flat_error else None


def ramp_along(direction: Direction, points: Floats, colors: Floats, tolerance: float, pixel_count: int) -> Ramp:
    """Return the ramp along ``direction`` with the stops that pay.

    It has as few as leave at most ``tolerance``, or the best there is, and those more that lower the squared error of
    an area of ``pixel_count`` pixels by their price.
    """
    places = direction.places(points)
    at, means, count = binned(places, colors, REGIONS.ramp_bins)
    tried: list[tuple[Floats, Floats, float]] = []
    scale = pixel_count * colors.shape[1]
    price = REGIONS.stop_price * (tolerance / REGIONS.stop_deviation) ** 2
    for knots in stop_places(at, means, count):
        better = _moved_knots(knots, at, means, count)
        values, found = _colors_at_knots(better, at, means, count)
        error = float(found)
        tried.append((better, values, error))
        if (error <= tolerance and scale * error**2 <= price) or _is_idle([each[2] for each in tried]):
            break
    errors = np.array([error for *_, error in tried])
    least = int(np.argmax(errors <= max(tolerance, REGIONS.knot_gain * errors[-1])))
    prices = scale * errors[least:] ** 2 + price * np.arange(len(errors) - least)
    knots, values, _ = tried[least + int(prices.argmin())]
    ramp = Ramp(direction, *_within_range(*_without_pads(knots, values, direction.kind), direction.kind), 0.0)
    return replace(ramp, error=ramp.error_on(points, colors))


def _is_idle(errors: list[float]) -> bool:
    """Return whether the last stops that were added have gained hardly anything."""
    return len(errors) > REGIONS.idle_knots and errors[-1] > REGIONS.idle_gain * errors[-1 - REGIONS.idle_knots]


def _within_range(knots: Floats, values: Floats, kind: int) -> tuple[Floats, Floats]:
    """Move the stops at the ends to where their colours leave [0, 1]: limiting colours would change the slope."""
    knots, values = knots.copy(), values.copy()
    for end, inner in ((-1, -2), (0, 1)) if kind_of(kind).has_free_start else ((-1, -2),):
        outside = np.maximum(np.abs(values[end] - np.clip(values[end], 0, 1)) - REGIONS.flat_step, 0)
        part = 1 - (outside / np.maximum(np.abs(values[end] - values[inner]), REGIONS.flat_step)).max()
        knots[end] = knots[inner] + part * (knots[end] - knots[inner])
        values[end] = values[inner] + part * (values[end] - values[inner])
    return knots, values


def stop_weights(knots: Floats, places: Floats) -> Floats:
    """Return the share [..., N, M] of each stop at ``knots`` [..., M] in the colour at each of ``places`` [N]."""
    gaps = np.maximum(np.diff(knots), 1e-9)[..., None, :]
    part = np.clip((places[:, None] - knots[..., None, :-1]) / gaps, 0.0, 1.0)
    ends = np.ones((*part.shape[:-1], 1))
    return np.concatenate([ends, part], -1) - np.concatenate([part, 0.0 * ends], -1)


def _colors_at_knots(knots: Floats, at: Floats, means: Floats, count: Floats) -> tuple[Floats, Floats]:
    """Return the colours [..., M, 3] at ``knots`` [..., M] that fit the means best, and the errors that remain."""
    weights = stop_weights(knots, at)
    heavy = count[:, None] * weights
    matrix = np.einsum("...bi,...bj->...ij", heavy, weights)
    matrix += 1e-9 * np.trace(matrix, axis1=-2, axis2=-1)[..., None, None] * np.eye(knots.shape[-1])
    values = np.linalg.solve(matrix, np.einsum("...bi,bc->...ic", heavy, means))
    rest = means - np.einsum("...bi,...ic->...bc", weights, values)
    return values, np.sqrt((count[:, None] * rest**2).sum((-2, -1)) / (count.sum() * means.shape[1]))


def _moved_knots(knots: Floats, at: Floats, means: Floats, count: Floats) -> Floats:
    """Return ``knots`` with the inner ones moved to their best places."""
    inner, ends = knots[1:-1], np.broadcast_to(knots[[0, -1]], (3, 2))
    for step in np.ptp(knots) / REGIONS.ramp_bins * np.repeat(REGIONS.knot_steps, len(inner)):
        moved = np.broadcast_to(np.append(inner[1:], inner[0]), (3, len(inner))).copy()
        moved[:, -1] += step * np.arange(-1, 2)
        errors = _colors_at_knots(np.sort(np.concatenate([ends, moved], 1)), at, means, count)[1]
        inner = moved[int(np.argmin(errors))]
    return np.unique(np.concatenate([knots[[0, -1]], np.clip(inner, knots[0], knots[-1])]))


def _without_pads(knots: Floats, values: Floats, kind: int) -> tuple[Floats, Floats]:
    """Drop stops at the ends where the colour stays: paints continue beyond their ends, radial ones only outwards."""

    def is_flat(first: int) -> bool:
        return bool(np.abs(values[first + 1] - values[first]).max() < REGIONS.flat_step)

    if len(knots) > 2 and is_flat(-2):
        knots, values = knots[:-1], values[:-1]
    if len(knots) > 2 and kind_of(kind).has_free_start and is_flat(0):
        knots, values = knots[1:], values[1:]
    return knots, values
