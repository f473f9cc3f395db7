"""Marks that follow each other at equal distances."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.price import PRECISION
from warpvec.flat.thin_lines.dash_marks import Mark

EDGE = 0.25
"""Renderers place an edge to a quarter of a pixel."""

_NEIGHBOURS = 16
"""Nearest marks among which the next dash is looked for."""

_REACH = 3.0
"""Largest distance of the middles of two dashes in lengths of a dash."""

_TURN = math.cos(math.radians(30.0))
"""Cosine of the largest angle between a dash and the way to the next one."""


def chains_of(marks: list[Mark]) -> list[list[Mark]]:
    """Return the chains of ``marks`` that follow each other: each the nearest ahead of the one before, both ways."""
    some = [mark for mark in marks if mark.is_long]
    if len(some) < 2:
        return []
    ahead = _nearest_ahead(some)
    beside: dict[int, dict[int, tuple[int, int]]] = {k: {} for k in range(len(some))}
    for (k, side), (other, other_side) in ahead.items():
        if ahead.get((other, other_side)) == (k, side):
            beside[k][side] = (other, other_side)
    chains, left = [], set(range(len(some)))
    # Ends of chains come first; what is left then are closed ones.
    for start in sorted(left, key=lambda k: (len(beside[k]), k)):
        if start not in left or not beside[start]:
            continue
        k, side, chain = start, next(iter(beside[start])), [start]
        left.discard(start)
        while side in beside[k]:
            k, entered = beside[k][side]
            chain.append(k)
            if k not in left:
                break  # closed: the first one is the last one, too
            left.discard(k)
            side = -entered
        chains.append([some[k] for k in chain])
    return chains


def _nearest_ahead(marks: list[Mark]) -> dict[tuple[int, int], tuple[int, int]]:
    """Return for each mark and side, 1 along it and -1 against, the nearest mark there and the side that it turns."""
    centers, along = (np.array([getattr(mark, name) for mark in marks]) for name in ("center", "along"))
    length = np.array([mark.length for mark in marks])
    count = min(_NEIGHBOURS + 1, len(marks))
    distances, others = cKDTree(centers).query(centers, count)
    one, other, distance = np.repeat(np.arange(len(marks)), count), others.ravel(), distances.ravel()
    way = (centers[other] - centers[one]) / np.maximum(distance, 1e-9)[:, None]
    turn, back = (along[one] * way).sum(1), -(along[other] * way).sum(1)
    is_next = (np.minimum(np.abs(turn), np.abs(back)) >= _TURN) & (distance > (length[one] + length[other]) / 2.0)
    is_next &= distance <= _REACH * np.maximum(length[one], length[other])
    found: dict[tuple[int, int], tuple[int, int]] = {}
    for k in np.flatnonzero(is_next)[np.argsort(distance[is_next], kind="stable")].tolist():
        found.setdefault((int(one[k]), int(np.sign(turn[k]))), (int(other[k]), int(np.sign(back[k]))))
    return found


def even_runs(chain: list[Mark]) -> list[list[Mark]]:
    """Return the parts of a ``chain`` whose marks have equal lengths and distances."""
    runs = [[chain[0]]]
    for mark in chain[1:]:
        if _goes_on(runs[-1], mark):
            runs[-1].append(mark)
        else:
            # The last mark of a run may begin the next one.
            runs.append([runs[-1][-1], mark] if _goes_on(runs[-1][-1:], mark) else [mark])
    if chain[0] is chain[-1] and len(runs) > 1:  # it begins and ends where its steps are uneven
        start = len(runs[0])
        return even_runs(chain[start:] + chain[1:start])
    return [run for run in runs if len(run) > 1]


def _goes_on(run: list[Mark], mark: Mark) -> bool:
    length = float(np.median([each.length for each in run]))
    if abs(mark.length - length) > 2.0 * EDGE or abs(mark.width - run[-1].width) > 2.0 * EDGE:
        return False
    steps = _steps([*run, mark])
    return bool(abs(steps[-1] - np.median(steps)) <= 2.0 * EDGE)


def _steps(run: list[Mark]) -> Floats:
    """Return the distances [n - 1] of the marks of a run in pixels."""
    found: Floats = np.linalg.norm(np.diff([mark.center for mark in run], axis=0), axis=1)
    return found


def alike_some_long(runs: list[list[Mark]]) -> list[list[Mark]]:
    """Return the ``runs`` of enough dashes, and shorter ones that are like one of these."""

    def look(run: list[Mark]) -> Floats:
        return np.array([np.median(_steps(run)), *np.median([(mark.length, mark.width) for mark in run], 0)])

    known = [look(run) for run in runs if len(run) >= THIN_LINES.dashes_min]
    return [run for run in runs if any(np.abs(look(run) - each).max() <= 2.0 * EDGE for each in known)]


def with_between(run: list[Mark], marks: list[Mark]) -> list[Mark]:
    """Return a ``run`` with the marks midway between its dashes, if all have one there."""
    tree, step, own = cKDTree([mark.center for mark in marks]), float(np.median(_steps(run))), set(map(id, run))
    places = [(one.center + other.center) / 2.0 for one, other in pairwise(run)]
    between = [
        [marks[k] for k in tree.query_ball_point(place, 0.1 * step) if id(marks[k]) not in own] for place in places
    ]
    if not all(len(each) == 1 for each in between):
        return run
    return [mark for pair in zip(run, between, strict=False) for mark in (pair[0], *pair[1])] + run[-1:]


def followed(run: list[Mark], marks: list[Mark], residual: Floats) -> list[Mark]:
    """Return a straight ``run`` as far as its dashes go on at equal distances, some of them in other ink."""
    centers = np.array([mark.center for mark in run])
    if run[0] is run[-1] or _has_between(run) or off_line(centers) > 2.0 * PRECISION:
        return run
    ink = np.median([mark.ink.reshape(-1, 3)[np.linalg.norm(mark.ink, axis=2).argmax()] for mark in run], 0)
    tree, step = cKDTree([mark.center for mark in marks]), (centers[-1] - centers[0]) / (len(run) - 1)
    found = list(run)
    for way in (step, -step):
        ahead: list[Mark] = []
        while True:
            place = found[-1].center + way * (len(ahead) + 1)
            near = [marks[k] for k in tree.query_ball_point(place, 2.0 * EDGE)]
            near = [mark for mark in near if abs(mark.length - run[0].length) <= 2.0 * EDGE]
            column, row = np.floor(place).astype(int).tolist()
            is_inside = 0 <= row < residual.shape[0] and 0 <= column < residual.shape[1]
            if near:
                ahead.append(near[0])
            elif is_inside and residual[row, column] @ ink >= 0.5 * ink @ ink:
                ahead.append(run[0]._replace(label=0, center=place))
            else:
                break
        while ahead and ahead[-1].label == 0:
            ahead.pop()
        found = [*found, *ahead][::-1]
    return found


def _has_between(run: list[Mark]) -> bool:
    return bool(np.ptp([mark.length for mark in run]) > 4.0 * EDGE)


def off_line(centers: Floats) -> float:
    """Return the largest distance of ``centers`` [n, 2] from the line through them."""
    away = centers - centers.mean(0)
    return float(np.abs(away @ np.linalg.svd(away, full_matrices=False)[2][1]).max())


def with_ends(run: list[Mark], marks: list[Mark]) -> list[Mark]:
    """Return a ``run`` with the shorter marks at its ends, if it has such."""
    if run[0] is run[-1] or _has_between(run):
        return run
    tree, own = cKDTree([mark.center for mark in marks]), set(map(id, run))
    length = float(np.median([mark.length for mark in run]))
    gap = float(np.median(_steps(run))) - length
    for _ in range(2):
        run = run[::-1]
        last = run[-1].center
        away = (last - run[-2].center) / float(np.linalg.norm(last - run[-2].center))
        for k in tree.query_ball_point(last + (length / 2.0 + gap) * away, length / 2.0 + 2.0 * EDGE):
            ahead = float((marks[k].center - last) @ away) - (length + marks[k].length) / 2.0
            if id(marks[k]) not in own and abs(ahead - gap) <= 2.0 * EDGE and marks[k].length < length:
                run = [*run, marks[k]]
                break
    return run
