"""Parts too thin for a pure pixel: found where no mix of the regions around explains the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.assignment import Assignment, unmix
from warpvec.flat.denoising import Tolerances
from warpvec.flat.paint_fitting import flat_paints
from warpvec.flat.paints import Paints
from warpvec.flat.region_growing import connected_areas, pixels_of
from warpvec.flat.unmixing import FAR_SHARE_MAX, pair_shares, triple_shares

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]
Mask = NDArray[np.bool_]

ROUNDS_MAX = 4
"""Rounds of new regions. Each explains one colour of an unexplained area; few areas have more."""

TOP_RESIDUAL = 0.8
"""Pixels with more than this part of the largest residual show the purest colour of an area."""

PEAK_SHARE_MIN = 0.6
"""A paint known from elsewhere explains an area only if some pixels show this share of it. Otherwise the area is drawn
in its own paler colour: a line of less than half a pixel's width would be lost."""

PLATEAU_SHARE = 0.3
"""Part of an area's pixels that shows one colour, which then is its own colour and not a mix with a paler one."""

PLATEAU_AREA, NOISY_PLATEAU_AREA = 24, 100
"""Pixels of a line that is drawn in a colour of its own, in clean and noisy pictures; shorter ones are tips."""

ANCHOR_SHARE = 0.45
"""Share of a new region from which a pixel belongs to it: a bit below one half keeps lines of one pixel in one piece
where they lie between two pixels."""

SEAM_PART = 0.8
"""Part of the pixels of an area that must look like a seam of two regions."""

STRENGTH = 2.0
"""An area is looked at if a pixel in it is unexplained by this multiple of the tolerance."""


PAIR_GAIN = 0.25 / 255
"""Residual that a mix of three colours must save over one of two."""


@dataclass(frozen=True, eq=False)
class _Shares:
    """Shares of M paints in N pixels [N, M], and what is left [N, M]: of the best mix, and of that of all three."""

    share: Floats
    rest: Floats
    third: Floats
    third_rest: Floats


def add_thin_parts(
    picture: Floats, assignment: Assignment, paints: Paints, tolerances: Tolerances, min_area: float, canvas: int | None
) -> Paints:
    """Add regions for what ``assignment`` does not explain, and return all paints."""
    given_up = np.zeros(assignment.label.shape, bool)
    for _ in range(ROUNDS_MAX):
        areas = connected_areas((assignment.residual > tolerances.mix) & ~given_up, diagonal=True)
        new = np.zeros(areas.shape, bool)
        for pixels in pixels_of(areas):
            rows, columns = np.divmod(pixels, areas.shape[1])
            found = _explain(rows, columns, picture, assignment, paints, tolerances, min_area)
            if found is None:
                given_up[rows, columns] = True
                continue
            paint, is_anchor = found
            assignment.anchors[rows[is_anchor], columns[is_anchor]] = len(paints)
            new[rows[is_anchor], columns[is_anchor]] = True
            paints = paints.joined(paint)
        if not new.any():
            break
        unmix(assignment, _grown(new, tolerances.reach) & ~assignment.is_pure, picture, paints, tolerances, canvas)
    unexplained = assignment.residual > tolerances.mix
    unmix(assignment, unexplained, picture, paints, tolerances, canvas, wider=True)
    return paints


def _grown(mask: Mask, distance: int) -> Mask:
    from scipy import ndimage  # type: ignore[import-untyped]

    grown: Mask = ndimage.maximum_filter(mask, 2 * distance + 1)
    return grown


def _explain(
    rows: NDArray[np.intp], columns: NDArray[np.intp], picture: Floats, assignment: Assignment, paints: Paints,
    tolerances: Tolerances, min_area: float,
) -> tuple[Paints, Mask] | None:  # fmt: skip
    """Return the paint of an unexplained area and the pixels of it that belong to it, or None for a speck."""
    residual = assignment.residual[rows, columns]
    if len(rows) < 2 or residual.max() < STRENGTH * tolerances.mix:
        return None
    own = np.median(picture[rows, columns][residual >= TOP_RESIDUAL * residual.max()], 0)
    values = np.concatenate([_known_colors(paints), own[None]]).astype(np.float32)
    shares = _shares_of(values, rows, columns, picture, assignment, paints, tolerances.thin_metric())
    if _is_seam(shares, rows, columns, assignment, tolerances):
        return None
    share, rest = shares.share, shares.rest
    index = _best_paint(values, share, rest, picture[rows, columns], tolerances)
    is_anchor = (share[:, index] >= ANCHOR_SHARE) & (rest[:, index] <= np.maximum(0.5 * residual, tolerances.mix))
    if share[is_anchor, index].sum() < min_area:
        return None
    return _paint_of(values[index]), is_anchor


