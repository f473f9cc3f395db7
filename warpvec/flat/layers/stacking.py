"""Layers of a picture of regions, bottom to top: which region is painted over which."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Integers, Integers32, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.layers.junctions import border_shares, evidence_above, find_junctions
from warpvec.flat.layers.line_regions import line_regions
from warpvec.flat.layers.merging import alike, interrupted_pairs
from warpvec.flat.regions.regions import Regions
from warpvec.watch.watch import UNWATCHED, Watch


@dataclass(frozen=True)
class StackedLayer:
    """One path of a drawing.

    Attributes:
        parts: regions that show its paint, grouped by shape: those of a group are joined beneath what interrupts them.
        above: regions that are painted later and hide what is below them.
    """

    parts: tuple[tuple[int, ...], ...]
    above: frozenset[int]

    @property
    def members(self) -> tuple[int, ...]:
        """All regions that show its paint."""
        return tuple(region for part in self.parts for region in part)


def stack(regions: Regions, watch: Watch = UNWATCHED) -> list[StackedLayer]:
    """Return the layers of ``regions``, the lowest first.

    Once the ``watch`` is over, borders and areas alone say what lies above.

    A region lies beneath those that it surrounds. Of neighbours, the one whose outline goes on where a third one meets
    both lies above, or the one that has more of its border with the other; else the smaller one, its holes filled.
    Regions of one paint are one layer where something above interrupts it, or has a hole that is no line. Regions that
    are transparent are holes through all layers. So are those of the paint of the canvas, unless that would say their
    outlines more than once: then they are shapes on top.

    Shapes of one paint that stand alone are one layer with several parts: designers draw lettering so.
    """
    area, surrounds = filled_areas(regions.label, len(regions), watch)
    is_hole = holes(regions, surrounds)
    shown = np.nonzero(~is_hole)[0]
    junctions = find_junctions(regions, shown, watch)
    above = evidence_above(junctions, len(regions))
    shares = border_shares(regions.label, len(regions))
    above += LAYERS.border_evidence * (shares - shares.T) + LAYERS.area_evidence * np.sign(
        area[None, :] - area[:, None]
    )
    above += LAYERS.surrounding_evidence * (surrounds.T.astype(float) - surrounds)
    above = above + _evidence_of_translucence(regions, shares)
    order = best_order(above, sorted(shown.tolist(), key=lambda index: (-area[index], index)))
    seen = list(_seen_through(regions, surrounds, order, watch))
    for _, region in seen:
        around = surrounds[:, region]
        above[region, around] = above[around, region] = 0.0
    pairs = [*seen, *interrupted_pairs(regions, junctions, order)]
    shapes = _grouped([(region,) for region in order], pairs, above)
    joined = _grouped(shapes, _pairs_alone(regions, is_hole, shares, order), above)
    return _layers(regions, [[shape for shape in shapes if shape[0] in path] for path in joined])


def _evidence_of_translucence(regions: Regions, shares: Floats) -> Floats:
    """Return how clearly opaque regions lie above translucent neighbours, as entry [a, b] of an array [K, K].

    On an opaque shape, a translucent one would have another colour. Beneath it, both leave no seam.
    """
    opacity = regions.paints.opacity
    hides, shines = opacity >= 1.0, (opacity > 0.0) & (opacity < 1.0)
    meet = (shares > 0.0) & (shares.T > 0.0)
    return np.where(hides[:, None] & shines & meet, LAYERS.translucence_evidence, 0.0)


def _seen_through(regions: Regions, surrounds: Mask, order: list[int], watch: Watch) -> Iterator[tuple[int, int]]:
    """Yield pairs of regions of one paint, of which the second is seen through a hole in what lies on the first.

    A line is drawn on top: nobody draws a hole that looks like one.
    """
    is_line = line_regions(regions.label, len(regions), watch)
    ordered = np.array(order, np.int64)
    for low, first in enumerate(order):
        later = ordered[low + 1 :]
        later = later[surrounds[first, later] & alike(regions, first, later) & ~is_line[later]]
        yield from ((first, second) for second in later.tolist() if (surrounds[first] & surrounds[:, second]).any())


def _pairs_alone(regions: Regions, is_hole: Mask, shares: Floats, order: list[int]) -> Iterator[tuple[int, int]]:
    """Yield pairs of regions of one paint that border on nothing but what no layer shows, if there are enough.

    Args:
        regions: regions of a picture.
        is_hole: which of them no layer shows [K].
        shares: share of the border of region a with b, as entry [a, b] of an array [K, K].
        order: the regions that are shown, the lowest first.
    """
    stands_alone = shares[:, ~is_hole].sum(1) == 0.0
    rest = np.array([region for region in order if stands_alone[region]], np.int64)
    while len(rest):
        is_alike = alike(regions, int(rest[0]), rest)
        if is_alike.sum() >= LAYERS.alone_min:
            yield from ((int(rest[0]), second) for second in rest[is_alike][1:].tolist())
        rest = rest[~is_alike]


def _grouped(
    groups: Sequence[tuple[int, ...]], pairs: Iterable[tuple[int, int]], above: Floats
) -> list[tuple[int, ...]]:
    """Return the ``groups`` of regions, the lowest first, with both regions of ``pairs`` in one.

    Groups stay apart where another one is in the way.
    """
    groups = list(groups)
    for first, second in pairs:
        places = (next(k for k, group in enumerate(groups) if region in group) for region in (first, second))
        low, high = sorted(places)
        between = [region for group in groups[low + 1 : high] for region in group]
        if low == high:
            continue
        both = groups[low] + groups[high]
        if _is_free(above, between, groups[high]):
            groups[low : high + 1] = [both, *groups[low + 1 : high]]
        elif _is_free(above.T, between, groups[low]):
            groups[low : high + 1] = [*groups[low + 1 : high], both]
    return groups


def _is_free(above: Floats, between: list[int], group: tuple[int, ...]) -> bool:
    """Return whether nothing says that ``group`` lies above one of the regions ``between``."""
    evidence = above[np.ix_(group, between)] - above[np.ix_(between, group)].T
    return bool((evidence < LAYERS.clear_evidence).all())


def _layers(regions: Regions, paths: list[list[tuple[int, ...]]]) -> list[StackedLayer]:
    hides = regions.paints.opacity >= 1.0
    layers: list[StackedLayer] = []
    above: list[int] = []
    for shapes in reversed(paths):
        layers.insert(0, StackedLayer(tuple(shapes), frozenset(above)))
        above += [region for shape in shapes for region in shape if hides[region]]
    return layers


def holes(regions: Regions, surrounds: Mask) -> Mask:
    """Return which regions [K] no layer shows: the canvas, transparent ones, and those of the paint of the canvas.

    Of these, words are shown: as holes, they would have no outlines on the finer grid. So is what two layers or more
    would have a hole for: on top its outline is said once.

    Args:
        regions: K regions of a picture.
        surrounds: whether region a surrounds b, as entry [a, b] of an array [K, K].
    """
    is_clear = regions.paints.opacity <= 0.0
    if regions.canvas is None or is_clear[regions.canvas]:
        return np.asarray(is_clear)
    is_hole = is_clear | alike(regions, regions.canvas, np.arange(len(regions)))
    if regions.is_lettering is not None:
        is_hole &= is_clear | ~regions.is_lettering
    ends = surrounds[:, is_hole].astype(np.int64) @ surrounds[is_hole].astype(np.int64) > 0  # at a hole in between
    layer_count = (surrounds & ~ends)[~is_hole].sum(0)
    return np.asarray(is_hole & (is_clear | (layer_count < 2)))


def best_order(above: Floats, start: Sequence[int]) -> list[int]:
    """Return the indices of ``start`` in the order, lowest first, that agrees best with ``above`` [K, K].

    Entry [a, b] says how clearly a lies above b. Single entries move while the sum over all pairs grows.
    """
    order = np.array(start, np.int64)
    more = above - above.T
    for _ in range(LAYERS.layer_moves_max):
        before = order
        for entry in before.tolist():
            current = int(np.argmax(order == entry))
            rest = np.delete(order, current)
            values = np.concatenate([[0.0], np.cumsum(more[entry, rest])])
            place = int(values.round(9).argmax())
            if values[place] > values[current] + 1e-9:
                order = np.insert(rest, place, entry)
        if (order == before).all():
            break
    return [int(entry) for entry in order]


def filled_areas(label: Integers32, count: int, watch: Watch = UNWATCHED) -> tuple[Integers, Mask]:
    """Return the area in pixels of each of ``count`` regions with what it surrounds [K], and what that is [K, K].

    A region is surrounded if most of its pixels are. Once the ``watch`` is over, the regions that are left, the
    smallest ones, surround nothing.
    """
    surrounds = np.zeros((count, count), bool)
    pixels = np.bincount(label.ravel(), minlength=count)
    area, boxes = pixels.copy(), ndimage.find_objects(label + 1, count)
    for region in np.argsort(-pixels).tolist():
        box = boxes[region]
        if watch.is_over() or box is None:
            break
        filled = with_filled_holes(label[box] == region)
        area[region] = filled.sum()
        surrounds[region] = 2 * np.bincount(label[box][filled], minlength=count) > pixels
    np.fill_diagonal(surrounds, False)
    return area, surrounds
