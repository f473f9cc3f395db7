"""The order and direction of lines, for a pen that travels little between them."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats
from warpvec.flat.constants.lines import LINES
from warpvec.flat.lines.line import DrawnLine


def pen_travel(lines: list[DrawnLine]) -> float:
    """Return how far the pen travels from the end of each line to the start of the next, in pixels."""
    ends = _ends(lines)
    return float(np.linalg.norm(ends[1:, 0] - ends[:-1, 1], axis=1).sum())


def ordered(lines: list[DrawnLine]) -> list[DrawnLine]:
    """Return ``lines`` in an order that lets a pen travel little; some are reversed.

    The next line is the nearest one; then parts of the order are reversed while that shortens the way (2-opt).
    """
    if len(lines) < 2:
        return lines
    order, is_back = _nearest_first(_ends(lines))
    order, is_back = _shorter(_ends(lines), order, is_back)
    return [lines[k].reversed() if back else lines[k] for k, back in zip(order.tolist(), is_back.tolist(), strict=True)]


def _ends(lines: list[DrawnLine]) -> Floats:
    """Return start and end of each line [N, 2, 2] px."""
    return np.array([line.ends() for line in lines]).reshape(-1, 2, 2)


def _nearest_first(ends: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Return the lines in the order in which each is the nearest to the one before, and which run backwards [N]."""
    count = len(ends)
    tree, left = cKDTree(ends.reshape(-1, 2)), np.ones(count, bool)
    order, is_back = [], []
    place = np.zeros(2)
    for _ in range(count):
        number = _nearest_left(tree, place, left)
        line, back = divmod(number, 2)
        left[line] = False
        order.append(line)
        is_back.append(bool(back))
        place = ends[line, 1 - back]
    return np.array(order), np.array(is_back)


def _nearest_left(tree: cKDTree, place: Floats, left: np.ndarray) -> int:
    """Return the nearest end of a line that is left: twice the line's number, plus one for its end."""
    wanted = 8
    while True:
        found = np.atleast_1d(tree.query(place, min(wanted, tree.n))[1])
        free = found[left[found // 2]]
        if len(free):
            return int(free[0])
        wanted *= 4


def _shorter(ends: Floats, order: np.ndarray, is_back: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the order after all reversals of parts that shorten the way."""
    count = len(order)
    for _ in range(LINES.travel_rounds):
        has_gained = False
        for i in range(count - 1):
            start, end = _placed(ends, order, is_back)
            # The part i + 1 .. j is reversed; nothing follows the last line.
            j = np.arange(i + 1, count)
            follows = np.minimum(j + 1, count - 1)
            gap = np.where(j + 1 < count, np.linalg.norm(start[follows] - end[j], axis=1), 0.0)
            joined = np.where(j + 1 < count, np.linalg.norm(start[follows] - start[i + 1], axis=1), 0.0)
            gain = np.linalg.norm(start[i + 1] - end[i]) + gap - np.linalg.norm(end[j] - end[i], axis=1) - joined
            best = int(np.argmax(gain))
            if gain[best] > LINES.travel_gain:
                part = slice(i + 1, i + 2 + best)
                order[part], is_back[part] = order[part][::-1].copy(), ~is_back[part][::-1]
                has_gained = True
        if not has_gained:
            break
    return order, is_back


def _placed(ends: Floats, order: np.ndarray, is_back: np.ndarray) -> tuple[Floats, Floats]:
    side = is_back.astype(np.int64)
    return ends[order, side], ends[order, 1 - side]
