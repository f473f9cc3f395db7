"""Fill in what lies below marks: the ground goes on from both sides, in the direction in which these agree best.

Along an edge, or a line, the picture looks the same before a letter and behind it. So each pixel of a mark is filled in
from the two nearest pixels of the ground in one direction. Both sides must have the same profile across it, and the
pixel must be a mix of the ink and what is filled in.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats32, Mask, Places
from warpvec.flat.constants.overlay import OVERLAY


class _Side(NamedTuple):
    """What lies beside n pixels in each of D directions.

    Attributes:
        distance: pixels to the ground [n, D]; infinite if none is in reach.
        profile: colours across the direction there [n, D, P, C].
        is_known: which of these are colours of the ground [n, D, P].
    """

    distance: Floats32
    profile: Floats32
    is_known: Mask

    @property
    def color(self) -> Floats32:
        """The colour of the ground there [n, D, C]."""
        return self.profile[:, :, self.profile.shape[2] // 2]


def filled(picture: Floats32, hidden: Mask, ink: Floats32) -> Floats32:
    """Return ``picture`` [h, w, C] with what lies below marks of one ``ink`` [C] in the ``hidden`` pixels [h, w]."""
    places = _places_of(hidden)
    sides = _side(picture, hidden, places, 1.0), _side(picture, hidden, places, -1.0)
    near, far = (np.where(np.isfinite(side.distance), side.distance, 1.0) for side in sides)
    share = (far / (near + far))[..., None]
    color = share * sides[0].color + (1.0 - share) * sides[1].color
    pixels = picture[places][:, None]
    part = ink_share(pixels, color, ink)[..., None]
    unexplained = np.square(pixels - color - part * (ink - color)).sum(-1)
    cost = _disagreement(*sides) + OVERLAY.ink_cost * unexplained
    chosen = _with_neighbors(cost, hidden, places).argmin(1)
    result = picture.copy()
    result[places] = color[np.arange(len(chosen)), chosen]
    return result


def _places_of(mask: Mask) -> tuple[Places, Places]:
    rows, columns = np.nonzero(mask)
    return rows, columns


def ink_share(pixels: Floats32, ground: Floats32, ink: Floats32) -> Floats32:
    """Return the share [...] of the ``ink`` [C] in ``pixels`` [..., C] on a ``ground`` [..., C]."""
    full = ink - ground
    length = np.square(full).sum(-1)
    share = ((pixels - ground) * full).sum(-1) / np.maximum(length, 1e-3)
    return np.clip(share, 0.0, 1.0).astype(np.float32)


def _directions() -> tuple[Floats32, Floats32]:
    angles = np.pi * np.arange(OVERLAY.directions, dtype=np.float32) / OVERLAY.directions
    return np.cos(angles), np.sin(angles)


def _side(picture: Floats32, hidden: Mask, places: tuple[Places, Places], way: float) -> _Side:
    """Return what lies beside the pixels at ``places`` one ``way``, 1 or -1, along each direction."""
    x_step, y_step = (way * step for step in _directions())
    rows, columns = (place.astype(np.float32)[:, None] for place in places)
    known = (~hidden).astype(np.float32)
    distance = np.full((len(rows), OVERLAY.directions), np.inf, np.float32)
    for step in np.arange(1.0, OVERLAY.reach + OVERLAY.step, OVERLAY.step):
        is_shown = _sampled(known, rows + step * y_step, columns + step * x_step) > 0.999
        distance[is_shown & np.isinf(distance)] = step
    reached = np.where(np.isfinite(distance), distance, 0.0)
    count = len(OVERLAY.profile)
    across = np.arange(count, dtype=np.float32) - count // 2
    y = (rows + reached * y_step)[..., None] + across * (way * x_step)[:, None]
    x = (columns + reached * x_step)[..., None] - across * (way * y_step)[:, None]
    weight = _sampled(known, y, x)
    channels = [_sampled(known * picture[..., channel], y, x) for channel in range(picture.shape[-1])]
    profile = (np.stack(channels, -1) / np.maximum(weight, 1e-6)[..., None]).astype(np.float32)
    return _Side(distance, profile, (weight > 0.5) & np.isfinite(distance)[..., None])


def _sampled(values: Floats32, y: Floats32, x: Floats32) -> Floats32:
    """Return ``values`` [h, w] between pixels, and 0 beyond the picture."""
    found = ndimage.map_coordinates(values, [y.ravel(), x.ravel()], order=1, mode="constant", prefilter=False)
    return found.reshape(y.shape)


def _disagreement(first: _Side, second: _Side) -> Floats32:
    """Return how much both sides disagree in each direction [n, D], less what their profiles show."""
    weights = np.array(OVERLAY.profile, np.float32) * (first.is_known & second.is_known)
    total = np.maximum(weights.sum(-1), 1e-6)
    apart = (np.square(first.profile - second.profile).sum(-1) * weights).sum(-1) / total
    shown = np.minimum(*(_spread(side.profile, weights, total) for side in (first, second)))
    length = np.square(first.distance + second.distance)
    is_open = np.isfinite(length) & (total >= max(OVERLAY.profile))
    cost = apart - OVERLAY.structure_worth * shown + OVERLAY.length_cost * np.where(is_open, length, 0.0)
    return np.where(is_open, cost, np.float32(1e3))


def _spread(profile: Floats32, weights: Floats32, total: Floats32) -> Floats32:
    """Return the variance [n, D] of the colours of each ``profile`` [n, D, P, C]."""
    mean = (profile * weights[..., None]).sum(2) / total[..., None]
    return (np.square(profile - mean[:, :, None]).sum(-1) * weights).sum(-1) / total


def _with_neighbors(cost: Floats32, hidden: Mask, places: tuple[Places, Places]) -> Floats32:
    """Return the mean of the ``cost`` [n, D] of each hidden pixel and those of its neighbours."""
    number = np.full(np.add(hidden.shape, 2), -1, np.int64)
    number[1:-1, 1:-1][places] = np.arange(len(cost))
    total, weight = cost.copy(), np.ones((len(cost), 1), np.float32)
    for down, right in ((a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b):
        other = number[places[0] + 1 + down, places[1] + 1 + right]
        total[other >= 0] += OVERLAY.neighbor_weight * cost[other[other >= 0]]
        weight[other >= 0] += OVERLAY.neighbor_weight
    return total / weight
