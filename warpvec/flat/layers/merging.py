"""Find regions that are parts of one shape: they have one paint, and something above interrupts the shape."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.layers.junctions import Junctions
from warpvec.flat.regions.regions import Regions
from warpvec.geometry.paints.registry import FLAT


def alike(regions: Regions, first: int, others: Integers) -> Mask:
    """Return which regions ``others`` [n] have the paint of ``first``, within ``paints_apart`` where they show it."""
    paints = regions.paints
    color = np.abs(paints.color[others] - paints.color[first]).max(1)
    apart = np.maximum(color, np.abs(paints.opacity[others] - paints.opacity[first]))
    is_flat = (paints.kind[others] == FLAT) & (paints.kind[first] == FLAT)
    found = (others == first) | (is_flat & (apart <= LAYERS.paints_apart))
    if paints.kind[first] != FLAT:
        is_ramp = paints.kind[others] != FLAT
        found[is_ramp] |= _alike_ramps(regions, first, others[is_ramp])
    return np.asarray(found)


def _alike_ramps(regions: Regions, first: int, others: Integers) -> Mask:
    """Return which regions ``others`` [n] would look the same with the gradient of ``first``, at all pure pixels.

    A region without such pixels does not show its gradient. One pixel of each tells most of them apart.
    """
    pixels = [regions.pure_pixels[region] for region in others.tolist()]
    found = np.array([len(own) > 0 for own in pixels], bool)
    begin = np.array([own[0] for own in pixels if len(own)], np.int64)
    found[found] = _apart(regions, first, others[found], begin) <= LAYERS.paints_apart
    for k in np.flatnonzero(found).tolist():
        region = np.full(len(pixels[k]), others[k])
        found[k] = (_apart(regions, first, region, pixels[k]) <= LAYERS.paints_apart).all()
    return found


def _apart(regions: Regions, first: int, others: Integers, pixels: Integers) -> Floats:
    """Return how far the paint of ``first`` is from those of ``others`` [n] at a pixel of each [n], by its number."""
    y, x = np.divmod(pixels, regions.label.shape[1])
    places = x.astype(np.float32) + np.float32(0.5), y.astype(np.float32) + np.float32(0.5)
    own, other = (regions.paints.at(names.astype(np.int32), *places) for names in (np.full(len(pixels), first), others))
    return np.asarray(np.abs(own - other).max(1, initial=0.0), np.float64)


def interrupted_pairs(regions: Regions, junctions: Junctions, order: list[int]) -> Iterator[tuple[int, int]]:
    """Yield pairs of regions of one paint whose outlines go on from one to the other beneath what is painted later.

    Args:
        regions: regions of a picture.
        junctions: junctions of all regions in ``order``.
        order: the regions, the lowest first.
    """
    place = np.full(len(regions) + 1, -1)
    place[order] = np.arange(len(order))
    hides = np.append(regions.paints.opacity >= 1.0, False)
    # The last entry stands for what lies beyond the picture.
    goes_under = hides[junctions.after] & (place[junctions.after] > place[junctions.region])
    comes_out = hides[junctions.before] & (place[junctions.before] > place[junctions.region])
    touched = set(junctions.region[goes_under | comes_out].tolist())
    candidates = np.array([region for region in order if region in touched], np.int64)
    for index, first in enumerate(candidates.tolist()):
        later = candidates[index + 1 :]
        is_second = np.zeros(len(regions), bool)
        is_second[later[alike(regions, first, later)]] = True
        if not is_second.any():
            continue
        above = hides[:-1] & (place[:-1] > place[first])
        is_own, is_other = junctions.region == first, is_second[junctions.region]
        strength = _facing(regions, junctions, goes_under & is_own, comes_out & is_other, above, first)
        strength += _facing(regions, junctions, goes_under & is_other, comes_out & is_own, above, first)
        yield from ((first, second) for second in later.tolist() if strength[second] >= 2)


def _facing(regions: Regions, junctions: Junctions, leaving: Mask, arriving: Mask, above: Mask, first: int) -> Integers:
    """Return how clearly outlines go on between the region ``first`` and each region [K], beneath those ``above`` [K].

    They go on from junctions ``leaving`` [J] to those ``arriving`` [J]. Each of the former whose outline goes on
    straight counts 2, each other one that goes on 1.
    """
    starts, ends = np.nonzero(leaving)[0], np.nonzero(arriving)[0]
    found = np.zeros(len(regions), np.int64)
    step = max(1, LAYERS.pairs_at_once // max(len(ends), 1))
    for chunk in (starts[k : k + step] for k in range(0, len(starts), step)):
        np.add.at(found, *_facing_regions(regions, junctions, chunk, ends, above, first))
    return found


def _facing_regions(
    regions: Regions, junctions: Junctions, leaving: Integers, arriving: Integers, above: Mask, first: int
) -> tuple[Integers, Integers]:
    """Return the regions [P] beside ``first`` that `_facing` counts for, and what it counts [P]: 1 or 2."""
    start, end, straight = _facing_junctions(junctions, leaving, arriving)
    other = np.where(junctions.region[start] == first, junctions.region[end], junctions.region[start])
    is_hidden = _is_hidden(regions, junctions.point[start], junctions.point[end], above, other)
    # Of one junction and one region, the straightest way counts.
    keys, pair = np.unique((start * len(regions) + other)[is_hidden], return_inverse=True)
    counted = np.zeros(len(keys), np.int64)
    np.maximum.at(counted, pair, np.where(straight[is_hidden] > LAYERS.straight_cosine, 2, 1))
    return keys % len(regions), counted


def _facing_junctions(junctions: Junctions, leaving: Integers, arriving: Integers) -> tuple[Integers, Integers, Floats]:
    """Return the pairs of junctions [P] that face each other, and the cosine of the larger of their two turns [P]."""
    way = junctions.point[arriving] - junctions.point[leaving][:, None]
    length = np.linalg.norm(way, axis=-1)
    unit = way / np.maximum(length, 1e-9)[..., None]
    goes_on = -(junctions.back[leaving][:, None] * unit).sum(-1)
    comes_in = (junctions.forth[arriving] * unit).sum(-1)
    straight = np.minimum(goes_on, comes_in)
    rows, columns = np.nonzero((straight > LAYERS.facing_cosine) & (length > LAYERS.ends_apart))
    return leaving[rows], arriving[columns], straight[rows, columns]


def _is_hidden(regions: Regions, start: Floats, end: Floats, above: Mask, other: Integers) -> Mask:
    """Return whether regions ``above`` [K], but not ``other`` [P], hide the way from ``start`` [P, 2] to ``end``."""
    share = np.linspace(0.1, 0.9, LAYERS.way_samples)[:, None]
    x, y = np.floor(start[:, None] * (1.0 - share) + end[:, None] * share).astype(np.int64).reshape(-1, 2).T
    height, width = regions.label.shape
    label = regions.label[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)].reshape(-1, LAYERS.way_samples)
    return (above[label] & (label != other[:, None])).mean(1) > 0.9
