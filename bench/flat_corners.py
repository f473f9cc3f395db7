"""Corners of a drawing, and how far those of a tracing lie from those of its original."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from flat_originals import stretched
from numpy.typing import NDArray

from warpvec.flat.cutting.cutout import cut_out
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

CORNER_DEGREES = 30.0
"""Least turn of the original's outline that counts as a corner. A designer sees it at once."""

OWN_CORNER_DEGREES = 15.0
"""Least turn of a tracing that counts: its two sides may each be off by some degrees."""

ARMS = (1.0, 0.3)
"""Pixels along the outline, on either side, between which the turn is measured. Corners of originals turn enough for
both: a tiny arc at a corner counts as part of it, but the end of a thin ellipse is no corner. Those of tracings need to
do so for the first only."""

_STEPS = 16
"""Chords of a cubic."""

_SEEN_SIZE = 1024
"""Longest side in pixels of the drawings that tell which corners can be seen."""

_DISC = 3.0
"""Radius in those pixels of the disc around a corner that is looked at."""

_SHARE_ERROR = 0.2
"""Largest difference between the share of the disc that a path changes and the share that its corner alone encloses.
Beyond it, something above covers the corner or its surroundings."""

_CHANGE = 4
"""Levels by which a path must change a pixel to count as seen there."""

Points = NDArray[np.float64]


def scene_of(svg: str, width: int, height: int) -> Scene:
    """Return the scene of ``svg`` in pixels of a drawing of ``width`` x ``height``."""
    loaded = read_svg(stretched(svg, width, height))
    return loaded.scene.scaled(width / loaded.width, height / loaded.height)


def corners(
    scene: Scene, degrees: float, arms: tuple[float, ...] = ARMS[:1]
) -> tuple[Points, Points, NDArray[np.int64]]:
    """Return place [k, 2], enclosed share of the turn around it [k], and path [k] of each corner."""
    structure = scene.structure
    first = structure.loop_first_segment.tolist()
    following = structure.segment_next.long()
    cubics = np.concatenate([scene.segments.numpy(), scene.segments[following, :1].numpy()], 1).astype(np.float64)
    owner = structure.segment_path.numpy()
    found = [(place, share, int(owner[start])) for start, stop in pairwise(first) for place, share in
             _loop_corners(cubics[start:stop], math.radians(degrees), arms)]  # fmt: skip
    places = np.array([place for place, _, _ in found]).reshape(-1, 2)
    return places, np.array([share for _, share, _ in found]), np.array([path for _, _, path in found], np.int64)


def _loop_corners(cubics: Points, least: float, arms: tuple[float, ...]) -> list[tuple[Points, float]]:
    """Return the corners among the nodes of a loop of ``cubics`` [k, 4, 2]."""
    t = np.arange(_STEPS)[:, None] / _STEPS
    a, b, c, d = np.moveaxis(cubics, 1, 0)[:, :, None]
    points = ((1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d).reshape(-1, 2)
    steps = np.roll(points, -1, axis=0) - points
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    whole = along[-1]
    if whole < 4 * max(arms):
        return []
    closed = np.concatenate([points, points[:1]])
    turns = [_turns(along, closed, arm) for arm in arms]
    is_corner = np.abs(turns).min(0) > least
    area = (points[:, 0] * np.roll(points[:, 1], -1) - points[:, 1] * np.roll(points[:, 0], -1)).sum()
    share = (math.pi - math.copysign(1.0, area) * turns[0]) / (2 * math.pi)
    return [(cubics[k, 0], float(share[k])) for k in np.flatnonzero(is_corner)]


def _turns(along: Points, closed: Points, arm: float) -> Points:
    """Return by how much a polyline turns at every start of a cubic, in radians, between points ``arm`` px away."""
    nodes, whole = along[:-1:_STEPS], along[-1]
    places = ((nodes + distance) % whole for distance in (-arm, 0.0, arm))
    behind, node, ahead = (
        np.stack([np.interp(place, along, closed[:, axis]) for axis in (0, 1)], -1) for place in places
    )
    before, after = node - behind, ahead - node
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.arctan2(cross, (before * after).sum(1))


def seen_corners(svg: str, width: int, height: int) -> Points:
    """Return the corners [k, 2] of ``svg`` that its drawing shows, in pixels of ``width`` x ``height``."""
    factor = _SEEN_SIZE / max(width, height)
    columns, rows = round(width * factor), round(height * factor)
    scene = scene_of(svg, columns, rows)
    places, shares, owners = corners(scene, CORNER_DEGREES, ARMS)
    whole = draw(write_svg(scene, columns, rows), columns, rows).astype(int)
    kept = []
    for path in np.unique(owners):
        rest = scene.select((np.arange(len(scene)) != path).nonzero()[0])  # type: ignore[arg-type]
        changed = np.abs(draw(write_svg(rest, columns, rows), columns, rows) - whole).max(2) > _CHANGE
        kept += [k for k in np.flatnonzero(owners == path) if _is_seen(changed, places[k], shares[k])]
    return places[sorted(kept)] / factor


def _is_seen(changed: NDArray[np.bool_], place: Points, share: float) -> bool:
    """Return whether the path changes about the part of the disc that its corner encloses, or all but that part."""
    y, x = np.ogrid[: changed.shape[0], : changed.shape[1]]
    disc = (x + 0.5 - place[0]) ** 2 + (y + 0.5 - place[1]) ** 2 <= _DISC**2
    if not disc.any():
        return False
    part = float(changed[disc].mean())
    return min(abs(part - share), abs(part - (1 - share))) <= _SHARE_ERROR and 0 < part < 1


def corner_distances(seen: Points, svg: str, width: int, height: int) -> Points:
    """Return the distance in pixels from each seen corner of the original to the nearest corner of the tracing ``svg``.

    It is infinite if the tracing has none. Places where an outline meets one that covers it are corners as well.
    """
    scene = scene_of(svg, width, height)
    seen_parts = cut_out(scene, width, height).scene
    own = np.concatenate([corners(each, OWN_CORNER_DEGREES)[0] for each in (scene, seen_parts)])
    if not len(seen):
        return np.zeros(0)
    if not len(own):
        return np.full(len(seen), np.inf)
    return np.hypot(*np.moveaxis(seen[:, None] - own[None], -1, 0)).min(1)
