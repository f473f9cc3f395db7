"""The pens of a drawing of lines: their colours, and how much of each pixel each pen covers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial.distance import pdist, squareform

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.lines import LINES
from warpvec.flat.lines.line import DrawnLine
from warpvec.image.oklab import to_oklab

_SEEN = LINES.ink_distance / 2.0
"""Distance in OKLab that one sees: ink is told from the paper by twice as much."""


class Pen(NamedTuple):
    """A pen: its colour [3], sRGB-encoded, and the share of each pixel that it covers [h, w], below other pens too."""

    color: Floats
    coverage: Floats


def find_pens(image: NDArray[Any]) -> list[Pen]:
    """Return the pens of ``image`` [h, w, 3 or 4], floats in [0, 1], in painting order.

    There are none if its lines are of one black pen, or if few colours do not explain it, as of a scan or a photo.
    """
    pixels = _over_white(image.astype(np.float64))
    paper = _paper(pixels)
    strength = np.linalg.norm(_oklab(pixels) - to_oklab(paper[None]), axis=2)
    colors = _colors(pixels, paper, strength)
    if not len(colors) or (len(colors) == 1 and _is_black(colors[0])) or len(colors) > LINES.pens_max:
        return []
    owner, share, off = _shares(pixels, paper, colors)
    is_ink = strength > LINES.ink_distance
    if np.mean(off[is_ink] > LINES.pen_misfit) > LINES.misfit_share:
        return []
    owner, share = _without_mixtures(owner, share, off, is_ink, len(colors))
    own = [np.where((owner == k) & is_ink, share, 0.0) for k in range(len(colors))]
    whole = [_below_others(k, own) for k in range(len(colors))]
    return [Pen(colors[k], whole[k]) for k in _painting_order(own, whole)]


def _over_white(image: Floats) -> Floats:
    # The picture of a fit is premultiplied by its alpha.
    return image if image.shape[2] == 3 else image[..., :3] + (1.0 - image[..., 3:])


def _oklab(pixels: Floats) -> Floats:
    return to_oklab(pixels.reshape(-1, 3).clip(0.0, 1.0)).reshape(pixels.shape)


def _chroma(color: Floats) -> float:
    return float(np.hypot(*to_oklab(color[None])[0, 1:]))


def _keys(colors: Floats) -> Integers:
    """Return a number for the cube of colour space, 16 levels wide, of each of ``colors`` [n, 3]."""
    found: Integers = (colors * 255.0 / 16.0).astype(np.int64) @ np.array([256, 16, 1])
    return found


def _paper(pixels: Floats) -> Floats:
    """Return the colour of most pixels [3]."""
    flat = pixels.reshape(-1, 3)
    keys = _keys(flat)
    return np.asarray(np.median(flat[keys == np.bincount(keys).argmax()], 0))


def _colors(pixels: Floats, paper: Floats, strength: Floats) -> Floats:
    """Return the colours of pens [K, 3]: those in the middle of lines, most frequent first."""
    is_middle = (strength > LINES.ink_distance) & (strength >= 0.98 * ndimage.maximum_filter(strength, 5))
    flat, is_even = pixels[is_middle], _is_even(pixels)[is_middle]
    shades = _shades(flat)
    found: list[Floats] = []
    is_surface: list[bool] = []
    left = np.ones(len(flat), bool)
    while left.sum() >= max(LINES.pen_pixels, LINES.pen_share * len(flat)):
        keys = _keys(flat)
        often = left & (keys == np.bincount(keys[left]).argmax())
        color = np.median(flat[often], 0)
        near = left & (_away(flat, color) <= shades)
        is_own = not found or bool(is_even[near].mean() >= LINES.even_share)
        if near.sum() >= LINES.pen_pixels and (is_own or not _is_thinner(color, paper, found, shades)):
            is_surface.append(is_own)
            found.append(color)
        left &= ~(near | often)
    # What is found before a stronger colour may still be its thin lines. It is more frequent, so it goes only if
    # one does not see it beside the mixture, in a JPEG too: by the wider shades a pen could fall to a rarer one.
    kept = [
        color
        for k, (color, is_own) in enumerate(zip(found, is_surface, strict=True))
        if is_own or not _is_thinner(color, paper, found[k + 1 :], _SEEN)
    ]
    return np.array(kept).reshape(-1, 3)


def _shades(middles: Floats) -> float:
    """Return the distance in OKLab within which colours are of one pen, by the middles [n, 3] of lines.

    In a clean picture nearly all of them have the exact colour of a pen. There, pens differ if one sees it: pastels are
    near to each other.
    """
    _, counts = np.unique(np.rint(255.0 * middles), axis=0, return_counts=True)
    exact = int(np.sort(counts)[-LINES.pens_max :].sum())
    is_clean = exact >= (1.0 - LINES.misfit_share / 2.0) * len(middles)
    return _SEEN if is_clean else LINES.pen_distance


def _away(colors: Floats, color: Floats) -> Floats:
    """Return the distance in OKLab of ``colors`` [n, 3] from a ``color`` [3]."""
    return np.asarray(np.linalg.norm(to_oklab(colors) - to_oklab(color[None]), axis=1))


def _is_even(pixels: Floats) -> Mask:
    """Return which pixels [h, w] have neighbours of their colour all around: they are no edges."""
    spread = ndimage.maximum_filter(pixels, (3, 3, 1)) - ndimage.minimum_filter(pixels, (3, 3, 1))
    found: Mask = spread.max(2) <= LINES.even_levels
    return found


def _is_thinner(color: Floats, paper: Floats, others: list[Floats], shades: float) -> bool:
    """Return whether ``color`` is that of a line of another pen thinner than a pixel: a mixture with ``paper``.

    The colours of a pen differ by as much as ``shades``, in OKLab.
    """
    misfit = LINES.pen_misfit * shades / LINES.pen_distance
    for other in others:
        step = other - paper
        share = float((color - paper) @ step / max(float(step @ step), 1e-9))
        if 0.0 < share <= 1.0 and np.abs(paper + share * step - color).max() <= misfit:
            return True
    return False


def _shares(pixels: Floats, paper: Floats, colors: Floats) -> tuple[Integers, Floats, Floats]:
    """Return the pen of each pixel [h, w], how much of it that covers, and how far off the mixture is."""
    best = np.full(pixels.shape[:2], np.inf)
    owner, share = np.zeros(pixels.shape[:2], np.int64), np.zeros(pixels.shape[:2])
    for k, color in enumerate(colors):
        step = color - paper
        own = ((pixels - paper) @ step / max(float(step @ step), 1e-9)).clip(0.0, 1.0)
        off = np.abs(paper + own[..., None] * step - pixels).max(2)
        nearer = off < best
        best[nearer], owner[nearer], share[nearer] = off[nearer], k, own[nearer]
    return owner, share, best


def _without_mixtures(owner: Integers, share: Floats, off: Floats, is_ink: Mask, count: int) -> tuple[Integers, Floats]:
    """Return pens and shares with the nearest pen where two pens mix to the colour of a third.

    A part of a pen has a pixel of its colour, unless it is thin and lies alone on the paper.
    """
    is_mixed = np.zeros_like(is_ink)
    for k in range(count):
        labels, number = ndimage.label((owner == k) & is_ink, np.ones((3, 3)))
        is_exact = (off <= LINES.even_levels) & (share >= LINES.full_share)
        has_exact = ndimage.maximum(is_exact, labels, np.arange(number + 1)).astype(bool)
        beside = ndimage.maximum_filter(is_ink & (owner != k), 3)
        touches = ndimage.maximum(beside, labels, np.arange(number + 1)).astype(bool)
        is_mixed |= (touches & ~has_exact)[labels] & (labels > 0)
    kept = is_ink & ~is_mixed
    if not kept.any():
        return owner, share
    rows, columns = ndimage.distance_transform_edt(~kept, return_distances=False, return_indices=True)
    return np.where(is_mixed, owner[rows, columns], owner), np.where(is_mixed, share[rows, columns], share)


def _below_others(k: int, own: list[Floats]) -> Floats:
    """Return the coverage of a pen [h, w] with what other pens hide of it: gaps in its lines no wider than theirs."""
    others = np.maximum.reduce([each for j, each in enumerate(own) if j != k] or [np.zeros_like(own[k])])
    if not (others > 0.5).any():
        return own[k]
    # Lines of the other pens are so wide, those of an area too.
    depth = ndimage.distance_transform_edt(others > 0.5)
    middles = depth[(depth > 0) & (depth == ndimage.maximum_filter(depth, 3))]
    # Gaps of lines that cross at 30 degrees are twice as wide.
    reach = int(np.ceil(2.0 * np.quantile(middles, 0.9))) + 1
    rows, columns = np.indices((2 * reach + 1, 2 * reach + 1)) - reach
    # A disc with a tip of one pixel would reach into the gap of a line of two.
    disk = np.hypot(rows, columns) <= reach + 0.5
    closed = ndimage.grey_closing(np.pad(own[k], reach + 1), footprint=disk)[
        reach + 1 : -reach - 1, reach + 1 : -reach - 1
    ]
    hidden = ndimage.maximum_filter(others, 3) > 0.0
    return np.where(hidden, np.maximum(own[k], closed), own[k])


def _painting_order(own: list[Floats], whole: list[Floats]) -> list[int]:
    """Return the pens from bottom to top: a pen lies above those that go on below it."""
    above = np.array([[float((own[j] * (whole[k] - own[k])).sum()) for k in range(len(own))] for j in range(len(own))])
    return np.argsort((above - above.T).sum(1), kind="stable").tolist()


def _is_black(color: Floats) -> bool:
    """Return whether a pen of ``color`` [3] draws as black ink."""
    return _chroma(color) < DRAWING.gray_chroma and bool(color.max() < LINES.black_max)


def with_pens_of(lines: list[DrawnLine], apart: list[DrawnLine]) -> list[DrawnLine]:
    """Return the dots and dashes ``apart``, whose ink was told by itself, in the colours of the pens of ``lines``."""
    pens = list(dict.fromkeys(line.color for line in lines))
    if not pens:
        return apart
    colors = {line.color: line.color for line in apart}
    for color in colors:
        away = _away(np.array(pens), np.array(color))
        is_same = away.min() <= LINES.pen_distance or (not any(map(any, pens)) and _is_black(np.array(color)))
        colors[color] = pens[int(away.argmin())] if is_same else color
    return [replace(line, color=colors[line.color]) for line in apart]


def with_fewer_pens(lines: list[DrawnLine], count_max: int) -> list[DrawnLine]:
    """Return ``lines`` in at most ``count_max`` colours, 0 for any: the nearest two become that of the longer lines."""
    lengths = dict.fromkeys((line.color for line in lines), 0.0)
    for line in lines:
        lengths[line.color] += line.length + line.width
    pen = {color: color for color in lengths}
    while 0 < count_max < len(lengths):
        colors = list(lengths)
        away = squareform(pdist(to_oklab(np.array(colors))))
        np.fill_diagonal(away, np.inf)
        pair = [colors[k] for k in np.unravel_index(away.argmin(), away.shape)]
        gone, kept = sorted(pair, key=lengths.__getitem__)
        lengths[kept] += lengths.pop(gone)
        pen = {color: kept if own == gone else own for color, own in pen.items()}
    return [replace(line, color=pen[line.color]) for line in lines]
