"""Order of neighbours: the one whose outline goes on smoothly where a third paint meets both lies above the other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.curves.contours import contours_of
from warpvec.flat.curves.outline_nodes import sample_loops, sides_of, turns_of
from warpvec.flat.regions.regions import Regions
from warpvec.watch.watch import UNWATCHED, Watch

Integers = NDArray[Any]

NO_NEIGHBOUR = -1


class Junctions(NamedTuple):
    """J places of outlines of regions where their neighbour changes.

    Attributes:
        region: whose outline it is [J].
        before, after: neighbours there before and after the junction [J], ``NO_NEIGHBOUR`` beyond the picture.
        turn: by how much the outline turns there, in radians [J].
        point: place in pixels [J, 2].
        back, forth: unit vectors from there back and on along the outline [J, 2].
    """

    region: Integers
    before: Integers
    after: Integers
    turn: Floats
    point: Floats
    back: Floats
    forth: Floats


def find_junctions(regions: Regions, shown: Integers, watch: Watch = UNWATCHED) -> Junctions:
    """Return the junctions of all regions ``shown`` [n]. Once the ``watch`` is over, those so far must do."""
    labels = np.pad(regions.label, 1, constant_values=NO_NEIGHBOUR)
    boxes, found = boxes_of(regions), list[Junctions]()
    for region in shown:
        if watch.is_over():
            break
        found += _junctions_of(regions, int(region), labels, boxes[region])
    if not found:
        none, pairs = np.zeros(0, np.int64), np.zeros((0, 2))
        return Junctions(none, none, none, np.zeros(0), pairs, pairs, pairs)
    return Junctions(*(np.concatenate(values) for values in zip(*found, strict=True)))


def evidence_above(junctions: Junctions, count: int) -> Floats:
    """Return how clearly region a of ``count`` lies above b, in [-1, 1], as entry [a, b] of an array [K, K].

    Where the paints a, b and c meet, the outline of the shape in front goes on smoothly, and those of the others end
    there (a T-junction). 0 says that a and b have no junction, or that both outlines go on equally well.
    """
    smooth, times = np.zeros((count, count)), np.zeros((count, count))
    goes_on = np.clip(1.0 - junctions.turn / LAYERS.junction_turn_max, 0.0, 1.0)
    for neighbour in (junctions.before, junctions.after):
        is_region = neighbour >= 0
        place = junctions.region[is_region], neighbour[is_region]
        np.add.at(smooth, place, goes_on[is_region])
        np.add.at(times, place, 1.0)
    mean = smooth / np.maximum(times, 1.0)
    both = (times > 0) & (times.T > 0)
    return np.where(both, mean - mean.T, 0.0)


def border_shares(label: Integers, count: int) -> Floats:
    """Return the share of the border of region a that is shared with b, as entry [a, b] of an array [K, K].

    Args:
        label: region of each pixel [h, w].
        count: number of regions, K.
    """
    length = np.zeros((count, count))
    for first, second in ((label[:, 1:], label[:, :-1]), (label[1:], label[:-1])):
        pairs = np.bincount(first.ravel().astype(np.int64) * count + second.ravel(), minlength=count * count)
        length += pairs.reshape(count, count) + pairs.reshape(count, count).T
    np.fill_diagonal(length, 0.0)
    return length / np.maximum(length.sum(1, keepdims=True), 1.0)


def _junctions_of(
    regions: Regions, region: int, labels: Integers, box: tuple[slice, slice] | None
) -> Iterator[Junctions]:
    """Yield the junctions of each loop of the outline of ``region``, which lies in ``box``.

    The map ``labels`` [h + 2, w + 2] of the regions has a margin of ``NO_NEIGHBOUR``.
    """
    loops, corner = region_contours(regions, region, box)
    if not loops:
        return
    samples = sample_loops(loops)
    for start, stop in pairwise(samples.first):
        xy = samples.xy[start:stop]
        neighbour = _neighbours(labels, xy + corner)
        places = np.nonzero(neighbour != np.roll(neighbour, 1))[0]
        if not len(places):
            continue
        ahead, behind = sides_of(xy, places)
        turn, own = turns_of(ahead, behind), np.full(len(places), region)
        at = xy[places] + corner
        yield Junctions(own, neighbour[places - 1], neighbour[places], turn, at, behind.away, ahead.away)


def boxes_of(regions: Regions) -> list[tuple[slice, slice] | None]:
    """Return the rows and columns around the pixels of each region [K], also the mixed ones; None if there are none."""
    first, second = (ndimage.find_objects(part + 1, len(regions)) for part in (regions.label, regions.other))
    return [_joined(a, b) if a and b else a or b for a, b in zip(first, second, strict=True)]


def _joined(first: tuple[slice, slice], second: tuple[slice, slice]) -> tuple[slice, slice]:
    """Return the box around two boxes."""
    rows, columns = (slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(first, second, strict=True))
    return rows, columns


def region_contours(regions: Regions, region: int, box: tuple[slice, slice] | None) -> tuple[list[Floats], Floats]:
    """Return the contours [n, 2] of a region in ``box`` alone, relative to its corner in pixels [2], and that."""
    if box is None:
        return [], np.zeros(2)
    share = regions.share[box].astype(np.float64)
    coverage = share * (regions.label[box] == region) + (1.0 - share) * (regions.other[box] == region)
    return contours_of(coverage), np.array([box[1].start, box[0].start], np.float64)


def _neighbours(labels: Integers, xy: Floats) -> Integers:
    """Return the region outside of each sample [n] of an outline; short borders count to those before."""
    along = np.roll(xy, -2, axis=0) - np.roll(xy, 2, axis=0)
    normal = np.stack([along[:, 1], -along[:, 0]], 1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    place = np.floor(xy + LAYERS.neighbour_distance * normal).astype(np.int64) + 1
    height, width = labels.shape
    found = labels[np.clip(place[:, 1], 0, height - 1), np.clip(place[:, 0], 0, width - 1)].astype(np.int64)
    return _without_short_runs(found)


def _without_short_runs(values: Integers) -> Integers:
    changes = np.nonzero(values != np.roll(values, 1))[0]
    if len(changes) < 2:
        return values
    lengths = np.diff(np.append(changes, changes[0] + len(values)))
    long = changes[lengths >= LAYERS.border_samples_min]
    if not len(long):
        return np.full_like(values, values[changes[lengths.argmax()]])
    index = np.arange(len(values))
    return values[long[np.searchsorted(long, index, side="right") - 1]]
