"""Pixels inside regions and at their seams, which show nothing but the paints of one or two regions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers, Integers32, Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.color_moments import moments_of
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.ramp_joining import Pair, Shown
from warpvec.geometry.paints.registry import FLAT


@dataclass(frozen=True, eq=False)
class InsidePixels:
    """N pixels in whose squares of 3 x 3 no more than two regions have a share, or one.

    Attributes:
        label: region of each [N].
        first, second: the two regions [N], the smaller number first; equal inside a region.
        points: centres x, y [N, 2].
        colors: colours [N, 3].
        off: differences of these from what the paints and shares of the regions show [N, 3].
    """

    label: Integers32
    first: Integers32
    second: Integers32
    points: Floats
    colors: Floats
    off: Floats

    @staticmethod
    def of(image: Floats32, assignment: Assignment, paints: Paints) -> InsidePixels:
        """Return those of ``image`` [h, w, 4], sRGB with straight alpha."""
        label, other = assignment.label, assignment.other
        first = ndimage.minimum_filter(np.minimum(label, other), 3, mode="nearest")
        second = ndimage.maximum_filter(np.maximum(label, other), 3, mode="nearest")
        is_of_two = _are_all_around(label, first, second) & _are_all_around(other, first, second)
        rows, columns = np.nonzero(is_of_two)
        points = np.stack([columns, rows], 1).astype(np.float64) + 0.5
        colors = image[rows, columns, :3].astype(np.float64)
        share = assignment.share[rows, columns, None]
        own, beside = (seen(paints, part[rows, columns], points) for part in (label, other))
        off = colors - share * own - (1 - share) * beside
        return InsidePixels(label[rows, columns], first[rows, columns], second[rows, columns], points, colors, off)

    def of_regions(self, is_chosen: Mask) -> InsidePixels:
        """Return the pixels of the regions ``is_chosen`` [K]."""
        chosen = is_chosen[self.first] & is_chosen[self.second]
        return InsidePixels(
            self.label[chosen], self.first[chosen], self.second[chosen], self.points[chosen], self.colors[chosen],
            self.off[chosen],
        )  # fmt: skip

    def are_typical(self, paints: Paints) -> Mask:
        """Return which regions [K] have enough pixels inside them, and a paint that is about their mean.

        Others have got pixels by loose mixes.
        """
        count, own, areas = len(paints), self.first == self.second, self.areas(len(paints))
        sums = np.stack([np.bincount(self.label[own], channel, count) for channel in self.off[own].T], 1)
        means = np.abs(sums / np.maximum(areas, 1)[:, None]).max(1)
        return (areas >= REGIONS.inside_area_min) & (means <= REGIONS.typical_max)

    def areas(self, count: int) -> Integers:
        """Return the number of pixels inside each of ``count`` regions."""
        return np.asarray(np.bincount(self.label[self.first == self.second], minlength=count), np.int64)

    def of_each_region(self) -> dict[int, tuple[Floats, Floats]]:
        """Return the centres [M, 2] and colours [M, 3] of the pixels inside each region that has some."""
        inside = np.flatnonzero(self.first == self.second)
        order = inside[np.argsort(self.label[inside], kind="stable")]
        names, starts = np.unique(self.label[order], return_index=True)
        parts = np.split(order, starts)[1:]
        return {name: (self.points[part], self.colors[part]) for name, part in zip(names.tolist(), parts, strict=True)}

    def shown(self, paints: Paints) -> tuple[dict[int, Shown], dict[Pair, Shown]]:
        """Return how well ``paints`` show the pixels inside regions, and those at the seams of two."""
        count = len(paints)
        pairs, index = np.unique(self.first.astype(np.int64) * count + self.second, return_inverse=True)
        moments = moments_of(index, self.colors, self.points, len(pairs))
        rests = np.bincount(index, (self.off**2).sum(1), len(pairs))
        regions: dict[int, Shown] = {}
        seams: dict[Pair, Shown] = {}
        for key, sums, rest in zip(pairs.tolist(), moments, rests.tolist(), strict=True):
            first, second = divmod(key, count)
            if first == second:
                is_flat = bool(paints.kind[first] == FLAT)
                regions[first] = Shown(sums, sums.flat_rest() if is_flat else rest, is_flat)
            elif sums.count >= REGIONS.joint_border_min:
                seams[first, second] = Shown(sums, rest)
        return regions, seams


def _are_all_around(label: Integers32, first: Integers32, second: Integers32) -> Mask:
    """Return where all of 3 x 3 pixels have one of two labels; all arrays are [h, w]."""
    padded = np.pad(label, 1, mode="edge")
    height, width = label.shape
    result = np.ones(label.shape, bool)
    for row in range(3):
        for column in range(3):
            part = padded[row : row + height, column : column + width]
            result &= (part == first) | (part == second)
    return result


def seen(paints: Paints, label: Integers32, points: Floats) -> Floats:
    """Return the colours [N, 3] that the opaque ``paints`` of the regions ``label`` [N] have at ``points`` [N, 2]."""
    x, y = points.astype(np.float32).T
    return paints.at(label, x, y)[:, :3].astype(np.float64)
