"""Parts too thin for a pure pixel: found where no mix of the regions around explains the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.assignment import Assignment, unmix
from warpvec.flat.denoising import Tolerances
from warpvec.flat.paint_fitting import flat_paints
from warpvec.flat.paints import Paints
from warpvec.flat.region_growing import NONE, connected_areas
from warpvec.flat.unmixing import FAR_SHARE_MAX, RADIUS, triple_shares

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

ANCHOR_SHARE = 0.45
"""Share of a new region from which a pixel belongs to it: a bit below one half keeps lines of one pixel in one piece
where they lie between two pixels."""

SEAM_PART = 0.8
"""Part of the pixels of an area that must look like a seam of two regions."""

STRENGTH = 2.0
"""An area is looked at if a pixel in it is unexplained by this multiple of the tolerance."""


def add_thin_parts(
    picture: Floats, assignment: Assignment, paints: Paints, tolerances: Tolerances, min_area: float, canvas: int | None
) -> Paints:
    """Add regions for what ``assignment`` does not explain, and return all paints."""
    given_up = np.zeros(assignment.label.shape, bool)
    for _ in range(ROUNDS_MAX):
        areas = connected_areas((assignment.residual > tolerances.mix) & ~given_up, diagonal=True)
        new = np.zeros(areas.shape, bool)
        for rows, columns in _pixels_of(areas):
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
        unmix(assignment, _grown(new) & ~assignment.is_pure, picture, paints, tolerances, canvas)
    return paints


def _grown(mask: Mask) -> Mask:
    from scipy import ndimage  # type: ignore[import-untyped]

    grown: Mask = ndimage.maximum_filter(mask, 2 * RADIUS + 1)
    return grown


def _pixels_of(areas: Integers) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Return the rows and columns of each of ``areas`` [h, w]."""
    rows, columns = np.nonzero(areas != NONE)
    number = areas[rows, columns]
    order = np.argsort(number, kind="stable")
    stops = np.cumsum(np.bincount(number))[:-1]
    return [(rows[part], columns[part]) for part in np.split(order, stops) if len(part)]


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
    share, rest = _shares_of(values, rows, columns, picture, assignment, paints, tolerances.metric)
    if _is_seam(share, rest, rows, columns, assignment, tolerances):
        return None
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
) -> tuple[Floats, Floats]:  # fmt: skip
    """Return the share of each of ``values`` [M, 4] in N pixels beside their two regions, and the residual [N, M]."""
    x, y = ((place + 0.5).astype(np.float32) for place in (columns, rows))
    color = (picture[rows, columns] @ metric)[:, None] + np.zeros((1, len(values), 1), np.float32)
    new = (values @ metric)[None] + np.zeros((len(rows), 1, 1), np.float32)
    label, other = (
        (paints.at(side[rows, columns], x, y) @ metric)[:, None] for side in (assignment.label, assignment.other)
    )
    triple = np.stack([new, label + 0 * new, other + 0 * new], 2)
    shares, rest = triple_shares(color.reshape(-1, 4), triple.reshape(-1, 3, 4))
    rest = np.where((shares >= 0).all(1), rest, np.inf).reshape(color.shape[:2])
    share = shares[:, 0].reshape(color.shape[:2])
    for side in (label, other):
        difference = new - side
        part = ((color - side) * difference).sum(-1) / np.maximum((difference**2).sum(-1), 1.0e-9)
        part = np.clip(part, 0, 1)
        left = np.sqrt(((color - side - part[..., None] * difference) ** 2).mean(-1))
        is_better = left <= rest + 0.25 / 255
        share, rest = np.where(is_better, part, share), np.where(is_better, left, rest)
    return share.astype(np.float32), rest.astype(np.float32)


def _is_seam(
    share: Floats, rest: Floats, rows: NDArray[np.intp], columns: NDArray[np.intp], assignment: Assignment,
    tolerances: Tolerances,
) -> bool:  # fmt: skip
    """Return whether an area lies between two regions, and what is behind both shines through the seam."""
    between = assignment.label[rows, columns] != assignment.other[rows, columns]
    if between.mean() < SEAM_PART:
        return False
    thin = (rest[:, :-1] <= tolerances.mix) & (share[:, :-1] <= FAR_SHARE_MAX)
    return bool((thin.mean(0) >= SEAM_PART).any())


def _best_paint(values: Floats, share: Floats, rest: Floats, color: Floats, tolerances: Tolerances) -> int:
    """Return which of ``values`` explains an area: a known paint if one does, or else its own colour, the last."""
    own = len(values) - 1
    distance = np.abs((values[:own] - values[own]) @ tolerances.metric).max(-1)
    cost = rest.mean(0)
    peak = np.quantile(share, 0.9, axis=0)
    at_own = (np.abs((color - values[own]) @ tolerances.metric).max(-1) <= tolerances.paint).mean()
    possible = (cost[:own] <= np.maximum(tolerances.mix, 1.2 * cost[own])) & (peak[:own] >= PEAK_SHARE_MIN)
    if at_own >= PLATEAU_SHARE:
        possible &= distance <= 2 * tolerances.pool
    if not possible.any():
        return own
    return int(np.where(possible, distance, np.inf).argmin())
