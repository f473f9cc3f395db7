"""The branches of a skeleton that are lines: without those of corners and rough edges, as exact as the outlines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.lines import LINES
from warpvec.flat.lines.local_skeleton import Grid, skeleton_of
from warpvec.flat.strokes.center_lines import going_on
from warpvec.flat.strokes.inner_disks import Boundary, Disks


@dataclass
class Branches:
    """The branches of a skeleton.

    Attributes:
        places: exact centres along each branch [M, 2] px.
        ends: the junctions at its ends; as in `warpvec.flat.strokes.skeleton.Graph`.
        kept: the branches that are lines.
        junctions: [J, 2] px.
        widths: of each branch [B] in pixels; 0 of one that is not kept.
    """

    places: list[Floats]
    ends: list[tuple[int, int] | None]
    kept: list[int]
    junctions: Floats
    widths: Floats


class _Web:
    """The branches of a skeleton while they are sorted out: ``radius`` is that of the disk at a place."""

    def __init__(self, grid: Grid, boundary: Boundary) -> None:
        self.scale, self.tree = grid.scale, cKDTree(boundary.points)
        graph, self.places, self.junctions = skeleton_of(grid)
        self.ends = list(graph.ends)
        self.alive = set(range(len(self.places)))
        self.radii = self.radius(self.junctions)

    def radius(self, places: Floats) -> Floats:
        found: Floats = self.tree.query(places)[0] if len(places) else np.zeros(0)
        return found

    def prune(self) -> None:
        """Remove the branches of corners and rough edges, the shortest first."""
        self.alive = {k for k in self.alive if not self._is_tiny_loop(k)}
        self._free_lone_ends()
        free = [k for k in self.alive if _free_end(self.ends[k]) is not None]
        for k in sorted(free, key=lambda k: len(self.places[k])):
            if self._is_spur(k):
                self.alive.discard(k)
        self._free_lone_ends()

    def _is_tiny_loop(self, k: int) -> bool:
        both = self.ends[k]
        if both is None or both[0] != both[1] or both[0] < 0:
            return False
        return len(self.places[k]) / self.scale <= LINES.loop_radii * self.radii[both[0]]

    def _free_lone_ends(self) -> None:
        meet = self._counts()
        for k in self.alive:
            both = self.ends[k]
            if both is not None:
                # An end that is alone at a junction is free.
                self.ends[k] = (both[0] if meet[both[0]] > 1 else -1, both[1] if meet[both[1]] > 1 else -1)

    def _counts(self) -> Integers:
        """Return the number of ends at each junction, and after them one for free ends [J + 1]."""
        found = [end for k in self.alive for end in self.ends[k] or ()]
        return np.bincount(np.array(found, np.int64) % (len(self.junctions) + 1), minlength=len(self.junctions) + 1)

    def _is_spur(self, k: int) -> bool:
        found = _free_end(self.ends[k])
        assert found is not None
        junction, is_start = found
        points = self.places[k] if is_start else self.places[k][::-1]
        length = np.linalg.norm(points[-1] - self.junctions[junction])
        tip, middle = self.radius(points[[-1, len(points) // 2]])
        if length + tip <= (1.0 + LINES.spur) * self.radii[junction]:
            return True
        # Towards a corner, disks shrink.
        return bool(length <= LINES.corner_spur * self.radii[junction] and tip <= LINES.corner_tip * middle)

    def merge(self, centers: dict[int, Floats]) -> None:
        """Make one junction of those whose disks overlap, or between which no ``centers`` are."""
        owner = np.arange(len(self.junctions))
        for k in sorted(self.alive):
            both = self.ends[k]
            if both is None or min(both) < 0 or both[0] == both[1]:
                continue
            length = len(self.places[k]) / self.scale
            if len(centers[k]) < 2 or length <= LINES.overlap * (self.radii[both[0]] + self.radii[both[1]]):
                owner[owner == owner[both[1]]] = owner[both[0]]
                self.alive.discard(k)
        for old in np.unique(owner):
            self.junctions[old] = self.junctions[owner == old].mean(0)
        for k in self.alive:
            both = self.ends[k]
            if both is not None:
                self.ends[k] = tuple(int(owner[end]) if end >= 0 else -1 for end in both)  # type: ignore[assignment]


def _free_end(both: tuple[int, int] | None) -> tuple[int, bool] | None:
    """Return the only junction of a branch, and whether the branch starts there; None if it has none or two."""
    if both is None or (both[0] < 0) == (both[1] < 0):
        return None
    return (both[0], True) if both[1] < 0 else (both[1], False)


def find_branches(grid: Grid, boundary: Boundary, disks: Disks) -> Branches:
    """Return the branches of the skeleton of the ink in ``grid``, which has this ``boundary``."""
    web, tree = _Web(grid, boundary), cKDTree(disks.centers)
    web.prune()
    found = {k: _centers(web, k, boundary, tree, disks) for k in web.alive}
    centers = {k: places for k, (places, _) in found.items()}
    web.merge(centers)
    kept = sorted(k for k in web.alive if len(centers[k]) > 1)
    widths = np.zeros(len(web.places))
    for k in kept:
        widths[k] = found[k][1]
    places = [centers.get(k, np.zeros((0, 2))) for k in range(len(web.places))]
    return Branches(places, web.ends, kept, web.junctions, widths)


def _centers(web: _Web, k: int, boundary: Boundary, tree: cKDTree, disks: Disks) -> tuple[Floats, float]:
    """Return exact centres along a branch, where its disks have the width of its surroundings, and its width."""
    places = web.places[k]
    outside = np.ones(len(places), bool)
    for junction in web.ends[k] or ():
        if junction >= 0:
            away = np.linalg.norm(places - web.junctions[junction], axis=1)
            outside &= away > LINES.junction_share * web.radii[junction]
    places = places[outside]
    if len(places) < 2:
        return np.zeros((0, 2)), 0.0
    distance, nearest = tree.query(places)
    width = 2.0 * disks.radii[nearest]
    usual = float(np.median(width))
    reach = 2 * int(LINES.width_reach * usual * web.scale) + 1
    local = ndimage.percentile_filter(width, LINES.width_percent, min(reach, 2 * len(width) - 1), mode="reflect")
    error = np.maximum(LINES.center_error * local, LINES.center_error_min)
    near, is_even = (
        distance <= np.maximum(LINES.snap / web.scale, LINES.snap_widths * local),
        np.abs(width - local) <= error,
    )
    good = near & is_even
    if not good.any():
        return np.zeros((0, 2)), 0.0
    # In bends and beside junctions disks grow, but the line still lies half of its width inside of the outline.
    grown = near & (width > local + error)
    centers = disks.centers[nearest]
    centers[grown] -= (0.5 * (width - local))[grown, None] * boundary.inward[nearest[grown]]
    return going_on(centers[good | grown], 0.5 / web.scale), float(np.median(width[good]))
