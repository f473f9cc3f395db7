"""Paint regions with few colours, or with given ones, and join neighbours that then have the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpvec.arrays import Floats, Integers
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.regions import Regions
from warpvec.geometry.paints.registry import FLAT


def with_colors(regions: Regions, count: int) -> Regions:
    """Return ``regions`` with at most ``count`` colours, those of the canvas included.

    The two colours whose difference shows least become one, again and again; the one of the larger area stays.
    """
    color, area = flat_colors(regions)
    return _painted(regions, _merged(color, area, count))


def with_palette(regions: Regions, palette: Floats) -> Regions:
    """Return ``regions`` each in the colour of ``palette`` [C, 3] that is nearest."""
    color, _ = flat_colors(regions)
    distance = np.square(color[:, None] - palette[None]).sum(2)
    return _painted(regions, palette[distance.argmin(1)])


def with_flat_paints(regions: Regions) -> Regions:
    """Return ``regions`` without gradients: each has its mean colour."""
    if (regions.paints.kind == FLAT).all():
        return regions
    return _painted(regions, flat_colors(regions)[0])


def flat_colors(regions: Regions) -> tuple[Floats, Floats]:
    """Return the mean colour of each region [K, 3] and its area in pixels [K]."""
    rows, columns = (np.arange(side, dtype=np.float32) + np.float32(0.5) for side in regions.label.shape)
    x, y = np.meshgrid(columns, rows)
    paint = regions.paints.at(regions.label, x, y)
    label = regions.label.ravel()
    area = np.bincount(label, minlength=len(regions)).astype(np.float64)
    weight = paint[..., 3].ravel().astype(np.float64)
    cover = np.bincount(label, weight, minlength=len(regions))
    sums = [np.bincount(label, paint[..., c].ravel(), minlength=len(regions)) for c in range(3)]
    mean = np.stack(sums, 1) / np.maximum(cover, 1e-9)[:, None]
    is_ramp = (regions.paints.kind != FLAT) & (cover > 0)
    return np.where(is_ramp[:, None], mean, regions.paints.color.astype(np.float64)), area * regions.paints.opacity


def _merged(color: Floats, area: Floats, count: int) -> Floats:
    """Return ``color`` [K, 3] with at most ``count`` different rows, by the least rise of the squared error."""
    shown = np.flatnonzero(area > 0)
    found, owner = np.unique(color[shown], axis=0, return_inverse=True)
    owner = owner.ravel()
    weight = np.bincount(owner, area[shown])
    while len(found) > count:
        rise = weight[:, None] * weight[None] / (weight[:, None] + weight[None])
        rise *= np.square(found[:, None] - found[None]).sum(2)
        np.fill_diagonal(rise, np.inf)
        pair = np.unravel_index(int(rise.argmin()), rise.shape)
        kept, gone = sorted((int(index) for index in pair), key=lambda index: -weight[index])
        weight[kept] += weight[gone]
        owner[owner == gone] = kept
        owner[owner > gone] -= 1
        found, weight = np.delete(found, gone, 0), np.delete(weight, gone)
    merged = color.copy()
    merged[shown] = found[owner]
    return merged


def _painted(regions: Regions, color: Floats) -> Regions:
    """Return flat ``regions`` of ``color`` [K, 3], with neighbours of one paint joined."""
    paint = np.column_stack([color, np.where(regions.paints.opacity >= REGIONS.opaque, 1.0, regions.paints.opacity)])
    paint[regions.paints.opacity <= 0.0] = 0.0
    group = _joined(regions, np.unique(paint, axis=0, return_inverse=True)[1].ravel())
    first = np.unique(group, return_index=True)[1]
    label, other = (group[values].astype(np.int32) for values in (regions.label, regions.other))
    share = np.where(label == other, np.float32(1.0), regions.share)
    canvas = None if regions.canvas is None else int(group[regions.canvas])
    kept = color[first].astype(np.float32)
    opacity = regions.paints.mean_opacity()[first]
    kinds = np.full(len(first), FLAT, np.int32)
    flat = replace(regions.paints.select(first), color=kept, end_color=kept, kind=kinds, opacity=opacity)
    return Regions(label, other, share, flat, canvas, regions.lettering_among(first), regions.noise)


def _joined(regions: Regions, paint: Integers) -> Integers:
    """Return which group of touching regions of equal ``paint`` [K] each region belongs to [K]."""
    label = regions.label
    pairs = [(label, regions.other), (label[:, 1:], label[:, :-1]), (label[1:], label[:-1])]
    first, second = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in (0, 1))
    is_same = (first != second) & (paint[first] == paint[second])
    return connected_parts(first[is_same], second[is_same], len(regions))
