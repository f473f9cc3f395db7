"""Areas of one paint become one region, and specks go."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Integers32, Mask, Places
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment, colors_of, unmix
from warpvec.flat.regions.hairlines import keep_hairlines
from warpvec.flat.regions.label_areas import areas_of, most_contact
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE
from warpvec.flat.regions.specks import SpeckLimits, specks_of
from warpvec.flat.regions.unmixing import triple_shares
from warpvec.geometry.paints.registry import FLAT
from warpvec.watch.watch import UNWATCHED, Watch


def small_area(tolerances: Tolerances) -> int:
    """Return the area in pixels below which an area is less certain."""
    return REGIONS.noisy_small_area if tolerances.noise > 0 else REGIONS.small_area


def pool_paints(paints: Paints, area: Places, tolerances: Tolerances) -> Integers32:
    """Return for each of K paints the number of the paint that it is drawn with: that of the largest area alike."""
    values = paints.premultiplied().astype(np.float32)
    seen = values @ tolerances.metric
    pool, shows = paints.first_equal_ramp(), paints.opacity > 0
    leaders, count = np.empty(len(paints), np.int32), 0
    seen_leaders = np.empty((seen.shape[1], len(paints)), np.float32)  # a row a channel: its largest is found faster
    looks = [*zip(map(bytes, seen), shows.tolist(), strict=True)]
    leader_of: dict[tuple[bytes, bool], int] = {}  # most of the thousands of paints of a pattern look the same
    for index in np.argsort(-area, kind="stable").tolist():
        if paints.kind[index] != FLAT:
            continue
        if looks[index] in leader_of:
            pool[index] = leader_of[looks[index]]
            continue
        limit = tolerances.pool * (REGIONS.small_pool if area[index] < REGIONS.small_area else 1)
        distance = np.abs(seen_leaders[:, :count] - seen[index][:, None]).max(0)
        alike = (distance <= limit) & (shows[leaders[:count]] == shows[index])
        if alike.any():
            pool[index] = leaders[int(np.where(alike, distance, np.inf).argmin())]
        else:
            leaders[count], seen_leaders[:, count] = index, seen[index]
            leader_of[looks[index]] = index
            count += 1
    return pool


def merge_regions(
    picture: Floats32, assignment: Assignment, paints: Paints, tolerances: Tolerances, limits: SpeckLimits,
    canvas: int | None, watch: Watch = UNWATCHED,
) -> tuple[Assignment, Paints]:  # fmt: skip
    """Return regions that are connected, no specks by ``limits``, and of other paints than their neighbours.

    Once the ``watch`` is over, only the first holds.
    """
    area = np.bincount(assignment.label.ravel(), minlength=len(paints))
    pool = pool_paints(paints, area, tolerances)
    for part in (assignment.label, assignment.other):
        part[...] = pool[part]
    assignment.anchors[...] = np.append(pool, NONE)[assignment.anchors]
    keep_hairlines(assignment, tolerances.noise > 0)
    for only_new in (True, False):
        if not watch.is_over():
            _drop_redundant(picture, assignment, paints, tolerances, only_new)
    if not watch.is_over():
        _drop_specks(picture, assignment, paints, tolerances, limits, canvas)
    return _split(assignment, paints, tolerances.reach)


def _drop_redundant(
    picture: Floats32, assignment: Assignment, paints: Paints, tolerances: Tolerances, only_new: bool
) -> None:
    """Drop small areas that a mix of the regions around explains: slivers along edges, seams, and noise.

    ``only_new`` are those of paints that no larger area has.
    """
    areas = areas_of(assignment)
    size = np.bincount(areas.ravel())
    is_small = (size < small_area(tolerances))[areas]
    if only_new:
        known = np.unique(assignment.label[~is_small])
        is_small &= ~np.isin(assignment.label, known)
    if is_small.all() or not is_small.any():
        return
    trial = assignment.copy()
    trial.anchors[is_small] = NONE
    trial.is_pure[is_small] = False
    unmix(trial, is_small, picture, paints, tolerances, None)
    explained = (trial.residual[is_small] <= tolerances.mix) | _shines_through(
        picture, assignment, trial, is_small, paints, tolerances
    )
    count = np.bincount(areas[is_small], explained, len(size))
    dropped = is_small & (count >= REGIONS.explained_part * size)[areas]
    assignment.write(trial, dropped)
    unexplained = dropped & (trial.residual > tolerances.mix)
    unmix(assignment, unexplained, picture, paints, tolerances, None, wider=True)


def _shines_through(
    picture: Floats32, assignment: Assignment, trial: Assignment, where: Mask, paints: Paints, tolerances: Tolerances
) -> Mask:
    """Return which of the pixels ``where`` [h, w] are a seam of two regions of ``trial``.

    A seam has a little of the pixel's own region behind it.
    """
    rows, columns = (place.astype(np.int32) for place in np.nonzero(where))
    names = np.stack([side[rows, columns] for side in (assignment.label, trial.label, trial.other)], 1)
    shares, rest = triple_shares(*colors_of(names, rows, columns, picture, paints, tolerances.metric))
    return (shares >= 0).all(1) & (shares[:, 0] <= REGIONS.far_share_max) & (rest <= tolerances.mix)


def _drop_specks(
    picture: Floats32, assignment: Assignment, paints: Paints, tolerances: Tolerances, limits: SpeckLimits,
    canvas: int | None,
) -> None:  # fmt: skip
    """Give the pixels of specks to the regions around, first to those in reach."""
    _flip_halves(assignment)
    for radius in (tolerances.reach, 1):
        speck = specks_of(assignment, paints, tolerances.metric, limits)
        if speck.all() or not speck.any():
            return
        assignment.anchors[...] = np.where(speck, NONE, assignment.anchors if radius > 1 else assignment.label)
        assignment.is_pure[speck] = False
        unmix(assignment, speck, picture, paints, tolerances, canvas if radius > 1 else None, radius)


def _flip_halves(assignment: Assignment) -> None:
    """Give the pixels of areas that have hardly more than half of any pixel to the regions they share these with."""
    areas = areas_of(assignment)
    peak = np.zeros(areas.max() + 1, np.float32)
    np.maximum.at(peak, areas.ravel(), assignment.share.ravel())
    size = np.bincount(areas.ravel())
    is_wisp = (
        (peak < REGIONS.wisp_share_max)
        & (size < REGIONS.wisp_area_max)
        & (most_contact(areas, assignment.label) < REGIONS.between_border_share)
    )
    flipped = ((peak < REGIONS.edge_share_max) | is_wisp)[areas]
    assignment.label[flipped], assignment.other[flipped] = assignment.other[flipped], assignment.label[flipped]
    assignment.share[flipped] = 0.5


def _split(assignment: Assignment, paints: Paints, reach: int) -> tuple[Assignment, Paints]:
    """Make a region of each connected area, and find the areas that the shares of pixels belong to."""
    label, other = assignment.label, assignment.other
    areas = areas_of(assignment)
    first = np.zeros(areas.max() + 1, np.int32)
    first[areas.ravel()] = label.ravel()
    new_other = areas.copy()
    rows, columns = np.nonzero(other != label)
    new_other[rows, columns] = _nearest_area(areas, label, rows, columns, other[rows, columns], reach)
    share = np.where(new_other == areas, np.float32(1), assignment.share)
    anchors = np.where(assignment.anchors == label, areas, NONE)
    result = Assignment(anchors, assignment.is_pure, areas, new_other, share, assignment.residual)
    return result, paints.select(first)


def _nearest_area(
    areas: Integers32, label: Integers32, rows: Places, columns: Places, wanted: Integers32, reach: int
) -> Integers32:
    """Return the area [N] of the label ``wanted`` [N] nearest to each pixel, or the largest of it if none is near."""
    steps = np.arange(-reach, reach + 1)
    dy, dx = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    order = np.argsort(dy**2 + dx**2, kind="stable")
    width = label.shape[1] + 2 * reach
    place = ((rows + reach) * width + columns + reach)[:, None] + (dy * width + dx)[order]
    fits = np.pad(label, reach, constant_values=NONE).ravel()[place] == wanted[:, None]
    nearest = np.pad(areas, reach).ravel()[place[np.arange(len(rows)), fits.argmax(1)]]
    largest = _largest_areas(areas, label, int(max(label.max(), wanted.max(initial=0))) + 1)[wanted]
    elsewhere = np.where(largest == NONE, areas[rows, columns], largest)
    return np.where(fits.any(1), nearest, elsewhere).astype(np.int32)


def _largest_areas(areas: Integers32, label: Integers32, paint_count: int) -> Integers32:
    """Return the largest area of each label, with ``NONE`` for those without one and at the end."""
    size = np.bincount(areas.ravel())
    order = np.argsort(size, kind="stable")
    label_of = np.zeros(len(size), np.int32)
    label_of[areas.ravel()] = label.ravel()
    largest = np.full(paint_count + 1, NONE, np.int32)
    largest[label_of[order]] = order
    return largest
