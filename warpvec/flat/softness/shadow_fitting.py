"""Fit a shadow to a picture: the offset, the blur and the amplitude with which a mask explains what is seen."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.softness import SOFTNESS

_SIGMAS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Standard deviations from which the fit begins, each a factor of two apart."""


@dataclass(frozen=True)
class Zone:
    """What a picture adds to a ground, where nothing covers it.

    Attributes:
        change: the picture minus its ground, in levels [h, w, C].
        deviation: of the ground from its middle colour [h, w, C]; None for a flat one.
        is_seen: where no shape covers the ground [h, w].
        noise: standard deviation of the picture, in levels, that no shadow explains.
    """

    change: Floats
    deviation: Floats | None
    is_seen: Mask
    noise: float = 0.0

    def reduced(self, step: int) -> Zone:
        """Return the zone in a copy of the picture that is ``step`` times smaller, without pixels half covered."""
        varied = None if self.deviation is None else reduced(self.deviation, step)
        is_seen = reduced(self.is_seen.astype(np.float64), step) == 1.0
        return Zone(reduced(self.change, step), varied, is_seen, self.noise / step)

    def cropped(self, box: tuple[slice, slice]) -> Zone:
        """Return the part of the zone in a ``box``."""
        varied = None if self.deviation is None else self.deviation[box]
        return Zone(self.change[box], varied, self.is_seen[box], self.noise)

    def unexplained(self, error: float) -> float:
        """Return the share of the energy of what is seen that a squared ``error`` is, both without that of noise."""
        seen = self.change[self.is_seen]
        noise = self.noise**2 * seen.size
        return max(error - noise, 0.0) / max(float((seen * seen).sum()) - noise, 1e-12)

    @property
    def pixels(self) -> tuple[Floats, Floats | None]:
        """The change and the deviation at the K pixels that are seen, each [K, C]."""
        return self.change[self.is_seen], None if self.deviation is None else self.deviation[self.is_seen]


@dataclass(frozen=True)
class FoundShadow:
    """A fitted shadow.

    Attributes:
        offset: how far it is moved to the right and down, in pixels.
        sigma: its standard deviation in pixels.
        amplitude: what it adds to the middle colour of the ground in each channel [C], in levels.
        opacity: the share of the ground's deviation from its middle colour that the shadow hides; 0 for a flat ground.
        unexplained: the share of the energy of what is seen that it does not explain.
    """

    offset: tuple[float, float]
    sigma: float
    amplitude: Floats
    opacity: float
    unexplained: float

    def shade_of(self, cast: Floats, deviation: Floats | None) -> Floats:
        """Return what the shadow of a coverage ``cast`` [h, w] adds to the ground [h, w, C], in levels.

        The ``deviation`` of the ground from its middle colour is [h, w, C]; None for a flat one.
        """
        return _added(moved_blur(cast, self.offset, self.sigma), self.amplitude, self.opacity, deviation)


def moved_blur(mask: Floats, offset: tuple[float, float], sigma: float) -> Floats:
    """Return ``mask`` [h, w] moved and blurred; at the border of the picture it goes on as it is there."""
    moved = ndimage.shift(mask, (offset[1], offset[0]), order=3, mode="nearest") if any(offset) else mask
    blurred: Floats = ndimage.gaussian_filter(moved, sigma, mode="nearest", truncate=3.5)
    return blurred


def amplitude_of(strength: Floats, seen: Floats, deviation: Floats | None) -> tuple[Floats, float]:
    """Return the amplitude [C] and the opacity with which a ``strength`` [K] explains changes best.

    Args:
        strength: of the shadow at some pixels [K].
        seen: what is added there to the ground [K, C].
        deviation: of the ground from its middle colour there [K, C]; None for a flat one, whose opacity is 0.
    """
    energy = max(float(strength @ strength), 1e-12)
    free: Floats = strength @ seen / energy
    if deviation is None:
        return free, 0.0
    # Each channel has an amplitude of its own, and all have one opacity.
    taken = strength[:, None] * deviation
    along = strength @ taken / energy
    rest = taken - strength[:, None] * along
    opacity = -float((rest * seen).sum()) / max(float((rest * rest).sum()), 1e-12)
    opacity = float(np.clip(opacity, 0.0, 1.0))
    return free + opacity * along, opacity


def explained(strength: Floats, seen: Floats, deviation: Floats | None) -> Floats:
    """Return what a shadow of this ``strength`` adds at best [K, C]; arguments as for `amplitude_of`."""
    return _added(strength, *amplitude_of(strength, seen, deviation), deviation)


def _added(strength: Floats, amplitude: Floats, opacity: float, deviation: Floats | None) -> Floats:
    """Return what a shadow of a ``strength`` [...] adds to a ground with this ``deviation`` [..., C] or none."""
    added: Floats = strength[..., None] * (amplitude if deviation is None else amplitude - opacity * deviation)
    return added


