"""Parts too thin for a pure pixel: found where no mix of the regions around explains the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats32, Mask, Places
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment, colors_of, unmix
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paint_fitting import flat_paints
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import connected_areas, pixels_of
from warpvec.flat.regions.specks import SpeckLimits
from warpvec.flat.regions.unmixing import pair_shares, triple_shares
from warpvec.geometry.paints.registry import FLAT
from warpvec.watch.watch import UNWATCHED, Watch


@dataclass(frozen=True, eq=False)
class _Shares:
    """Shares of M paints in N pixels [N, M], and what is left [N, M]: of the best mix, and of that of all three."""

    share: Floats32
    rest: Floats32
    third: Floats32
    third_rest: Floats32


def add_thin_parts(
    picture: Floats32, assignment: Assignment, paints: Paints, tolerances: Tolerances, limits: SpeckLimits,
    canvas: int | None, watch: Watch = UNWATCHED,
) -> Paints:  # fmt: skip
    """Add regions for what ``assignment`` does not explain, until the ``watch`` is over, and return all paints."""
    given_up = np.zeros(assignment.label.shape, bool)
    for _ in range(REGIONS.thin_rounds_max):
        areas = connected_areas((assignment.residual > tolerances.mix) & ~given_up, diagonal=True)
        new = np.zeros(areas.shape, bool)
        for pixels in pixels_of(areas):
            if watch.is_over():
                return paints
            rows, columns = np.divmod(pixels, areas.shape[1])
            found = _explain(rows, columns, picture, assignment, paints, tolerances, limits)
            if found is None:
                # What else the area shows may be explained without its worst pixels.
                residual = assignment.residual[rows, columns]
                worst = residual >= REGIONS.top_residual * residual.max()
                given_up[rows[worst], columns[worst]] = True
                continue
            paint, is_anchor = found
            assignment.anchors[rows[is_anchor], columns[is_anchor]] = len(paints)
            new[rows[is_anchor], columns[is_anchor]] = True
            paints = paints.joined(paint)
        if areas.max() < 0:
            break
        is_near = ndimage.maximum_filter(new, 2 * tolerances.reach + 1)
        unmix(assignment, is_near & ~assignment.is_pure, picture, paints, tolerances, canvas)
    unexplained = assignment.residual > tolerances.mix
    unmix(assignment, unexplained, picture, paints, tolerances, canvas, wider=True)
    return paints


def _explain(
    rows: Places, columns: Places, picture: Floats32, assignment: Assignment, paints: Paints,
    tolerances: Tolerances, limits: SpeckLimits,
) -> tuple[Paints, Mask] | None:  # fmt: skip
    """Return the paint of an unexplained area and the pixels of it that belong to it, or None for a speck."""
    residual = assignment.residual[rows, columns]
    if len(rows) < 2 or residual.max() < REGIONS.thin_strength * tolerances.mix:
        return None
    few = slice(None, None, -(-len(rows) // REGIONS.thin_samples_max))
    color = picture[rows[few], columns[few]]
    known, own = _known_colors(paints), _own_colors(color, residual[few])
    values, metric = np.concatenate([known, own]), tolerances.thin_metric()
    shares = _shares_of(values, rows[few], columns[few], picture, assignment, paints, metric)
    if _is_seam(shares, len(known), rows[few], columns[few], picture, assignment, paints, tolerances):
        return None
    value = values[_best_paint(values, len(known), shares, color, len(rows), tolerances)]
    chosen = _shares_of(value[None], rows, columns, picture, assignment, paints, metric)
    share, rest = chosen.share[:, 0], chosen.rest[:, 0]
    is_anchor = (share >= REGIONS.anchor_share) & (rest <= np.maximum(0.5 * residual, tolerances.mix))
    least = limits.clear_area if residual.max() >= REGIONS.clear_contrast else limits.area
    return (_paint_of(value), is_anchor) if share[is_anchor].sum() >= least else None


def _own_colors(color: Floats32, residual: Floats32) -> Floats32:
    """Return colours [C, 4] of an area's pixels [N, 4] that it may be drawn in, the most likely one first.

    The median of the pixels that are explained worst comes first. An area of several colours may have others.
    """
    worst = np.median(color[residual >= REGIONS.top_residual * residual.max()], 0)
    order = np.argsort(-residual, kind="stable")[: max(len(color) // 2, 1)]
    picked = order[np.linspace(0, len(order) - 1, min(REGIONS.own_colors, len(order))).astype(np.intp)]
    return np.concatenate([worst[None], color[picked]]).astype(np.float32)


def _paint_of(value: Floats32) -> Paints:
    color = value[:3] / max(float(value[3]), 1.0e-6)
    return flat_paints(np.append(np.clip(color, 0, 1), value[3])[None].astype(np.float32))


def _known_colors(paints: Paints) -> Floats32:
    """Return the different premultiplied colours [M, 4] of flat paints."""
    flat = paints.kind == FLAT
    values = paints.premultiplied()[flat]
    return np.unique(values, axis=0)


def _shares_of(
    values: Floats32, rows: Places, columns: Places, picture: Floats32, assignment: Assignment,
    paints: Paints, metric: Floats32,
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
        is_better = left <= rest + REGIONS.pair_gain
        share, rest = np.where(is_better, part, share), np.where(is_better, left, rest)
    return _Shares(share, rest, third, third_rest)


def _is_seam(
    shares: _Shares, known_count: int, rows: Places, columns: Places, picture: Floats32, assignment: Assignment,
    paints: Paints, tolerances: Tolerances,
) -> bool:  # fmt: skip
    """Return whether an area lies between two regions, and what is behind both shines through the seam.

    That is one of the first ``known_count`` paints of the ``shares``, or a ramp that goes on behind both.
    """
    between = assignment.label[rows, columns] != assignment.other[rows, columns]
    if between.mean() < REGIONS.seam_part:
        return False
    if _shines_through(shares.third[:, :known_count], shares.third_rest[:, :known_count], tolerances):
        return True
    third, rest = _ramp_shares(rows, columns, picture, assignment, paints, tolerances)
    return _shines_through(third, rest, tolerances)


def _shines_through(third: Floats32, rest: Floats32, tolerances: Tolerances) -> bool:
    """Return whether one of M paints shines through a seam, by its share of N pixels [N, M] and what is left [N, M]."""
    thin = (rest <= tolerances.mix) & (third <= REGIONS.far_share_max)
    return bool((thin.mean(0) >= REGIONS.seam_part).any())


def _ramp_shares(
    rows: Places, columns: Places, picture: Floats32, assignment: Assignment, paints: Paints, tolerances: Tolerances
) -> tuple[Floats32, Floats32]:
    """Return the shares [N, R] of the R ramps of ``paints`` in N pixels beside their two regions, and what is left."""
    ramps = np.nonzero(paints.kind != FLAT)[0].astype(np.int32)
    label, other = (np.repeat(side[rows, columns], len(ramps)) for side in (assignment.label, assignment.other))
    behind = np.tile(ramps, len(rows))
    candidates = np.stack([behind, label, other], 1).astype(np.int32)
    y, x = (np.repeat(place, len(ramps)).astype(np.int32) for place in (rows, columns))
    color, values = colors_of(candidates, y, x, picture, paints, tolerances.thin_metric())
    three, rest = triple_shares(color, values)
    rest = np.where((three >= 0).all(1), rest, np.inf)
    return three[:, 0].reshape(len(rows), -1), rest.reshape(len(rows), -1)


def _best_paint(
    values: Floats32, known_count: int, shares: _Shares, color: Floats32, size: int, tolerances: Tolerances
) -> int:
    """Return which of ``values`` [M, 4] explains most of an area: a known paint, or else one of its own colours.

    Args:
        values: the known paints and the area's own colours, premultiplied.
        known_count: number of known paints.
        shares: how the values explain pixels of the area.
        color: colours of these pixels [N, 4].
        size: number of all pixels of the area.
        tolerances: those of the picture.
    """
    is_explained = shares.rest <= tolerances.mix
    count = is_explained.sum(0)
    own = known_count + int(count[known_count:].argmax())
    if count[known_count] >= REGIONS.first_color_part * count[own]:
        own = known_count
    metric = tolerances.thin_metric()
    distance = np.abs((values[:known_count] - values[own]) @ metric).max(-1)
    peak = np.quantile(np.where(is_explained, shares.share, 0), 0.9, axis=0)[:known_count]
    is_short = size < (REGIONS.noisy_plateau_area if tolerances.noise > 0 else REGIONS.plateau_area)
    possible = (count[:known_count] >= REGIONS.known_paint_part * count[own]) & (
        (peak >= REGIONS.peak_share_min) | is_short
    )
    at_own = (np.abs((color - values[own]) @ metric).max(-1) <= tolerances.paint).mean()
    if at_own >= REGIONS.plateau_share and not is_short:
        possible &= distance <= 2 * tolerances.pool
    return int(np.where(possible, distance, np.inf).argmin()) if possible.any() else own
