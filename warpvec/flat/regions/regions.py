"""The regions of a picture: areas of one paint, and how the pixels between them are mixed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from warpvec.arrays import Floats, Floats32, Integers32, Mask, Places
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.evidence.evidence import Evidence
from warpvec.flat.price import COLOR_NATS, RAMP_NUMBERS, number_nats
from warpvec.flat.regions.assignment import Assignment, assign
from warpvec.flat.regions.joint_ramps import with_joint_ramps
from warpvec.flat.regions.lettering import with_lettering
from warpvec.flat.regions.noise import Tolerances, measure_tolerances
from warpvec.flat.regions.paint_fitting import fit_paints
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE, pixels_of
from warpvec.flat.regions.region_merging import merge_regions
from warpvec.flat.regions.seeding import find_seeds
from warpvec.flat.regions.specks import SpeckLimits
from warpvec.flat.regions.thin_parts import add_thin_parts
from warpvec.geometry.paints.registry import FLAT
from warpvec.watch.watch import UNWATCHED, Watch

_OUTLINE_NUMBERS = 8
"""Numbers of the simplest outline of a region, four lines. What more an outline has, its mixed pixels pay for."""


class NotFlatArtError(Exception):
    """A picture is plainly no flat art. The message says why."""


@dataclass(frozen=True, eq=False)
class Regions:
    """K regions of a picture of h x w pixels. A pixel between two regions is a mix of both.

    Attributes:
        label: region with the largest share of each pixel [h, w] (int32).
        other: region that has the rest of each pixel [h, w] (int32); equal to ``label`` in pure pixels.
        share: share of ``label`` in each pixel [h, w] (float32), in [0.5, 1].
        paints: paints of the regions [K]; the opacity is 0 where the picture is transparent.
        canvas: region that fills the canvas behind all others; None if the picture has no such region.
        is_lettering: words of small thin marks [K]; None for no such regions. They need not be connected, and may have
            the smaller share of most of their pixels.
        noise: noise of the picture, in [0, 1]; 0 if it is clean.
    """

    label: Integers32
    other: Integers32
    share: Floats32
    paints: Paints
    canvas: int | None = None
    is_lettering: Mask | None = None
    noise: float = 0.0

    def __len__(self) -> int:
        return len(self.paints)

    @cached_property
    def pure_pixels(self) -> list[Places]:
        """The pixels of each region [K] that show nothing else, numbered by rows."""
        pure = np.where(self.share == 1.0, self.label, NONE)
        own = pixels_of(pure)
        return own + [np.zeros(0, np.int64)] * (len(self) - len(own))

    def lettering_among(self, rows: Any) -> Mask | None:
        """Return which of the regions ``rows`` are words of small thin marks; None if the picture has none."""
        return None if self.is_lettering is None else self.is_lettering[rows]

    def mixed(self) -> Floats32:
        """Return the picture that the regions, their paints and shares state: premultiplied RGBA [h, w, 4]."""
        y, x = np.indices(self.label.shape, np.float32) + np.float32(0.5)
        share = self.share[..., None]
        return share * self.paints.at(self.label, x, y) + (1 - share) * self.paints.at(self.other, x, y)

    def shown(self) -> Floats:
        """Return the picture that the regions state over white [h, w, 3], in [0, 255]."""
        mixed = self.mixed().astype(np.float64)
        return np.asarray(255.0 * (mixed[..., :3] + 1.0 - mixed[..., 3:]))

    def nats(self, evidence: Evidence, added: Floats | None = None) -> float:
        """Return the nats of the regions, and of what they leave of the picture of ``evidence``.

        To what they show something may be ``added`` [h, w, 3], in levels, whose words are not counted.

        A region says its outline and its paint. A mixed pixel says its share, to the deviation of the pixels: that
        takes the more, the farther its two paints are apart.
        """
        number, ramp_count = number_nats(max(self.label.shape)), int((self.paints.kind != FLAT).sum())
        stated = len(self) * (_OUTLINE_NUMBERS * number + COLOR_NATS)
        stated += ramp_count * (RAMP_NUMBERS * number + COLOR_NATS)
        y, x = np.nonzero(self.share < 1.0)
        places = x.astype(np.float32) + np.float32(0.5), y.astype(np.float32) + np.float32(0.5)
        one, other = (self.paints.at(label[y, x], *places) for label in (self.label, self.other))
        contrast = 255.0 * np.abs(one - other).max(1, initial=0.0)
        stated += float(np.log(np.maximum(contrast / evidence.sigma.mean(), 1.0)).sum())
        shown = self.shown() if added is None else self.shown() + added
        return stated + float(evidence.misfit(shown).sum())


def find_regions(
    image: Floats32,
    min_area: float = 0.0,
    watch: Watch = UNWATCHED,
    may_refuse: bool = False,
    noise_min: float = 0.0,
    is_jpeg: bool = False,
) -> Regions:
    """Return the regions of flat art.

    Args:
        image: picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        min_area: areas of fewer pixels are left out, and in any case those of fewer than two to four,
            unless they stand out.
        watch: the watch over the run. When it is over, rougher regions must do.
        may_refuse: whether to refuse a picture that is plainly no flat art.
        noise_min: the least noise that it is known to have, in [0, 1].
        is_jpeg: whether it was saved as JPEG.

    Raises:
        NotFlatArtError: the picture has no pure areas, or more than ``seeds_max``.
    """
    tolerances = measure_tolerances(premultiplied(image), noise_min, not is_jpeg)
    plain = _regions_of(image, tolerances, min_area, watch, may_refuse)
    is_icon = max(image.shape[:2]) <= REGIONS.shaded_side
    if not is_icon or tolerances.noise > 0 or watch.is_over():
        return plain
    shaded = _regions_of(image, tolerances, min_area, watch, follows_shading=True)
    evidence = Evidence.of(image)
    return min(shaded, plain, key=lambda regions: regions.nats(evidence))


def _regions_of(
    image: Floats32,
    tolerances: Tolerances,
    min_area: float,
    watch: Watch,
    may_refuse: bool = False,
    follows_shading: bool = False,
) -> Regions:
    """Return the regions of flat art. With ``follows_shading``, areas grow where their shading goes on.

    The other arguments are those of `find_regions`, and the ``tolerances`` of the picture.
    """
    picture, straight = premultiplied(image), with_alpha(image)
    limits = _speck_limits(min_area, image.shape, tolerances)
    seeds = find_seeds(picture, straight, tolerances, watch, follows_shading)
    if may_refuse:
        _require_flat_art(seeds)
    if (seeds == NONE).all():
        seeds = np.zeros_like(seeds)
    paints, seeds = fit_paints(straight, seeds, tolerances, watch)
    canvas = find_canvas(seeds, paints)
    behind = None if canvas is None else paints.select(np.array([canvas]))
    assignment = assign(picture, seeds, paints, tolerances, canvas)
    paints = add_thin_parts(picture, assignment, paints, tolerances, limits, canvas, watch)
    assignment, paints = merge_regions(picture, assignment, paints, tolerances, limits, canvas, watch)
    is_noisy = tolerances.noise > 0
    rest = math.inf if is_noisy else _rest(straight, assignment, paints)
    if rest > REGIONS.explained_max:
        below = _canvas_like(behind, assignment.label, paints)
        paints = with_joint_ramps(straight, assignment, paints, tolerances, below, watch)
    if is_noisy:
        paints = paints.with_whole_ends(REGIONS.noisy_end)
    is_lettering = None
    # Blur and noise mix more than two paints in a pixel.
    is_plain = tolerances.noise <= LETTERING.noise_max and tolerances.reach <= REGIONS.sharp_reach
    if is_plain and not watch.is_over():
        worded = with_lettering(picture, assignment, paints, tolerances, min_area, limits.clear_area)
        assignment, paints, is_lettering = worded
    label, other, share = assignment.label, assignment.other, assignment.share
    canvas = _canvas_like(behind, label, paints)
    return Regions(label, other, share, paints, canvas, is_lettering, tolerances.noise)


def require_few_edges(regions: Regions) -> None:
    """Refuse a picture whose ``regions`` have as many edges as only a pattern has.

    Raises:
        NotFlatArtError: they have more than `edges_max`, and more than `edges_share_max` of all pixels.
    """
    label = regions.label
    count = int((label[1:] != label[:-1]).sum() + (label[:, 1:] != label[:, :-1]).sum())
    if count > max(REGIONS.edges_max, REGIONS.edges_share_max * label.size):
        raise NotFlatArtError(f"its areas have {count:,} pixels of edges")


def _rest(image: Floats32, assignment: Assignment, paints: Paints) -> float:
    """Return what regions that are not complete yet leave of an ``image`` [h, w, 4]; see `unexplained`."""
    return unexplained(Regions(assignment.label, assignment.other, assignment.share, paints).mixed(), image)


def unexplained(shown: Floats32, image: Floats32, where: Mask | None = None) -> float:
    """Return the root mean square in levels that a picture leaves of the colours of an ``image``.

    Args:
        shown: the picture, premultiplied RGBA [h, w, 4], as `Regions.mixed` returns it.
        image: the image [h, w, 3 or 4], with straight alpha if it has four channels.
        where: the pixels [h, w] that count; None for all.
    """
    difference = (shown - premultiplied(image))[..., :3]
    return 255.0 * float(np.sqrt(np.mean((difference if where is None else difference[where]) ** 2)))


def _require_flat_art(seeds: Integers32) -> None:
    count = int(seeds.max()) + 1
    if count == 0:
        raise NotFlatArtError("it has no areas of one colour")
    if count > REGIONS.seeds_max:
        raise NotFlatArtError(f"it has {count:,} separate areas of one colour")


def _speck_limits(min_area: float, shape: tuple[int, ...], tolerances: Tolerances) -> SpeckLimits:
    """Return the areas in pixels below which areas are specks, at least the ``min_area`` asked for."""
    if tolerances.reach > REGIONS.sharp_reach:
        least = REGIONS.soft_speck_area * tolerances.reach**2
        return SpeckLimits(max(min_area, least), max(min_area, least))
    least = REGIONS.speck_area if max(shape[:2]) > REGIONS.icon_size else REGIONS.speck_area_of_icons
    clear = least if tolerances.noise > 0 else REGIONS.clear_speck_area
    return SpeckLimits(max(min_area, least), max(min_area, clear))


def with_alpha(image: Floats32) -> Floats32:
    """Return ``image`` [h, w, 3 or 4] with an alpha channel [h, w, 4]."""
    if image.shape[-1] == 4:
        return image.astype(np.float32)
    return np.concatenate([image, np.ones((*image.shape[:2], 1), np.float32)], -1).astype(np.float32)


def premultiplied(image: Floats32) -> Floats32:
    """Return ``image`` [h, w, 3 or 4] as premultiplied RGBA [h, w, 4]."""
    result = with_alpha(image)
    result[..., :3] *= result[..., 3:]
    return result


def find_canvas(label: Integers32, paints: Paints, is_behind: Mask | None = None) -> int | None:
    """Return the region of the map ``label`` [h, w] behind all others, or None.

    Of the regions at the border it is the longest that is clear. If none is, it is the longest that ``is_behind`` [K];
    without that mask it is the longest of all, if its paint is flat and has a large share. Pixels that are ``NONE`` say
    nothing.
    """
    border = np.concatenate([label[0], label[-1], label[:, 0], label[:, -1]])
    count = np.bincount(border[border != NONE], minlength=len(paints))
    clear = np.where(paints.opacity == 0, count, 0)
    if clear.any():
        return int(clear.argmax())
    if is_behind is not None and count[is_behind].any():
        return int(np.where(is_behind, count, 0).argmax())
    first = int(count.argmax())
    alike = (paints.color == paints.color[first]).all(1) & (paints.opacity == paints.opacity[first])
    known = max(float(count.sum()), REGIONS.canvas_known_share * len(border))
    most = min(REGIONS.canvas_border_share * len(border), REGIONS.canvas_pure_share * known)
    return first if paints.kind[first] == FLAT and count[alike].sum() >= most else None


def _canvas_like(behind: Paints | None, label: Integers32, paints: Paints) -> int | None:
    """Return the canvas of the map ``label`` [h, w]. If the paint ``behind`` all is known, the canvas looks like it."""
    return find_canvas(label, paints, None if behind is None else _looks_like(paints, behind))


def _looks_like(paints: Paints, one: Paints) -> Mask:
    """Return which of ``paints`` [K] are flat and have about the colour of the paint ``one``."""
    difference = np.abs(paints.premultiplied() - one.premultiplied()).max(1)
    return np.asarray((paints.kind == FLAT) & (difference <= REGIONS.canvas_difference))