def fit_shadow(
    zone: Zone, mask: Floats, rough: FoundShadow | None, coarse_max: float = SOFTNESS.coarse_unexplained
) -> FoundShadow | None:
    """Return the shadow that `_fit` finds in a small copy, or from a ``rough`` one on in the picture itself.

    It is None if the small copy shows that there is none, because more than ``coarse_max`` is unexplained, or none that
    is as near and as sharp as shadows are.
    """
    if rough is None:
        step, begin = -(-max(mask.shape) // SOFTNESS.coarse_side), None
    else:
        step = max(1, min(max(mask.shape) // SOFTNESS.fine_side, int(rough.sigma / SOFTNESS.fine_sigma)))
        begin = rough.offset[0] / step, rough.offset[1] / step, rough.sigma / step
    small, own = zone.reduced(step), reduced(mask, step)
    if begin is not None and own.any():
        box = _reach(own, begin)
        small, own = small.cropped(box), own[box]
    found = _fit(small, own, begin)
    if found is None or (begin is None and step > 1 and found.unexplained > coarse_max):
        return None
    offset, sigma = (step * found.offset[0], step * found.offset[1]), step * found.sigma
    is_far = max(map(abs, offset)) > SOFTNESS.offset_max or sigma > SOFTNESS.sigma_max
    return None if is_far else replace(found, offset=offset, sigma=sigma)


def _reach(mask: Floats, begin: tuple[float, float, float]) -> tuple[slice, slice]:
    """Return the rows and columns of a ``mask`` [h, w] that its shadow of nearly this offset and deviation reaches."""
    margin = int(8.0 + max(map(abs, begin[:2])) + 4.0 * begin[2])
    sides = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
    rows, columns = (slice(max(int(side[0]) - margin, 0), int(side[-1]) + 1 + margin) for side in sides)
    return rows, columns


def rough_loss(zone: Zone, mask: Floats) -> float:
    """Return the least share of what is seen that a rough shadow of ``mask`` [h, w] leaves, in a very small copy."""
    step = -(-max(mask.shape) // SOFTNESS.rough_side)
    small, own = zone.reduced(step), reduced(mask, step)
    seen, varied = small.pixels
    energy = float((seen * seen).sum())
    if energy <= 0.0 or not own.any():
        return 1.0
    losses = []
    for dx, dy, sigma in _starts(small, own):
        strength = moved_blur(own, (dx, dy), float(np.exp(sigma)))[small.is_seen]
        losses.append(float(((seen - explained(strength, seen, varied)) ** 2).sum()))
    return min(losses) / energy


def reduced(values: Floats, step: int) -> Floats:
    """Return the means [h // step, w // step, ...] of blocks of ``step`` x ``step`` pixels."""
    if step == 1:
        return values
    height, width = (size // step for size in values.shape[:2])
    blocks = values[: height * step, : width * step].reshape(height, step, width, step, *values.shape[2:])
    means: Floats = blocks.mean((1, 3))
    return means


def _fit(zone: Zone, mask: Floats, begin: tuple[float, float, float] | None) -> FoundShadow | None:
    """Return the shadow that explains what is seen best; None if nothing changes, or nothing casts it.

    Args:
        zone: what is seen of it.
        mask: coverage of the casters [h, w].
        begin: an offset and a standard deviation that are nearly right; None to look for these. If what the fit begins
            with explains hardly more than nothing, no shadow is returned.
    """
    from scipy.optimize import leastsq  # pictures without a shadow need not load it

    seen, varied = zone.pixels
    energy = float((seen * seen).sum())
    if energy <= 0.0 or not mask.any():
        return None

    places = np.flatnonzero(zone.is_seen)
    step = -(-len(places) // SOFTNESS.samples)
    few, few_varied = seen[::step], None if varied is None else varied[::step]

    def residual(values: Floats) -> Floats:
        own = moved_blur(mask, (values[0], values[1]), float(np.exp(values[2]))).ravel()[places[::step]]
        left: Floats = (few - explained(own, few, few_varied)).ravel()
        return left

    starts = _starts(zone, mask) if begin is None else [(begin[0], begin[1], float(np.log(begin[2])))]
    losses = [float((residual(np.array(start)) ** 2).sum()) for start in starts]
    if zone.unexplained(step * min(losses)) > SOFTNESS.start_unexplained:
        return None
    best, most = np.array(starts[int(np.argmin(losses))]), np.array([SOFTNESS.offset_max] * 2 + [0.0])
    low, high = np.log(0.25) - most, np.log(SOFTNESS.sigma_max) + most
    found = leastsq(
        lambda values: residual(np.clip(values, low, high)),
        best,
        epsfcn=1e-6,
        ftol=SOFTNESS.fitted,
        diag=(1.0, 1.0, 5.0),
    )
    values = np.clip(found[0], low, high)
    offset, sigma = (float(values[0]), float(values[1])), float(np.exp(values[2]))
    own = moved_blur(mask, offset, sigma)[zone.is_seen]
    error = float(((seen - explained(own, seen, varied)) ** 2).sum())
    return FoundShadow(offset, sigma, *amplitude_of(own, seen, varied), zone.unexplained(error))


def _starts(zone: Zone, mask: Floats) -> list[tuple[float, float, float]]:
    """Return offsets and logarithms of standard deviations to begin with: no offset, and half of what one sees."""
    weight = np.abs(zone.change).sum(2) * zone.is_seen
    y, x = np.indices(mask.shape)
    lean = [float((weight * axis).sum() / weight.sum() - (mask * axis).sum() / mask.sum()) for axis in (x, y)]
    return rough_starts(((0.0, 0.0), (0.5 * lean[0], 0.5 * lean[1])))


def rough_starts(places: tuple[tuple[float, float], ...]) -> list[tuple[float, float, float]]:
    """Return each of some offsets with the logarithm of each standard deviation to begin with."""
    return [(dx, dy, float(np.log(sigma))) for sigma in _SIGMAS for dx, dy in places]
