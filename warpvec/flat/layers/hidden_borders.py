"""Borders of a layer that layers above hide: a few straight lines from one end of what shows to the next."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from PIL import Image, ImageDraw

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.curves.closed_runs import closed_runs
from warpvec.flat.layers.covering import Cover


def with_simple_hidden_borders(loop: Floats, is_hidden: Mask, cover: Cover) -> Floats:
    """Return the closed polyline ``loop`` [n, 2] with simpler borders where it ``is_hidden`` [n]."""
    runs = _hidden_runs(loop, is_hidden)
    if not runs:
        return loop
    if len(runs) == 1 and runs[0][1] - runs[0][0] >= len(loop):
        return _smoothed(np.concatenate([loop, loop[:1]]))[:-1]
    shown = []
    for (_, start), stop in zip(runs, [*(first for first, _ in runs[1:]), runs[0][0] + len(loop)], strict=True):
        shown.append(_extended(loop[np.arange(start, stop) % len(loop)], cover))
    pieces = []
    for index, (start, stop) in enumerate(runs):
        hidden = loop[np.arange(start, stop) % len(loop)]
        border = _border(np.concatenate([shown[index - 1][-1:], hidden, shown[index][:1]]), cover)
        pieces += [border[1:-1], shown[index]]
    return np.concatenate(pieces)


def _hidden_runs(loop: Floats, is_hidden: Mask) -> list[tuple[int, int]]:
    """Return first and one past the last vertex of each hidden run, in order; the last may go on past the end."""
    if is_hidden.all():
        return [(0, len(loop))]
    begin = int(np.argmin(is_hidden))  # a vertex that shows, where lengths begin
    steps = np.roll(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1), -begin)
    lengths = np.concatenate([np.zeros(begin + 1), np.cumsum(steps)])
    return [(a, b) for a, b in closed_runs(is_hidden) if lengths[b] - lengths[a] >= LAYERS.hidden_run_min]


def _extended(shown: Floats, cover: Cover) -> Floats:
    """Return the part ``shown`` [n, 2] with both ends going straight on beneath the layers above."""
    for _ in range(2):
        shown = _extended_end(shown, cover)[::-1]
    return shown


def _extended_end(shown: Floats, cover: Cover) -> Floats:
    steps = np.linalg.norm(np.diff(shown, axis=0), axis=1)
    from_end = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
    certain = np.nonzero((from_end >= LAYERS.blurred_end) & (from_end <= LAYERS.blurred_end + LAYERS.tangent_reach))[0]
    if len(certain) < 2:
        return shown
    near, first = shown[certain[0] : certain[-1] + 1], certain[-1]
    direction = near[-1] - near[0]
    direction /= max(float(np.linalg.norm(direction)), 1e-9)
    for extension in (LAYERS.extension, LAYERS.extension / 2.0):
        end = shown[first] + direction * (from_end[first] + extension)
        if is_in(cover.above, end[None])[0]:
            return np.concatenate([shown[: first + 1], end[None]])
    return shown


def _border(path: Floats, cover: Cover) -> Floats:
    """Return a simple border from the first to the last point of a hidden ``path`` [n, 2]: few lines, or smooth."""
    if len(path) <= 2:
        return path
    simple = _fewest_links(path, cover)
    return simple if len(simple) - 1 <= LAYERS.links_max else _smoothed(path)


def _smoothed(path: Floats) -> Floats:
    """Return ``path`` [n, 2] without the steps of pixels; its ends stay."""
    window = LAYERS.border_smoothing
    ends = [np.repeat(path[place][None], window // 2, 0) for place in (0, -1)]
    padded = np.concatenate([ends[0], path, ends[1]])
    sums = np.cumsum(np.concatenate([np.zeros((1, 2)), padded]), 0)
    means = (sums[window:] - sums[:-window]) / window
    return np.concatenate([path[:1], means[1:-1], path[-1:]])


def _fewest_links(path: Floats, cover: Cover) -> Floats:
    """Return the path of fewest lines through points of ``path`` that stays covered, on the same side of all else."""
    chosen = np.unique(np.rint(np.linspace(0, len(path) - 1, min(len(path), LAYERS.link_points))).astype(np.int64))
    points = path[chosen]
    sees = _links(points, cover)
    for _ in range(LAYERS.detours_max):
        order = _fewest_steps(points, sees)
        if len(order) - 1 > LAYERS.links_max:
            break
        wrong = [(a, b) for a, b in pairwise(order) if _encloses_other(path[chosen[a] : chosen[b] + 1], cover)]
        if not wrong:
            return points[order]
        for a, b in wrong:
            sees[a, b] = b == a + 1
    return points


def _fewest_steps(points: Floats, sees: Mask) -> list[int]:
    """Return the points from the first to the last in fewest steps that ``sees`` [n, n] allows; then the shortest."""
    count = len(points)
    steps, came = np.full(count, np.inf), np.zeros(count, np.int64)
    lengths = np.linalg.norm(points[:, None] - points, axis=-1)
    cost = np.where(sees, 1.0 + 0.01 * lengths / max(float(lengths.max()), 1e-9), np.inf)
    steps[0] = 0.0
    for end in range(1, count):
        total = steps[:end] + cost[:end, end]
        came[end] = int(total.argmin())
        steps[end] = total[came[end]]
    order = [count - 1]
    while order[-1] > 0:
        order.append(int(came[order[-1]]))
    return order[::-1]


def _encloses_other(path: Floats, cover: Cover) -> bool:
    """Return whether a ``path`` [n, 2] and the line between its ends enclose what is not beneath layers above."""
    if len(path) <= 2:
        return False
    corner = np.floor(path.min(0)).astype(np.int64)
    width, height = np.ceil(path.max(0)).astype(np.int64) - corner + 1
    image = Image.new("1", (int(width), int(height)))
    ImageDraw.Draw(image).polygon([(x, y) for x, y in (path - corner - 0.5).tolist()], fill=1)
    box = cover.above[corner[1] : corner[1] + height, corner[0] : corner[0] + width]
    inside = np.asarray(image)[: box.shape[0], : box.shape[1]]
    return int((inside & ~box).sum()) > LAYERS.enclosed_max


def _links(points: Floats, cover: Cover) -> Mask:
    """Return which of ``points`` [n, 2] a straight line that stays covered joins to a later one [n, n].

    Neighbours always are joined.
    """
    share = np.linspace(0.0, 1.0, LAYERS.link_samples)[1:-1]
    first, second = np.triu_indices(len(points), 1)
    x, y = (each[first, None] * (1.0 - share) + each[second, None] * share for each in points.T)
    from_ends = (np.sqrt((x - end[0]) ** 2 + (y - end[1]) ** 2) for end in (points[0], points[-1]))
    # At the ends, where the border comes out from beneath, no margin can be kept.
    margin = np.minimum(LAYERS.hidden_margin, LAYERS.hidden_wedge * np.minimum(*from_ends))
    height, width = cover.above.shape
    column, row = (np.floor(each).astype(np.int64).clip(0, most - 1) for each, most in ((x, width), (y, height)))
    inside = cover.above[row, column] & (cover.from_out[row, column] >= margin)
    sees = np.zeros((len(points), len(points)), bool)
    sees[first, second] = inside.all(-1)
    neighbours = np.arange(len(points) - 1)
    sees[neighbours, neighbours + 1] = True
    return sees


def is_in(mask: Mask, points: Floats) -> Mask:
    """Return whether each of ``points`` [n, 2] lies in a pixel of ``mask`` [h, w]."""
    x, y = np.floor(points).astype(np.int64).T
    height, width = mask.shape
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    return inside & mask[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
