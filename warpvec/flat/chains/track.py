"""The chains of a sketch one after the other, so that the distances of all parts from them are taken at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, dot, lengths_of
from warpvec.flat.chains.chain import Chain


class Track(NamedTuple):
    """Chains with G points in all, and parts of them. From each point but the last of a chain a step leads to the next.

    Attributes:
        points, along: the points and the directions of the chains there [G, 2].
        way, normal: unit directions of each step, and across it [G, 2].
        span: its length in pixels [G].
        bend: how far its middle lies to the side [G].
        weights: how well it must be kept [G].
        first, last: the points between which each part is [P].
        lengths: those of the chains between them, in pixels [P].
    """

    points: Floats
    along: Floats
    way: Floats
    normal: Floats
    span: Floats
    bend: Floats
    weights: Floats
    first: Integers
    last: Integers
    lengths: Floats

    @staticmethod
    def of(chains: Sequence[Chain], chain: Integers, first: Integers, last: Integers) -> Track:
        """Return the track of ``chains`` and parts: the chain of each [P], and its ``first`` and ``last`` point [P]."""
        begins = np.cumsum([0, *(len(each.points) for each in chains)])[chain]
        points = np.concatenate([each.points for each in chains])
        middles = np.concatenate([part for each in chains for part in (each.middles, each.points[-1:])])
        weights = np.concatenate([part for each in chains for part in (each.weights, [0.0])])
        steps = np.append(np.diff(points, axis=0), np.zeros((1, 2)), 0)
        length = lengths_of(steps)
        way = steps / np.maximum(length, 1e-12)[:, None]
        normal = np.stack([-way[:, 1], way[:, 0]], 1)
        parts = zip(chain.tolist(), first.tolist(), last.tolist(), strict=True)
        return Track(
            points, np.concatenate([each.along for each in chains]), way, normal, np.maximum(length, 1e-9),
            dot(middles - points, normal), weights, begins + first, begins + last,
            np.array([chains[own].lengths[start:stop].sum() for own, start, stop in parts]),
        )  # fmt: skip

    def distances(self, parts: Integers, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return signed distances of ``points`` [B, S, 2] of ``parts`` [B] from their chains.

        Returns:
            the distances [B, S], normals [B, S, 2] and weights [B, S].
        """
        first, last = self.first[parts], self.last[parts]
        near = np.stack([self._nearest(*each) for each in zip(points, first.tolist(), last.tolist(), strict=True)])
        ahead = dot(points - self.points[near], self.along[near]) >= 0.0
        step = np.clip(np.where(ahead, near, near - 1), first[:, None], last[:, None] - 1)
        off, normal = points - self.points[step], self.normal[step]
        # The chain bends between its points: its middle says how far.
        share = np.clip(dot(off, self.way[step]) / self.span[step], 0.0, 1.0)
        residual = dot(off, normal) - 4.0 * share * (1.0 - share) * self.bend[step]
        length = self.lengths[parts] / points.shape[1]
        return residual, normal, np.sqrt(length[:, None] * self.weights[step])

    def _nearest(self, points: Floats, first: int, last: int) -> Integers:
        """Return the points of a part that are nearest to ``points`` [S, 2]."""
        off = points[:, None] - self.points[first : last + 1]
        nearest: Integers = first + dot(off, off).argmin(1)
        return nearest
