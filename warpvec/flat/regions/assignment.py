"""The share of regions in all pixels, from areas of pure pixels and their paints."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats32, Integers32, Mask, Places, blocks
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE, grow_by_paint
from warpvec.flat.regions.unmixing import Candidates, Mixes, best_mixes, explain_by_three, nearest_labels


@dataclass(frozen=True, eq=False)
class Assignment:
    """The mix of two regions in each pixel of a picture; see `warpvec.flat.regions.regions.Regions`.

    Attributes:
        anchors: regions of the pixels [h, w] that show one, or ``NONE``. A pixel can be mixed of those near it.
        is_pure: pixels [h, w] that show one region alone.
        label: region with the largest share [h, w].
        other: region that has the rest [h, w].
        share: share of ``label`` [h, w].
        residual: difference that the mix does not explain [h, w].
    """

    anchors: Integers32
    is_pure: Mask
    label: Integers32
    other: Integers32
    share: Floats32
    residual: Floats32

    def copy(self) -> Assignment:
        """Return a copy of all arrays."""
        return Assignment(*(getattr(self, field.name).copy() for field in fields(self)))

    def write(self, other: Assignment, where: Mask) -> None:
        """Take the pixels ``where`` [h, w] from ``other``."""
        for field in fields(self):
            getattr(self, field.name)[where] = getattr(other, field.name)[where]


def assign(
    picture: Floats32, seeds: Integers32, paints: Paints, tolerances: Tolerances, canvas: int | None
) -> Assignment:
    """Grow the areas ``seeds`` [h, w] over the pixels of their paints, and unmix the pixels that remain."""
    anywhere = np.ones(seeds.shape, bool)
    anchors = grow_by_paint(seeds, anywhere, picture, paints, tolerances.metric, tolerances.paint)
    label, other, share = anchors.copy(), anchors.copy(), np.ones(anchors.shape, np.float32)
    residual = np.zeros(anchors.shape, np.float32)
    assignment = Assignment(anchors, anchors != NONE, label, other, share, residual)
    unmix(assignment, ~assignment.is_pure, picture, paints, tolerances, canvas)
    if tolerances.noise > 0:
        _accept_loosely(assignment, picture, paints, tolerances)
    return assignment


def _accept_loosely(assignment: Assignment, picture: Floats32, paints: Paints, tolerances: Tolerances) -> None:
    """Give unexplained pixels to the regions beside them whose paint they show roughly."""
    limit = REGIONS.loose * tolerances.paint
    grown = grow_by_paint(assignment.anchors, ~assignment.is_pure, picture, paints, tolerances.metric, limit)
    accepted = (assignment.residual > tolerances.mix) & (grown != NONE)
    for array in (assignment.anchors, assignment.label, assignment.other):
        array[accepted] = grown[accepted]
    assignment.share[accepted], assignment.residual[accepted] = 1.0, 0.0
    assignment.is_pure[accepted] = True


def unmix(
    assignment: Assignment, where: Mask, picture: Floats32, paints: Paints, tolerances: Tolerances, canvas: int | None,
    radius: int | None = None, wider: bool = False,
) -> None:  # fmt: skip
    """Write the best mixes of the pixels ``where`` [h, w] of anchors within ``radius`` into ``assignment``.

    In noisy pictures, ``wider`` looks farther for regions that explain what those do not.
    """
    rows, columns = (place.astype(np.int32) for place in np.nonzero(where))
    nearest = _NearestAnchors(assignment.anchors)
    if len(rows) == 0:
        return
    for part in blocks(len(rows), REGIONS.pixels_at_once):
        _unmix_pixels(
            assignment, rows[part], columns[part], nearest, picture, paints, tolerances, canvas, radius, wider
        )


def _unmix_pixels(
    assignment: Assignment, rows: Integers32, columns: Integers32, nearest: _NearestAnchors, picture: Floats32,
    paints: Paints, tolerances: Tolerances, canvas: int | None, radius: int | None, wider: bool,
) -> None:  # fmt: skip
    """Write the best mixes of pixels at ``rows`` and ``columns`` [N] into ``assignment``; see `unmix`."""
    candidates = nearest_labels(assignment.anchors, rows, columns, radius or tolerances.reach)
    candidates = _with_fallback(candidates, nearest, rows, columns)
    candidates = _with_canvas(candidates, canvas, rows, columns, assignment.label.shape)
    color, values = colors_of(candidates.label, rows, columns, picture, paints, tolerances.metric)
    mixes = best_mixes(color, values, candidates)
    hard = np.nonzero(mixes.residual > tolerances.mix)[0]
    if wider and tolerances.noise > 0 and len(hard):
        _search_wider(mixes, hard, assignment.anchors, rows, columns, picture, paints, tolerances)
        hard = np.nonzero(mixes.residual > tolerances.mix)[0]
    if len(hard):
        _explain_hard(mixes, hard, candidates, rows, columns, picture, paints, tolerances, canvas)
    assignment.label[rows, columns], assignment.other[rows, columns] = mixes.label, mixes.other
    assignment.share[rows, columns], assignment.residual[rows, columns] = mixes.share, mixes.residual


def colors_of(
    label: Integers32, rows: Integers32, columns: Integers32, picture: Floats32, paints: Paints, metric: Floats32
) -> tuple[Floats32, Floats32]:
    """Return the colours of N pixels [N, D] and of the regions ``label`` [N, C] there [N, C, D], seen by ``metric``."""
    x, y = (place.astype(np.float32)[:, None] + np.float32(0.5) for place in (columns, rows))
    shape = label.shape
    values = paints.at(np.maximum(label, 0), np.broadcast_to(x, shape), np.broadcast_to(y, shape))
    return picture[rows, columns] @ metric, values @ metric


@dataclass(frozen=True)
class _NearestAnchors:
    """The nearest region to each pixel at any distance, found when the first pixel asks for it."""

    anchors: Integers32

    @cached_property
    def labels(self) -> Integers32:
        """The nearest of the ``anchors`` [h, w] to each pixel."""
        row, column = ndimage.distance_transform_edt(self.anchors == NONE, return_distances=False, return_indices=True)
        return np.asarray(self.anchors[row, column])


def _with_fallback(
    candidates: Candidates, nearest: _NearestAnchors, rows: Integers32, columns: Integers32
) -> Candidates:
    """Return the candidates with the nearest region at any distance where none is near."""
    missing = candidates.label[:, 0] == NONE
    if missing.any():
        candidates.label[missing, 0] = nearest.labels[rows[missing], columns[missing]]
    return candidates


def _search_wider(
    mixes: Mixes, hard: Places, anchors: Integers32, rows: Integers32, columns: Integers32, picture: Floats32,
    paints: Paints, tolerances: Tolerances,
) -> None:  # fmt: skip
    """Replace the mixes ``hard`` by those of regions within the reach of ringing where these leave less."""
    candidates = nearest_labels(anchors, rows[hard], columns[hard], REGIONS.ringing_reach)
    near = Candidates(candidates.label, np.zeros_like(candidates.squared))
    found = near.label[:, 0] != NONE
    hard, near = hard[found], Candidates(near.label[found], near.squared[found])
    color, values = colors_of(near.label, rows[hard], columns[hard], picture, paints, tolerances.metric)
    better = best_mixes(color, values, near)
    chosen = better.residual < mixes.residual[hard]
    for name in ("label", "other", "share", "residual"):
        getattr(mixes, name)[hard[chosen]] = getattr(better, name)[chosen]


def _with_canvas(
    candidates: Candidates, canvas: int | None, rows: Integers32, columns: Integers32, shape: tuple[int, ...]
) -> Candidates:
    """Return the candidates with the canvas last where the picture ends: it goes on beyond."""
    if canvas is None:
        return candidates
    at_end = (
        (np.minimum(rows, columns) < REGIONS.canvas_reach)
        | (rows >= shape[0] - REGIONS.canvas_reach)
        | (columns >= shape[1] - REGIONS.canvas_reach)
    )
    chosen = at_end & ~(candidates.label == canvas).any(1)
    slot = np.minimum((candidates.label[chosen] != NONE).sum(1), candidates.label.shape[1] - 1)
    candidates.label[chosen, slot], candidates.squared[chosen, slot] = canvas, 1.0
    return candidates


def _explain_hard(
    mixes: Mixes, hard: Places, candidates: Candidates, rows: Integers32, columns: Integers32, picture: Floats32,
    paints: Paints, tolerances: Tolerances, canvas: int | None,
) -> None:  # fmt: skip
    """Replace the mixes ``hard`` by mixes of three regions, one of which may be the canvas, where these are better."""
    label, squared = candidates.label[hard], candidates.squared[hard]
    far = np.zeros((len(hard), label.shape[1] + 1), bool)
    far[:, -1] = True
    extra = np.full(len(hard), NONE if canvas is None else canvas, np.int32)
    extra[(label == extra[:, None]).any(1)] = NONE
    wider = Candidates(np.column_stack([label, extra]), np.column_stack([squared, np.zeros(len(hard), np.float32)]))
    color, values = colors_of(wider.label, rows[hard], columns[hard], picture, paints, tolerances.metric)
    part = Mixes(mixes.label[hard], mixes.other[hard], mixes.share[hard], mixes.residual[hard])
    better = explain_by_three(part, color, values, wider, far)
    mixes.label[hard], mixes.other[hard] = better.label, better.other
    mixes.share[hard], mixes.residual[hard] = better.share, better.residual
