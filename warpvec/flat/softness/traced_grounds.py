"""Find what a shadow may lie on, and which shapes lie on it, from a first, rough tracing of the picture.

A shadow fades into its ground without an edge, so the ground *reaches* it pixel by pixel. Shapes have edges, so the
ground ends there. Pieces of the tracing that the ground reaches are slabs and bands that it made of soft light.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.regions.regions import Regions
from warpvec.flat.softness.shaded_grounds import fit_shaded_ground
from warpvec.flat.softness.shadow_fitting import Zone
from warpvec.image.spread import largest_channel


@dataclass(frozen=True)
class TracedGround:
    """What a shadow lies on, in levels.

    Attributes:
        color: its middle colour [C].
        below: its colour at each pixel [h, w, C], also where something hides it.
        is_flat: whether it has one colour.
        noise: standard deviation of the picture from it.
        region: where it can lie [h, w]: everywhere, or in a shape of the drawing.
        is_open: where nothing covers it [h, w].
        is_seen: where the picture shows it without a shadow [h, w], in its region.
        pieces: the number of the sharp piece of the tracing that covers it at each pixel [h, w], from 1 on; 0 for none.
        is_part: whether it is what lies around one of several things.
        is_jpeg: whether the picture was saved as JPEG.
    """

    color: Floats
    below: Floats
    is_flat: bool
    noise: float
    region: Mask
    is_open: Mask
    is_seen: Mask
    pieces: NDArray[np.int32]
    is_part: bool = False
    is_jpeg: bool = False

    @property
    def deviation(self) -> Floats | None:
        """How far its colour is from the middle one [h, w, C]; None if it has one colour."""
        return None if self.is_flat else self.below - self.color

    @property
    def alike(self) -> float:
        """Largest difference from it, in levels, that says nothing."""
        return SOFTNESS.alike + SOFTNESS.noises * self.noise

    def after(self, levels: Floats) -> TracedGround:
        """Return the ground as the ``levels`` [h, w, C] of another picture of the same shapes show it."""
        return replace(self, is_seen=self.is_open & (_smooth_change(levels - self.below, self.noise) <= self.alike))

    def looks_like(self, other: TracedGround) -> bool:
        """Return whether a search on another ground of the same region finds the same."""
        return np.array_equal(self.pieces, other.pieces) and np.array_equal(self.is_open, other.is_open)

    @property
    def soft_count(self) -> int:
        """How many of its pixels show something else, though nothing covers it."""
        return int((self.is_open & ~self.is_seen).sum())

    def zone(self, change: Floats, is_seen: Mask | None = None) -> Zone:
        """Return what a picture adds, ``change`` [h, w, C], where ``is_seen`` [h, w], or else where it is open."""
        return Zone(change, self.deviation, self.is_open if is_seen is None else is_seen, self.noise)

    def parts(self) -> Iterator[TracedGround]:
        """Yield the ground around each thing on it, with its soft light, and around each shape; the largest first."""
        for marked in (self.region & ~self.is_seen, self.pieces > 0):
            things, count = ndimage.label(ndimage.binary_opening(marked, np.ones((2, 2))), np.ones((3, 3)))
            if not 1 < count <= SOFTNESS.things_max:
                continue
            _, (y, x) = ndimage.distance_transform_edt(things == 0, return_indices=True)
            owner, sizes = things[y, x], np.bincount(things.ravel())
            for number in 1 + np.argsort(-sizes[1:], kind="stable"):
                part = self.limited(self.region & (owner == number))
                if part.is_seen.sum() >= SOFTNESS.part_seen * part.region.sum():
                    yield part

    def limited(self, region: Mask) -> TracedGround:
        """Return its part in a ``region`` [h, w]."""
        pieces = np.where(region, self.pieces, 0)
        return replace(
            self,
            region=region,
            is_open=self.is_open & region,
            is_seen=self.is_seen & region,
            pieces=pieces,
            is_part=True,
        )

    def below_pieces(self, regions: Regions, clean: Floats) -> TracedGround:
        """Return the ground below the pieces of other ``regions``, of the picture ``clean`` [h, w, C] of its shadow."""
        pieces = np.where(self.region, _pieces(regions), 0)
        off = ndimage.median(largest_channel(np.abs(clean - self.below)), pieces, np.arange(pieces.max() + 1))
        return replace(self, pieces=pieces, is_open=self.region).opened(frozenset(np.flatnonzero(off <= self.alike)))

    def reaching(self, soft: Mask) -> TracedGround:
        """Return the ground with what it reaches through ``soft`` pixels [h, w], which a tracing took for pieces."""
        found = ndimage.binary_propagation(self.is_open, mask=self.is_open | (soft & self.region))
        pieces = np.where(found, 0, self.pieces)
        return replace(self, pieces=pieces, is_open=self.region & ~ndimage.binary_dilation(pieces > 0, np.ones((3, 3))))

    def opened(self, slabs: frozenset[int]) -> TracedGround:
        """Return the ground with some of its pieces taken for soft light on it."""
        pieces = np.where(np.isin(self.pieces, list(slabs)), 0, self.pieces)
        is_open = self.region & ~ndimage.binary_dilation(pieces > 0, np.ones((3, 3)))
        return replace(self, pieces=pieces, is_open=is_open, is_seen=self.is_seen & is_open)


def find_traced_grounds(levels: Floats, regions: Regions, is_jpeg: bool = False) -> Iterator[TracedGround]:
    """Yield the grounds of a picture, ``levels`` [h, w, C], on which shadows may lie; the canvas is first.

    What ends at an edge is asked twice, as the steepest shadows bend as much as faint edges.
    """
    label, pieces = regions.label, _pieces(regions)
    sizes = np.bincount(label.ravel(), minlength=len(regions))
    noise = _noise_of(levels, _near_edges(label), is_jpeg)
    at_border = set(np.concatenate([label[0], label[-1], label[:, 0], label[:, -1]]).tolist())
    order = sorted(range(len(regions)), key=lambda k: (k != regions.canvas, k not in at_border, -sizes[k]))
    least = [SOFTNESS.ground_share if k in at_border else SOFTNESS.plate_share for k in order]
    large = [k for k, share in zip(order, least, strict=True) if sizes[k] >= share * label.size]
    cuts = [_sharp_edges(levels, bend + 2.0 * SOFTNESS.noises * noise) for bend in SOFTNESS.piece_bends]
    maps = [_Map(pieces, each) for each in cuts]
    off = largest_channel(np.abs(levels - painted(regions, label)[..., : levels.shape[2]]))
    is_pure = ndimage.binary_dilation(off <= SOFTNESS.alike, np.ones((3, 3)))
    for k in large[: SOFTNESS.grounds_max]:
        is_clear = bool(regions.paints.opacity[k] == 0.0)
        if levels.shape[2] > 3 and not is_clear and regions.paints.opacity[k] < 1.0:
            continue
        shown = levels if is_clear or levels.shape[2] == 3 else levels[..., :3]
        before: TracedGround | None = None
        for each in maps:
            area = (label == k) & (regions.share == 1.0) & ~each.edges
            own = _cut_where_reached(regions, each, area)
            ground = _ground(shown, area, own, k in at_border, noise)
            if ground is None:
                continue
            ground = replace(ground, is_jpeg=is_jpeg)
            if ground.noise < SOFTNESS.ringing:
                ground = ground.reaching(~is_pure & ~each.edges)
            if before is None or not ground.looks_like(before):
                yield ground
            before = ground


def _without_blends(own: Mask, share: NDArray[np.float32]) -> Mask:
    """Return a region [h, w] without the mixed pixels far from its pure ones, if most of it is pure.

    Soft light beside a shape looks like a mix of it and something else.
    """
    pure = own & (share == 1.0)
    if pure.sum() < 0.5 * own.sum():
        return own
    return own & ndimage.binary_dilation(pure, np.ones((3, 3)))


def painted(regions: Regions, label: NDArray[np.int32]) -> Floats:
    """Return the colours of ``regions`` by a map of their numbers, ``label`` [h, w], over black and white [h, w, 6]."""
    columns, rows = np.meshgrid(*(np.arange(size, dtype=np.float32) + 0.5 for size in label.shape[::-1]))
    mixed = 255.0 * regions.paints.at(label, columns, rows).astype(np.float64)
    return np.concatenate([mixed[..., :3], mixed[..., :3] + 255.0 - mixed[..., 3:]], 2)


def _near_edges(label: NDArray[np.int32]) -> Mask:
    """Return the pixels [h, w] near the edges of a map of regions, ``label`` [h, w], but not at them.

    There is the noise of a JPEG, which has none in still areas.
    """
    edge = ndimage.maximum_filter(label, 3) != ndimage.minimum_filter(label, 3)
    return ndimage.binary_dilation(edge, iterations=6) & ~ndimage.binary_dilation(edge, iterations=2)


@dataclass(frozen=True, eq=False)
class _Map:
    """The ``pieces`` [h, w] of a picture, and its sharp ``edges`` [h, w]."""

    pieces: NDArray[np.int32]
    edges: Mask

    def reached(self, own: NDArray[np.int32]) -> Mask:
        """Return which pieces a ground of its ``own`` reaches [P]: it mostly meets them without an edge."""
        first, second, is_edge = self._borders
        count = int(self.pieces.max()) + 1
        soft = np.zeros(count, np.bool_)
        soft[own] = True
        while True:
            meets = soft[first] & ~soft[second]
            all_met, sharp = (np.bincount(second[meets], weight[meets], count) for weight in (self._ones, is_edge))
            more = (all_met > 0) & (sharp < SOFTNESS.reached_share * all_met)
            if not more.any():
                return soft
            soft |= more

    @cached_property
    def _borders(self) -> tuple[NDArray[np.int32], NDArray[np.int32], Mask]:
        return borders(self.pieces, ndimage.binary_dilation(self.edges, np.ones((3, 3))))

    @cached_property
    def _ones(self) -> Floats:
        return np.ones(len(self._borders[0]))


def _ground(levels: Floats, area: Mask, around: _Map, is_outer: bool, noise_min: float) -> TracedGround | None:
    """Return an ``area`` [h, w] of one region as the ground; None if it has not one colour or gradient."""
    if area.sum() < SOFTNESS.zone_area:
        return None
    found = _flat(levels, area) or _graded(levels, area)
    if found is None and not is_outer:
        return None
    pieces = around.pieces
    soft = around.reached(np.unique(pieces[area]))
    soft[0] = True  # pixels of no piece
    is_soft = soft[pieces]
    region = np.ones_like(area) if is_outer else with_filled_holes(is_soft)
    covering = np.where(region & ~is_soft, pieces, 0)
    is_open = region & is_soft & ~ndimage.binary_dilation(covering > 0, np.ones((3, 3)))
    found = found or _shaded(levels, is_open, covering > 0)
    if found is None:
        return None
    below, color, is_flat, noise = found
    noise = max(noise, noise_min)
    ground = TracedGround(color, below, is_flat, noise, region, is_open, is_open, covering)
    return ground.after(levels)


def _cut_where_reached(regions: Regions, around: _Map, area: Mask) -> _Map:
    """Return the map with the pieces cut at its edges that a ground in an ``area`` [h, w] reaches.

    A tracing takes soft light for more of a shape of nearly its colour, and so ends the shape where there is no edge.
    """
    own = np.unique(around.pieces[area])
    soft = around.reached(own)
    soft[own] = False
    inner = around.edges & soft[around.pieces]
    return replace(around, pieces=_pieces(regions, inner)) if inner.any() else around


def borders(pieces: NDArray[np.int32], marked: Mask) -> tuple[NDArray[np.int32], NDArray[np.int32], Mask]:
    """Return the pieces on either side of each border of two pixels, both ways [B], and if one is ``marked`` [B].

    ``pieces`` and ``marked`` are maps [h, w].
    """
    whole, pairs = pieces, []
    if not pieces.all():
        _, (y, x) = ndimage.distance_transform_edt(pieces == 0, return_indices=True)
        whole = pieces[y, x]
    for one, two, edge in (
        (whole[1:], whole[:-1], marked[1:] | marked[:-1]),
        (whole[:, 1:], whole[:, :-1], marked[:, 1:] | marked[:, :-1]),
    ):  # fmt: skip
        is_border = one != two
        pairs += [(one[is_border], two[is_border], edge[is_border]), (two[is_border], one[is_border], edge[is_border])]
    first, second, is_marked = (np.concatenate(each) for each in zip(*pairs, strict=True))
    return first, second, is_marked


def _pieces(regions: Regions, edges: Mask | None = None) -> NDArray[np.int32]:
    """Return the number of the connected piece of a region that each pixel [h, w] lies in, from 1 on.

    Where ``edges`` [h, w] run through a region, it is cut.
    """
    found, count = np.zeros(regions.label.shape, np.int32), 0
    for k, box in enumerate(ndimage.find_objects(regions.label + 1)):
        if box is not None:
            own = _without_blends(regions.label[box] == k, regions.share[box])
            parts, more = ndimage.label(own, np.ones((3, 3)))
            if edges is not None:
                parts, more = _cut(parts, more, edges[box])
            found[box] += np.where(own, parts + count, 0).astype(np.int32)
            count += more
    return found


def _cut(pieces: NDArray[np.int32], count: int, edges: Mask) -> tuple[NDArray[np.int32], int]:
    """Return a ``count`` of ``pieces`` [h, w] cut at ``edges`` [h, w], and how many there are then.

    Pixels at an edge belong to the nearest part; a piece without a part large enough, such as a thin line, stays.
    """
    parts, more = ndimage.label((pieces > 0) & ~edges)
    is_large = np.bincount(parts.ravel()) >= SOFTNESS.piece_area
    is_large[0] = False
    if is_large.sum() < 2:
        return pieces, count
    parts = np.where(is_large[parts], parts, 0)
    is_thin = ~np.isin(pieces, pieces[parts > 0])
    parts = np.where(is_thin & (pieces > 0), pieces + more, parts)
    _, (y, x) = ndimage.distance_transform_edt(parts == 0, return_indices=True)
    numbers, cut = np.unique(np.append(0, np.where(pieces > 0, parts[y, x], 0)), return_inverse=True)
    return np.asarray(cut[1:].reshape(pieces.shape), np.int32), len(numbers) - 1


def _sharp_edges(levels: Floats, bend_max: float) -> Mask:
    """Return the pixels [h, w] at which the second difference of neighbours in ``levels`` [h, w, C] is large."""
    along = (np.abs(ndimage.correlate1d(levels, [1.0, -2.0, 1.0], axis, mode="nearest")) for axis in (0, 1))
    bends = np.maximum(*map(largest_channel, along))
    return np.asarray(bends > bend_max)


def _flat(levels: Floats, area: Mask) -> tuple[Floats, Floats, bool, float] | None:
    """Return colours, middle colour, whether it is flat, and noise of an ``area`` [h, w] of one colour; None if not."""
    color = np.median(levels[area], axis=0)
    away = np.abs(levels[area] - color).max(1)
    noise = _noise_of(levels, area)
    # Ringing of a JPEG bends less than noise does.
    factor, more = SOFTNESS.ringing_max
    noise = float(np.clip(np.quantile(away, SOFTNESS.ringing), noise, factor * noise + more))
    if (away <= SOFTNESS.alike + SOFTNESS.noises * noise).mean() < SOFTNESS.flat_share:
        return None
    return np.broadcast_to(color, levels.shape), color, True, noise


def _noise_of(levels: Floats, area: Mask, is_uneven: bool = False) -> float:
    """Return the standard deviation of noise of a picture in an ``area`` [h, w], by second differences along rows.

    That of a JPEG ``is_uneven``, so that the median of the differences says too little.
    """
    if not area.any():
        return 0.0
    bends = ndimage.correlate1d(levels, [1.0, -2.0, 1.0], 1, mode="nearest")[area]
    if is_uneven:
        return float(np.sqrt(np.mean(bends * bends) / 6.0))
    return float(np.median(np.abs(bends)) / 0.6745 / 6.0**0.5)


def _graded(levels: Floats, area: Mask) -> tuple[Floats, Floats, bool, float] | None:
    """Return what `_flat` does of an ``area`` [h, w] of a gradient along a line, most of which is that; None if not."""
    rows, columns = np.nonzero(area)
    if len(rows) > SOFTNESS.graded_samples:
        chosen = np.random.default_rng(0).choice(len(rows), SOFTNESS.graded_samples, replace=False)
        rows, columns = rows[chosen], columns[chosen]
    places = np.stack([np.ones(len(rows)), columns, rows], 1)
    colors, noise = levels[rows, columns], _noise_of(levels, area)
    is_like, like = np.ones(len(rows), np.bool_), SOFTNESS.alike + SOFTNESS.noises * noise
    for _ in range(SOFTNESS.graded_rounds):
        slopes = np.linalg.lstsq(places[is_like], colors[is_like], rcond=None)[0]
        rest = np.abs(colors - places @ slopes).max(1)
        is_like = rest <= max(like, float(np.median(rest)))
    if (rest <= like).mean() < SOFTNESS.flat_share:
        return None
    y, x = np.indices(area.shape)
    below = np.clip(np.stack([np.ones(x.shape), x, y], 2) @ slopes, 0.0, 255.0)
    return below, np.median(below[rows, columns], axis=0), False, noise


def _shaded(levels: Floats, area: Mask, casters: Mask) -> tuple[Floats, Floats, bool, float] | None:
    """Return what `_flat` does of an ``area`` [h, w] of a gradient that ``casters`` [h, w] shade; None if not."""
    below = fit_shaded_ground(levels, area, casters)
    return None if below is None else (below, np.median(below[area], axis=0), False, _noise_of(levels, area))


def _smooth_change(change: Floats, noise: float) -> Floats:
    """Return the largest channel of a ``change`` [h, w, C], without most of its noise."""
    return largest_channel(np.abs(ndimage.gaussian_filter(change, (1.0, 1.0, 0.0)) if noise > 0.3 else change))
