"""A chain: a loop of an outline, or a centre line, as points that are close together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Integers, Mask, counted, dot, turn_between
from warpvec.flat.chains.parts import unit
from warpvec.flat.cutting.cut_edges import between
from warpvec.flat.simplification.outline_samples import cubic_points, cubic_slopes

STEP = 1.0
"""Distance of the points of a chain in pixels: places of nodes are then solved for."""

POINTS_MAX = 240
"""Most points of a chain, but for those of short curves: each pair of points is looked at."""

CURVE_POINTS_MIN = 4
"""Fewest points of a curve."""

RATIO_MAX = 4.0
"""Largest factor by which handles may say another ratio of two curves than their lengths: tiny handles say nothing."""

FIRMNESS, FIRM_MAX = 4.0, 4
"""Factor of the weight of squared distances in each box in which a chain must be kept better, and most such boxes."""

CORNER_DEGREES = 12.0
"""Turn at a node of curves from which it surely is a corner. Fitted curves turn by less where the picture is smooth."""


HIDDEN = 0.02
"""Factor of the weight of distances where nothing shows the line: other strokes cover both edges, or other paths."""


class Cover(NamedTuple):
    """The other strokes of one look.

    Attributes:
        tree: of points along their centre lines, at most about a pixel apart.
        half: half of their width in pixels.
    """

    tree: cKDTree
    half: float

    def hides(self, points: Floats, along: Floats) -> Mask:
        """Return where on a centre line both edges lie under other strokes: at ``points`` [K, 2], by its direction."""
        across = self.half * np.stack([-along[:, 1], along[:, 0]], 1)
        found: Mask = np.maximum(*(self.tree.query(points + side * across)[0] for side in (-1.0, 1.0))) < self.half
        return found


class Shown(NamedTuple):
    """How well a picture shows an outline.

    Attributes:
        tree: of points along it.
        share: how well the place of each can be told [K], from 0 to 1.
        is_hidden: which of them other paths hide [K].
    """

    tree: cKDTree
    share: Floats
    is_hidden: Mask

    def near(self, points: Floats) -> Integers:
        """Return the number of its point that is nearest to each of ``points`` [K, 2]."""
        found: Integers = self.tree.query(points)[1]
        return found


@dataclass(frozen=True, eq=False)
class Chain:
    """K points along curves that follow one another.

    Attributes:
        curves: control points [S, 4, 2].
        points: the points [K, 2] px; the last of a closed chain is the first.
        middles: points halfway between two of them, along the curves [K - 1, 2].
        lengths: lengths from point to point [K - 1] px.
        before, after: unit directions in which the curves arrive at and leave each point [K, 2].
        is_corner: points that no part passes [K]; the ends are such points.
        curve: the curve between each point and the next [K - 1], and its parameter at each point there [K - 1, 2].
        is_closed: whether the chain is closed.
        firm: boxes [B, 2, 2], least and greatest coordinates, in which it must be kept better.
        weights: how well it must be kept between its points [K - 1].
        cover: the strokes that cover some of it; None for none.
        shown: how well the picture shows it; None for well everywhere.
        is_traced: whether its curves are short pieces along a traced outline. Parts may pass its corners then, which
            are only supposed.
        freed: boxes [B, 2, 2] in which its parts have numbers of their own, off any grid; None for none.
    """

    curves: Floats
    points: Floats
    middles: Floats
    lengths: Floats
    before: Floats
    after: Floats
    is_corner: Mask
    curve: Integers
    parameters: Floats
    is_closed: bool
    firm: Floats
    weights: Floats
    cover: Cover | None = None
    shown: Shown | None = None
    is_traced: bool = False
    freed: Floats | None = None

    @staticmethod
    def of(
        curves: Floats, is_closed: bool, firm: Floats | None = None, cover: Cover | None = None,
        shown: Shown | None = None, is_traced: bool = False,
    ) -> Chain:  # fmt: skip
        """Return the chain of ``curves`` [S, 4, 2], which must be kept better in the boxes ``firm`` [B, 2, 2].

        What is hidden has no corners, and must hardly be kept.
        """
        length = np.linalg.norm(np.diff(curves, axis=1), axis=2).sum(1)
        step = max(STEP, float(length.sum()) / POINTS_MAX)
        counts = np.maximum(np.ceil(length / step).astype(np.int64), 1 if is_traced else CURVE_POINTS_MIN)
        curve = np.repeat(np.arange(len(curves)), counts)
        number = counted(counts)
        parameters = np.stack([number / counts[curve], (number + 1) / counts[curve]], 1)
        own = curves[curve]
        ends = cubic_points(own, parameters)
        middles = cubic_points(own, parameters.mean(1, keepdims=True))[:, 0]
        ways = _directions(own, parameters)
        points = np.concatenate([ends[:1, 0], ends[:, 1]])
        after, before = np.concatenate([ways[:, 0], ways[-1:, 1]]), np.concatenate([ways[:1, 0], ways[:, 1]])
        if is_closed:
            before[0], after[-1] = before[-1], after[0]
        is_corner = angle_between(before, after) > CORNER_DEGREES
        firm = np.zeros((0, 2, 2)) if firm is None else firm
        weights = _weights(middles, firm)
        if cover is not None:
            is_corner &= ~cover.hides(points, unit(before + after))
            weights[cover.hides(middles, unit(points[1:] - points[:-1]))] *= HIDDEN
        if shown is not None:
            is_corner &= ~shown.is_hidden[shown.near(points)]
            weights *= np.maximum(shown.share[shown.near(middles)], HIDDEN)
        is_corner[[0, -1]] |= not is_closed
        return Chain(
            curves, points, middles, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), before, after, is_corner, curve,
            parameters, is_closed, firm, weights, cover, shown, is_traced,
        )  # fmt: skip

    def firmer_in(self, boxes: Floats) -> Chain:
        """Return the chain that must be kept better in more ``boxes`` [B, 2, 2]."""
        return replace(self, firm=np.concatenate([self.firm, boxes])).of_curves(self.curves, self.is_closed)

    def freed_in(self, boxes: Floats | None) -> Chain:
        """Return the chain whose parts in more ``boxes`` [B, 2, 2] have numbers of their own."""
        known = [each for each in (self.freed, boxes) if each is not None]
        return replace(self, freed=np.concatenate(known) if known else None)

    def is_freed(self, first: int, last: int) -> bool:
        """Return whether most of a part between two points lies in a box where it has numbers of its own."""
        if self.freed is None:
            return False
        is_in, lengths = _are_in(self.middles[first:last], self.freed).any(0), self.lengths[first:last]
        return bool(lengths[is_in].sum() > 0.5 * lengths.sum())

    def of_curves(self, curves: Floats, is_closed: bool) -> Chain:
        """Return a chain of other ``curves`` [S, 4, 2] of which the same is known."""
        found = Chain.of(curves, is_closed, self.firm, self.cover, self.shown, self.is_traced)
        return found.freed_in(self.freed)

    @cached_property
    def along(self) -> Floats:
        """Direction of the chain at each point [K, 2]: the mean of both sides."""
        return unit(self.before + self.after)

    @cached_property
    def dense(self) -> Floats:
        """Points along the chain, at most about a pixel apart [D, 2]."""
        count = int(np.ceil(self.lengths.max() / STEP)) + 1
        t = np.linspace(0.0, 1.0, count)[:-1]
        low, high = self.parameters[:, :1], self.parameters[:, 1:]
        inner = cubic_points(self.curves[self.curve], low + (high - low) * t)
        return np.concatenate([inner.reshape(-1, 2), self.points[-1:]])

    @cached_property
    def shared_parameters(self) -> Floats:
        """A parameter of each point [K] by which consecutive curves are parts of one, if they are.

        Parts of one curve have handles in the ratio of their shares of its parameter.
        """
        length = np.linalg.norm(np.diff(self.curves, axis=1), axis=2)
        by_length = length[1:].sum(1) / np.maximum(length[:-1].sum(1), 1e-9)
        ratio = length[1:, 0] / np.maximum(length[:-1, 2], 1e-9)
        shares = np.cumprod(np.append(1.0, np.clip(ratio, by_length / RATIO_MAX, by_length * RATIO_MAX)))
        begins = np.cumsum(shares) - shares
        return np.append(begins[self.curve] + shares[self.curve] * self.parameters[:, 0], shares.sum())

    @cached_property
    def reached(self) -> Floats:
        """Length of the chain up to each point [K], in pixels."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    def length_between(self, first: Integers, last: Integers) -> Floats:
        """Return the length of the chain between points [B] and later ones."""
        return self.reached[last] - self.reached[first]

    def turn_along(self, first: Integers, last: Integers) -> Floats:
        """Return the angle in radians by which the chain turns between points [B] and later ones, without these.

        It is positive clockwise on a screen.
        """
        inner, at = (turn_between(*ways) for ways in ((self.after[:-1], self.before[1:]), (self.before, self.after)))
        up_to = np.append(0.0, np.cumsum(inner + at[1:]))
        found: Floats = up_to[last] - at[last] - up_to[first]
        return found

    def begun_at(self, point: int) -> Chain:
        """Return a closed chain from another point on, which is the end of a curve then."""
        if point in (0, len(self.points) - 1):
            return self
        curve, t = int(self.curve[point]), float(self.parameters[point, 0])
        if t == 0.0:
            return self.of_curves(np.roll(self.curves, -curve, axis=0), is_closed=True)
        first, second = between(self.curves[[curve, curve]], np.array([0.0, t]), np.array([t, 1.0]))
        rest = [*self.curves[curve + 1 :], *self.curves[:curve]]
        return self.of_curves(np.stack([second, *rest, first]), is_closed=True)


