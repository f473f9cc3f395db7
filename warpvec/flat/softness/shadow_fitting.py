"""Fit a shadow to a picture: the offset, the blur and the amplitude with which a mask explains what is seen."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.softness import SOFTNESS

_SIGMAS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Standard deviations from which the fit begins, each a factor of two apart."""


FoundShadow = tuple[tuple[float, float], float, Floats, float]
"""Offset, standard deviation, amplitude [C] and the unexplained share of the energy of a shadow."""


def shade_of(cast: Floats, found: FoundShadow) -> Floats:
    """Return what a shadow adds to the ground [h, w, C], in levels."""
    offset, sigma, amplitude, _ = found
    shade: Floats = moved_blur(cast, offset, sigma)[..., None] * amplitude
    return shade


def moved_blur(mask: Floats, offset: tuple[float, float], sigma: float) -> Floats:
    """Return ``mask`` [h, w] moved and blurred; at the border of the picture it goes on as it is there."""
    moved = ndimage.shift(mask, (offset[1], offset[0]), order=3, mode="nearest") if any(offset) else mask
    blurred: Floats = ndimage.gaussian_filter(moved, sigma, mode="nearest", truncate=3.5)
    return blurred


def amplitude_of(strength: Floats, seen: Floats) -> Floats:
    """Return the amplitude [C] with which a ``strength`` [K] explains the changes ``seen`` [K, C] best."""
    found: Floats = strength @ seen / max(float(strength @ strength), 1e-12)
    return found


def fit_shadow(change: Floats, mask: Floats, is_seen: Mask, rough: FoundShadow | None) -> FoundShadow | None:
    """Return the shadow that `_fit` finds in a small copy, or from a ``rough`` one on in the picture itself.

    It is None if the small copy shows that there is none, or none that is as near and as sharp as shadows are.
    """
    if rough is not None:
        (dx, dy), sigma, _, _ = rough
        return _fit(change, mask, is_seen, (dx, dy, sigma))
    step = -(-max(mask.shape) // SOFTNESS.coarse_side)
    if step == 1:
        return _fit(change, mask, is_seen)
    small = [reduced(each, step) for each in (change, mask, is_seen.astype(np.float64))]
    coarse = _fit(small[0], small[1], small[2] == 1.0)
    if coarse is None or coarse[3] > SOFTNESS.coarse_unexplained:
        return None
    (dx, dy), sigma, amplitude, unexplained = coarse
    if step * max(abs(dx), abs(dy)) > SOFTNESS.offset_max or step * sigma > SOFTNESS.sigma_max:
        return None
    return (step * dx, step * dy), step * sigma, amplitude, unexplained


def reduced(values: Floats, step: int) -> Floats:
    """Return the means [h // step, w // step, ...] of blocks of ``step`` x ``step`` pixels."""
    height, width = (size // step for size in values.shape[:2])
    blocks = values[: height * step, : width * step].reshape(height, step, width, step, *values.shape[2:])
    means: Floats = blocks.mean((1, 3))
    return means


def _fit(
    change: Floats, mask: Floats, is_seen: Mask, begin: tuple[float, float, float] | None = None
) -> FoundShadow | None:
    """Return offset, standard deviation, amplitude [C] and the unexplained share of the energy of a shadow.

    Args:
        change: the picture minus its ground, in levels [h, w, C].
        mask: coverage of the casters [h, w].
        is_seen: where nothing covers the shadow [h, w].
        begin: an offset and a standard deviation that are nearly right; None to look for these. If they explain
            hardly more than nothing, no shadow is returned.
    """
    from scipy.optimize import least_squares  # pictures without a shadow need not load it

    seen = change[is_seen]
    energy = float((seen * seen).sum())
    if energy <= 0.0 or not mask.any():
        return None

    def residual(values: Floats) -> Floats:
        own = moved_blur(mask, (values[0], values[1]), float(np.exp(values[2])))[is_seen]
        left: Floats = (seen - own[:, None] * amplitude_of(own, seen)).ravel()
        return left

    starts = _starts(change, mask, is_seen) if begin is None else [(begin[0], begin[1], float(np.log(begin[2])))]
    losses = [float((residual(np.array(start)) ** 2).sum()) for start in starts]
    if begin is not None and losses[0] > SOFTNESS.begin_unexplained * energy:
        return None
    best, most = np.array(starts[int(np.argmin(losses))]), SOFTNESS.offset_max
    bounds = ([-most, -most, np.log(0.25)], [most, most, np.log(SOFTNESS.sigma_max)])
    best = np.clip(best, np.array(bounds[0]) + 1e-3, np.array(bounds[1]) - 1e-3)
    found = least_squares(residual, best, bounds=bounds, x_scale=(1.0, 1.0, 0.2), diff_step=1e-3, max_nfev=30)
    shade = moved_blur(mask, (found.x[0], found.x[1]), float(np.exp(found.x[2])))
    offset, sigma = (float(found.x[0]), float(found.x[1])), float(np.exp(found.x[2]))
    return offset, sigma, amplitude_of(shade[is_seen], seen), float(2.0 * found.cost) / energy


def _starts(change: Floats, mask: Floats, is_seen: Mask) -> list[tuple[float, float, float]]:
    """Return offsets and logarithms of standard deviations to begin with: no offset, and half of what one sees."""
    weight = np.abs(change).sum(2) * is_seen
    y, x = np.indices(mask.shape)
    lean = [float((weight * axis).sum() / weight.sum() - (mask * axis).sum() / mask.sum()) for axis in (x, y)]
    places = ((0.0, 0.0), (0.5 * lean[0], 0.5 * lean[1]))
    return [(dx, dy, float(np.log(sigma))) for sigma in _SIGMAS for dx, dy in places]
