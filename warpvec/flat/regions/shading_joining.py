"""Join areas that touch each other and that one gradient shows.

An area that follows the shading of a gradient ends at a stop, where the colours bend.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Integers32, Mask, Places
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.ramp_directions import directions_of, refined, unevenness
from warpvec.flat.regions.region_growing import NONE, pixels_of, points_of, without_small
from warpvec.watch.watch import UNWATCHED, Watch

Pair = tuple[int, int]
"""Two areas, the smaller number first."""


def join_shading(labels: Integers32, image: Floats32, watch: Watch = UNWATCHED) -> Integers32:
    """Return the areas ``labels`` [h, w] of ``image`` [h, w, 4], sRGB with straight alpha, with some joined.

    Only opaque pixels count. Those with the longest border are tried first. When the ``watch`` is over, the others
    stay apart.
    """
    labels, width = labels.copy(), labels.shape[1]
    colors, areas = image.reshape(-1, 4), dict(enumerate(pixels_of(labels)))
    opaque = np.where(image[..., 3] == 1, labels, NONE)
    borders, tried = _borders(opaque, image), set[Pair]()
    while not watch.is_over():
        left = {pair: size for pair, size in borders.items() if pair not in tried}
        if not left:
            break
        kept, gone = max(left, key=lambda pair: (left[pair], -pair[0], -pair[1]))
        tried.add((kept, gone))
        union = np.concatenate([areas[kept], areas[gone]])
        if _error_of(union, colors, width) > REGIONS.shading_rest:
            continue
        areas[kept] = union
        labels.reshape(-1)[areas.pop(gone)] = kept
        opaque[opaque == gone] = kept
        borders = _borders(opaque, image)
        tried = {pair for pair in tried if not set(pair) & {kept, gone}}
    return without_small(labels, 1)


def _error_of(pixels: Places, colors: Floats32, width: int) -> float:
    """Return the root mean square that the best ramp leaves of the ``colors`` [h w, 4] of ``pixels``."""
    points, shown = points_of(pixels, width), colors[pixels].astype(np.float64)
    directions = directions_of(points, shown)
    return min((unevenness(refined(each, points, shown), points, shown) for each in directions), default=np.inf)


def _borders(labels: Integers32, image: Floats32) -> dict[Pair, int]:
    """Return the length in pixels of the border of each two areas between which the shading mostly goes on."""
    count, found = max(int(labels.max()) + 1, 1), []
    for axis in (0, 1):
        along = np.moveaxis(labels, axis, 0)
        first, second = along[1:-2], along[2:-1]
        is_border = (first != second) & (np.minimum(first, second) != NONE)
        is_border &= (along[:-3] == first) & (along[3:] == second)
        goes_on = _goes_on(np.diff(np.moveaxis(image, axis, 0), axis=0))
        keys = np.minimum(first, second)[is_border].astype(np.int64) * count + np.maximum(first, second)[is_border]
        found.append(np.stack([keys, goes_on[is_border]], 1))
    all_keys, is_smooth = np.concatenate(found).T
    keys, index, sizes = np.unique(all_keys, return_inverse=True, return_counts=True)
    chosen = np.bincount(index, is_smooth, len(keys)) >= REGIONS.shading_part * sizes
    return {divmod(key, count): size for key, size in zip(keys[chosen].tolist(), sizes[chosen].tolist(), strict=True)}


def _goes_on(steps: Floats32) -> Mask:
    """Return where each of the ``steps`` [n, m, D] between those before and behind is about between these two."""
    low, high = np.minimum(steps[:-2], steps[2:]), np.maximum(steps[:-2], steps[2:])
    off = np.maximum(low - steps[1:-1], steps[1:-1] - high)
    return np.asarray(off.max(2) <= REGIONS.surface_difference)