def _weights(points: Floats, boxes: Floats) -> Floats:
    """Return how well a chain must be kept at ``points`` [K, 2]: ``FIRMNESS`` for each of ``boxes`` [B, 2, 2] there."""
    found: Floats = FIRMNESS ** np.minimum(_are_in(points, boxes).sum(0), FIRM_MAX).astype(np.float64)
    return found


def _are_in(points: Floats, boxes: Floats) -> Mask:
    """Return in which of ``boxes`` [B, 2, 2] each of the ``points`` [K, 2] lies, or within a pixel of it [B, K]."""
    is_in = (points >= boxes[:, None, 0] - 1.0) & (points <= boxes[:, None, 1] + 1.0)
    found: Mask = np.all(is_in, axis=2)
    return found


def _directions(curves: Floats, parameters: Floats) -> Floats:
    """Return the unit directions [K, 2, 2] of ``curves`` [K, 4, 2] at two parameters each, that of chords at cusps."""
    slopes = cubic_slopes(curves, parameters)
    inner = cubic_slopes(curves, np.clip(parameters, 0.02, 0.98))
    is_cusp = np.linalg.norm(slopes, axis=-1, keepdims=True) < 1e-3
    return unit(np.where(is_cusp, inner, slopes))


def angle_between(first: Floats, second: Floats) -> Floats:
    """Return the angle in degrees between unit vectors [..., 2]."""
    return np.degrees(np.arccos(np.clip(dot(first, second), -1.0, 1.0)))