def _paint_of(value: Floats) -> Paints:
    color = value[:3] / max(float(value[3]), 1.0e-6)
    return flat_paints(np.append(np.clip(color, 0, 1), value[3])[None].astype(np.float32))


def _known_colors(paints: Paints) -> Floats:
    """Return the different premultiplied colours [M, 4] of flat paints."""
    flat = paints.kind == 0
    values = np.column_stack([paints.color * paints.opacity[:, None], paints.opacity])[flat]
    return np.unique(values, axis=0)


def _shares_of(
    values: Floats, rows: NDArray[np.intp], columns: NDArray[np.intp], picture: Floats, assignment: Assignment,
    paints: Paints, metric: Floats,
) -> _Shares:  # fmt: skip
    """Return how each of ``values`` [M, 4] explains N pixels beside their one region, or both."""
    x, y = ((place + 0.5).astype(np.float32) for place in (columns, rows))
    shape = (len(rows), len(values), 4)
    color = np.broadcast_to((picture[rows, columns] @ metric)[:, None], shape)
    new = np.broadcast_to((values @ metric)[None], shape)
    sides = [
        np.broadcast_to((paints.at(side[rows, columns], x, y) @ metric)[:, None], shape)
        for side in (assignment.label, assignment.other)
    ]
    three, three_rest = triple_shares(color.reshape(-1, 4), np.stack([new, *sides], 2).reshape(-1, 3, 4))
    third = three[:, 0].reshape(shape[:2])
    third_rest = np.where((three >= 0).all(1), three_rest, np.inf).reshape(shape[:2])
    share, rest = third, third_rest
    for side in sides:
        part, left = pair_shares(color, new, side)
        is_better = left <= rest + PAIR_GAIN
        share, rest = np.where(is_better, part, share), np.where(is_better, left, rest)
    return _Shares(share, rest, third, third_rest)


def _is_seam(
    shares: _Shares, rows: NDArray[np.intp], columns: NDArray[np.intp], assignment: Assignment, tolerances: Tolerances
) -> bool:
    """Return whether an area lies between two regions, and what is behind both shines through the seam."""
    between = assignment.label[rows, columns] != assignment.other[rows, columns]
    if between.mean() < SEAM_PART:
        return False
    thin = (shares.third_rest[:, :-1] <= tolerances.mix) & (shares.third[:, :-1] <= FAR_SHARE_MAX)
    return bool((thin.mean(0) >= SEAM_PART).any())


def _best_paint(values: Floats, share: Floats, rest: Floats, color: Floats, tolerances: Tolerances) -> int:
    """Return which of ``values`` explains an area: a known paint if one does, or else its own colour, the last."""
    own = len(values) - 1
    distance = np.abs((values[:own] - values[own]) @ tolerances.thin_metric()).max(-1)
    cost = rest.mean(0)
    peak = np.quantile(share, 0.9, axis=0)
    at_own = (np.abs((color - values[own]) @ tolerances.thin_metric()).max(-1) <= tolerances.paint).mean()
    is_short = len(color) < (NOISY_PLATEAU_AREA if tolerances.noise > 0 else PLATEAU_AREA)
    possible = (cost[:own] <= np.maximum(tolerances.mix, 1.2 * cost[own])) & (
        (peak[:own] >= PEAK_SHARE_MIN) | (len(color) < PLATEAU_AREA)
    )
    if at_own >= PLATEAU_SHARE and not is_short:
        possible &= distance <= 2 * tolerances.pool
    if not possible.any():
        return own
    return int(np.where(possible, distance, np.inf).argmin())
