"""Fit a ground of a gradient along a line that is shaded nearly everywhere: it and its shadow at once.

So is the page around a card that fills most of a screenshot: the shadow of the card goes on up to the border, and there
is no place from which the gradient could be measured alone.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.shadow_fitting import moved_blur, reduced, rough_starts


def fit_shaded_ground(levels: Floats, area: Mask, casters: Mask) -> Floats | None:
    """Return the colour of the ground at each pixel [h, w, C]; None if no shadow on a gradient explains the area.

    Args:
        levels: the picture [h, w, C].
        area: where the ground with the shadow is seen [h, w].
        casters: what casts the shadow [h, w].
    """
    from scipy.optimize import least_squares  # pictures without such a ground need not load it

    step = -(-max(area.shape) // SOFTNESS.coarse_side)
    is_seen, mask = reduced(area.astype(np.float64), step) == 1.0, reduced(casters.astype(np.float64), step)
    if is_seen.sum() * step * step < SOFTNESS.zone_area or not mask.any():
        return None
    places = _places(*area.shape)
    own_places = reduced(places, step)[is_seen]
    seen = reduced(levels, step)[is_seen]
    axes = np.linalg.qr(own_places)[0]
    rest = _without(axes, seen)
    energy = float((rest * rest).sum())

    def strength(values: Floats) -> Floats:
        return moved_blur(mask, (values[0], values[1]), float(np.exp(values[2])))[is_seen]

    def residual(values: Floats) -> Floats:
        own = _without(axes, strength(values)[:, None])
        left: Floats = (rest - own * _amplitude(own, rest)).ravel()
        return left

    start = min(rough_starts(((0.0, 0.0),)), key=lambda each: float((residual(np.array(each)) ** 2).sum()))
    most = SOFTNESS.offset_max
    bounds = ([-most, -most, np.log(0.25)], [most, most, np.log(SOFTNESS.sigma_max)])
    found = least_squares(residual, start, bounds=bounds, x_scale=(1.0, 1.0, 0.2), diff_step=1e-3, max_nfev=30)
    own = strength(found.x)
    amplitude = _amplitude(_without(axes, own[:, None]), rest)
    if 2.0 * found.cost > SOFTNESS.shaded_unexplained * energy or np.abs(amplitude).max() < SOFTNESS.amplitude_min:
        return None
    slopes = np.linalg.lstsq(own_places, seen - own[:, None] * amplitude, rcond=None)[0]
    below: Floats = np.clip(places @ slopes, 0.0, 255.0)
    return below


def _places(height: int, width: int) -> Floats:
    """Return one and the coordinates x, y of each pixel [h, w, 3], from -1 to 1."""
    y, x = np.indices((height, width), np.float64)
    return np.stack([np.ones_like(x), 2.0 * x / width - 1.0, 2.0 * y / height - 1.0], 2)


def _without(axes: Floats, values: Floats) -> Floats:
    """Return ``values`` [K, C] without what a gradient along a line explains, given its orthonormal ``axes`` [K, 3]."""
    # Not by BLAS, whose sums depend on the number of threads.
    along = np.einsum("ka,kc->ac", axes, values)
    rest: Floats = values - np.einsum("ka,ac->kc", axes, along)
    return rest


def _amplitude(own: Floats, rest: Floats) -> Floats:
    """Return what a shadow adds to each channel [C], given its strength [K, 1] and what is seen [K, C]."""
    amplitude: Floats = (own * rest).sum(0) / max(float((own * own).sum()), 1e-12)
    return amplitude
