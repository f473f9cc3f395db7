"""Find a soft spot on the flat ground of a picture: a blurred ellipse, such as the shadow below a figure, or a glow.

No shape of the drawing casts it, so its own form is fitted: centre, radii, turn and blur, by Gauss-Newton steps in a
small copy. The amplitude follows by least squares.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.shadow_fitting import FoundShadow, Zone, amplitude_of, explained
from warpvec.image.spread import largest_channel


def find_spot(zone: Zone) -> tuple[Floats, Floats, FoundShadow] | None:
    """Return an ellipse, by parameters [6] and coverage [h, w], and its look; None if the ``zone`` shows no spot."""
    rough = _fitted(zone, SOFTNESS.coarse_side // 2, None)
    if rough is None or rough[2] > SOFTNESS.coarse_unexplained:
        return None
    found = _fitted(zone, SOFTNESS.coarse_side, rough[0])
    if found is None or found[2] > SOFTNESS.unexplained:
        return None
    values, look, unexplained = found
    sharp, sigma = _ellipse(values, *zone.is_seen.shape), float(np.exp(values[5]))
    if sharp[zone.is_seen].sum() < SOFTNESS.spot_seen * sharp.sum():
        return None
    form = np.array([*values[:2], *np.exp(values[2:4]), values[4], 0.0])
    return form, sharp, FoundShadow((0.0, 0.0), sigma, *look, unexplained)


def _fitted(zone: Zone, side: int, rough: Floats | None) -> tuple[Floats, tuple[Floats, float], float] | None:
    """Return what `_fit` does in a copy of a ``side`` in pixels, from a ``rough`` ellipse [6] on or anew.

    Ellipses are in pixels of the picture. None if nothing lies on the ground.
    """
    step = -(-max(zone.is_seen.shape) // side)
    small = zone.reduced(step)
    is_changed = largest_channel(np.abs(small.change)) > SOFTNESS.alike
    if (small.is_seen & is_changed).sum() * step * step < SOFTNESS.zone_area:
        return None
    scale, grown = np.array([step, step, 1.0, 1.0, 1.0, 1.0]), np.log(step) * np.array([0.0, 0.0, 1.0, 1.0, 0.0, 1.0])
    starts = _starts(small) if rough is None else [(rough - grown) / scale]
    values, look, unexplained = min(
        (_fit(small, start, SOFTNESS.sigma_max / step) for start in starts), key=lambda each: each[2]
    )
    return values * scale + grown, look, unexplained


def _starts(zone: Zone) -> list[Floats]:
    """Return ellipses to begin with [6], from the moments of what is seen."""
    weight = np.abs(zone.change).sum(2) * zone.is_seen
    y, x = (axis[weight > 0.0] + 0.5 for axis in np.indices(weight.shape))
    share = weight[weight > 0.0] / weight.sum()
    middle = np.array([share @ x, share @ y])
    away = np.stack([x, y]) - middle[:, None]
    spreads, axes = np.linalg.eigh((share * away) @ away.T)
    radii = 2.0 * np.sqrt(np.maximum(spreads[::-1], 1.0))  # of an evenly filled ellipse
    turn = float(np.arctan2(axes[1, 1], axes[0, 1]))
    return [np.array([*middle, *np.log(radii), turn, np.log(blur * radii[1])]) for blur in SOFTNESS.spot_blurs]


def _fit(zone: Zone, start: Floats, sigma_max: float) -> tuple[Floats, tuple[Floats, float], float]:
    """Return the ellipse [6] that fits best from ``start`` on, its amplitude and opacity, and the unexplained share."""
    from scipy.optimize import least_squares  # pictures without a soft spot need not load it

    (seen, varied), (height, width) = zone.pixels, zone.is_seen.shape

    def residual(values: Floats) -> Floats:
        own = _blurred(values, height, width)[zone.is_seen]
        left: Floats = (seen - explained(own, seen, varied)).ravel()
        return left

    side = max(height, width)
    low = np.array([-side, -side, 0.0, 0.0, -10.0, np.log(0.25)])
    high = np.array([2 * side, 2 * side, np.log(2 * side), np.log(2 * side), 10.0, np.log(sigma_max)])
    begin = np.clip(start, low + 1e-3, high - 1e-3)
    scale, settled = (1.0, 1.0, 0.05, 0.05, 0.05, 0.1), SOFTNESS.fitted
    found = least_squares(residual, begin, bounds=(low, high), x_scale=scale, diff_step=1e-3, ftol=settled)
    own = _blurred(found.x, height, width)[zone.is_seen]
    return found.x, amplitude_of(own, seen, varied), float(2.0 * found.cost) / max(float((seen * seen).sum()), 1e-12)


def _blurred(values: Floats, height: int, width: int) -> Floats:
    blurred: Floats = ndimage.gaussian_filter(_ellipse(values, height, width), np.exp(values[5]), truncate=3.5)
    return blurred


def _ellipse(values: Floats, height: int, width: int) -> Floats:
    """Return how much of each pixel an ellipse covers [h, w], by its distance to first order.

    Args:
        values: the centre x, y of the ellipse, the logarithms of its two radii, its turn, and the logarithm of a blur
            [6]. The blur does not count here.
    """
    y, x = np.indices((height, width)) + 0.5
    dx, dy, cos, sin = x - values[0], y - values[1], np.cos(values[4]), np.sin(values[4])
    a, b = np.exp(values[2:4])
    u, v = (cos * dx + sin * dy) / a, (cos * dy - sin * dx) / b
    level = u * u + v * v - 1.0
    slope = 2.0 * np.hypot(u / a, v / b)
    cover: Floats = np.clip(0.5 - level / np.maximum(slope, 1e-12), 0.0, 1.0)
    return cover
