"""Find out by which kernel a picture was reduced, from the rims of its edges."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Mask
from warpvec.condition.constants import CONDITION
from warpvec.condition.edge_models import MEANS, REDUCTIONS, fit_edges

RIMMED = ("bicubic", "lanczos")
"""The kernels of `REDUCTIONS` that leave rims at edges."""


def find_reduction(levels: Floats) -> str | None:
    """Return the kernel in ``RIMMED`` that the picture ``levels`` [h, w, C] in [0, 255] was surely reduced with.

    It is None if edges do not tell, or if they have no rims. A transparent picture shows its rims in premultiplied
    colours and alpha.
    """
    patches = _patches(levels)
    if len(patches) < CONDITION.patches_min or _most_are_plain(levels) or not _may_be_rimmed(patches):
        return None
    fits = fit_edges(patches, REDUCTIONS)
    rest = np.stack([fit.rest for fit in fits.values()])
    is_edge = (rest.min(0) < CONDITION.edge_rest_max) & (fits["lanczos"].step > CONDITION.step_min)
    if _different_count(patches[is_edge]) < CONDITION.patches_min:
        return None
    kept = np.minimum(rest[:, is_edge], 2.0 * CONDITION.edge_rest_max)
    score = dict(zip(fits, np.sqrt((kept**2).mean(1)).tolist(), strict=True))
    best = min(score, key=lambda name: score[name])
    plain = min(score[name] for name in score if name not in RIMMED)
    is_better = score[best] <= CONDITION.reduction_share_max * plain
    return best if is_better and _most_are_rimmed(dict(zip(fits, kept, strict=True))) else None


def _different_count(patches: Floats) -> int:
    """Return how many of the ``patches`` [N, side, side] differ: equal edges of a drawing on whole pixels tell once."""
    return len(np.unique(np.rint(patches).reshape(len(patches), patches[0].size), axis=0)) if len(patches) else 0


def _most_are_rimmed(kept: dict[str, Floats]) -> bool:
    """Return whether most edges that tell have rims: a reduction leaves them at all, and a line looks like a rim.

    Args:
        kept: what each kernel leaves unexplained of each edge [N].
    """
    rimmed, plain = (
        np.min([rest for name, rest in kept.items() if (name in RIMMED) == has_rims], axis=0)
        for has_rims in (True, False)
    )
    has_rim, has_none = rimmed < CONDITION.edge_share_max * plain, plain < CONDITION.edge_share_max * rimmed
    return bool(has_none.sum() <= CONDITION.rimless_edges_max * (has_rim | has_none).sum())


def _most_are_plain(levels: Floats) -> bool:
    """Return whether even areas in ``levels`` [h, w, C] keep their colour up to most of their edges.

    A kernel with negative weights leaves rims beside each edge, unless they were cut off at black or white. Thin lines,
    which are drawn beside many edges, say nothing: they are stronger than rims, or go the other way.
    """
    plain_count = rimmed_count = 0
    for part in (levels, levels.swapaxes(0, 1)):
        count = part.shape[1] - 5
        y, x, channel = np.nonzero(np.abs(part[:, 5:] - part[:, :count]) >= CONDITION.patch_slope_min)
        row = [part[y, x + k, channel] for k in range(6)]
        for far, *near, before, last in (row, row[::-1]):
            step = last - far
            size = np.abs(step)
            # A rim goes away from the other side.
            room = np.where(step > 0, far, 255.0 - far)
            is_edge = (np.abs(before - near[2]) >= 0.2 * size) & (np.abs(near[0] - far) <= 1.0)
            is_edge &= room >= CONDITION.rim_max * size
            beyond = np.stack([-np.sign(step) * (each - far) for each in near[1:]])
            is_plain = is_edge & (np.abs(beyond) <= 1.0).all(0)
            is_rimmed = is_edge & (beyond[1] > 1.0) & (beyond[1] <= CONDITION.rim_max * size)
            plain_count += int(is_plain.sum())
            rimmed_count += int(is_rimmed.sum())
    return plain_count >= CONDITION.patches_min and plain_count > rimmed_count


def _may_be_rimmed(patches: Floats) -> bool:
    """Return whether edges with rims explain a few of the ``patches`` [N, side, side] better than edges without."""
    few = patches[:: -(-len(patches) // CONDITION.patches_few)]
    rest = np.stack([fit.rest for fit in fit_edges(few, (RIMMED[0], MEANS)).values()])
    rest = rest[:, rest.min(0) < CONDITION.edge_rest_max].clip(0.0, 2.0 * CONDITION.edge_rest_max)
    rimmed, plain = (rest**2).sum(1)
    return bool(rimmed < CONDITION.reduction_share_max**2 * plain)


def _patches(levels: Floats) -> Floats:
    """Return squares [N, side, side] around pixels at which a channel of ``levels`` is steepest."""
    reach, found = CONDITION.patch_reach, list[Floats]()
    if min(levels.shape[:2]) <= 2 * reach + 2:
        return np.zeros((0, 2 * reach + 1, 2 * reach + 1))
    for channel in np.moveaxis(levels, 2, 0):
        windows = np.lib.stride_tricks.sliding_window_view(channel, (2 * reach + 1, 2 * reach + 1))
        found.append(windows[_is_steepest(channel)[reach:-reach, reach:-reach]])
    patches = np.concatenate(found).astype(np.float64)
    chosen = np.linspace(0, len(patches) - 1, CONDITION.patches_max).astype(np.int64)
    return patches if len(patches) <= CONDITION.patches_max else patches[chosen]


def _is_steepest(channel: Floats) -> Mask:
    """Return whether each pixel [h, w] of ``channel`` is at least as steep as its neighbours across the edge."""
    across, down = np.zeros_like(channel), np.zeros_like(channel)
    across[:, 1:-1], down[1:-1] = channel[:, 2:] - channel[:, :-2], channel[2:] - channel[:-2]
    # The slope itself, which takes longer, is found where it may be large enough.
    y, x = np.nonzero(across * across + down * down > 0.99 * CONDITION.patch_slope_min**2)
    slope = np.hypot(across[y, x], down[y, x])
    is_steep = slope > CONDITION.patch_slope_min
    y, x, slope = y[is_steep], x[is_steep], slope[is_steep]
    angle = np.arctan2(down[y, x], across[y, x])
    right, below = np.rint(np.cos(angle)).astype(np.int64), np.rint(np.sin(angle)).astype(np.int64)
    across, down = np.pad(across, 1), np.pad(down, 1)
    ahead, behind = (
        np.hypot(across[rows, columns], down[rows, columns])
        for rows, columns in ((y + 1 + below, x + 1 + right), (y + 1 - below, x + 1 - right))
    )
    result = np.zeros(channel.shape, bool)
    result[y, x] = (slope >= ahead) & (slope > behind)
    return result
