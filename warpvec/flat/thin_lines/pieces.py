"""Straight pieces of thin ink: the middles of the ink in rows of pixels, linked from row to row."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.thin_lines import THIN_LINES

STEEP_MAX = 1.03
"""Largest slope of a piece over rows, where a line of 45 degrees has about 1; steeper ones are found over columns."""


class Piece(NamedTuple):
    """A line x = start + slope * y over the rows ``first`` to ``last``, with the middle of row 0 at y = 0.5."""

    start: float
    slope: float
    first: int
    last: int


class _Middles(NamedTuple):
    """The middles of thin ink, in ascending rows and columns: the row [n] and the place x [n] of each."""

    row: Integers
    x: Floats


def straight_pieces(ink: Floats) -> list[Piece]:
    """Return the straight pieces of the thin ``ink`` [h, w] that are steeper than 45 degrees, or as steep."""
    middles = _middles(ink)
    return [piece for chain in _chains(middles, len(ink)) for piece in _straight(middles, chain)]


def _middles(ink: Floats) -> _Middles:
    """Return where ink has a peak in its row that falls within three pixels, to about the same level on both sides.

    That is the paper, or a line that crosses, or the level between two lines of a hatch.
    """
    p = np.pad(ink, ((0, 0), (4, 4)))
    width = ink.shape[1]
    at = [p[:, 4 + k : 4 + k + width] for k in range(-4, 5)]
    peak = at[4]
    is_peak = (peak >= THIN_LINES.contrast_min) & (peak >= at[3]) & (peak > at[5])
    rows, columns = np.nonzero(is_peak)
    window = np.stack([each[rows, columns] for each in at], 1)  # [n, 9]
    sides = [_valley(window[:, 4::step]) for step in (-1, 1)]
    base = np.maximum(*(least for least, _ in sides))
    top = window[:, 4] - base
    total, moment = top.copy(), np.zeros(len(rows))
    for step, (_, going) in zip((-1, 1), sides, strict=True):
        for k in range(1, 4):
            value = going[:, k - 1] * np.maximum(window[:, 4 + step * k] - base, 0.0)
            total += value
            moment += step * k * value
    is_even = np.abs(sides[0][0] - sides[1][0]) <= THIN_LINES.gap_share * top
    is_line = is_even & (top >= THIN_LINES.contrast_min)
    x = columns + 0.5 + moment / np.maximum(total, 1e-9)
    return _Middles(rows[is_line], x[is_line])


def _valley(values: Floats) -> tuple[Floats, Mask]:
    """Return the level [n] to which ``values`` [n, k] fall from the first on, and which of the next three do [n, 3]."""
    going = np.minimum.accumulate(values[:, 1:4] <= values[:, :3], 1)
    return np.where(going, values[:, 1:4], values[:, :1]).min(1), going


def _chains(middles: _Middles, height: int) -> list[Integers]:
    """Return the middles of each chain: the nearest of two rows are linked if they are near."""
    first = np.searchsorted(middles.row, np.arange(height + 1))
    ahead = np.full(len(middles.row), -1, np.int64)
    for row in range(height - 1):
        one, other = middles.x[first[row] : first[row + 1]], middles.x[first[row + 1] : first[row + 2]]
        if not len(one) or not len(other):
            continue
        forth, back = _nearest(one, other), _nearest(other, one)
        mutual = (back[forth] == np.arange(len(one))) & (np.abs(other[forth] - one) <= THIN_LINES.step_max)
        ahead[first[row] + np.flatnonzero(mutual)] = first[row + 1] + forth[mutual]
    has_before = np.zeros(len(ahead), bool)
    has_before[ahead[ahead >= 0]] = True
    chains = []
    for begin in np.flatnonzero(~has_before & (ahead >= 0)):
        chain = [int(begin)]
        while ahead[chain[-1]] >= 0:
            chain.append(int(ahead[chain[-1]]))
        if len(chain) >= THIN_LINES.length_min:
            chains.append(np.array(chain))
    return chains


def _nearest(one: Floats, other: Floats) -> Integers:
    """Return the nearest of ``other`` [m], ascending, to each of ``one`` [n]."""
    after = np.searchsorted(other, one).clip(1, len(other) - 1) if len(other) > 1 else np.zeros(len(one), np.int64)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(other[before] - one) <= np.abs(other[after] - one), before, after)


def _straight(middles: _Middles, chain: Integers) -> list[Piece]:
    """Return the straight pieces of a chain, cut where it is farthest from a line."""
    if len(chain) < THIN_LINES.length_min:
        return []
    y, x = (middles.row[chain] + 0.5).astype(np.float64), middles.x[chain]
    start, slope, off = fitted(y, x)
    worst = int(np.abs(off).argmax())
    if abs(off[worst]) > THIN_LINES.straight_max:
        cut = min(max(worst, 1), len(chain) - 1)
        return _straight(middles, chain[:cut]) + _straight(middles, chain[cut:])
    if abs(slope) > STEEP_MAX or is_bent(y, off):
        return []
    return [Piece(start, slope, int(middles.row[chain[0]]), int(middles.row[chain[-1]]))]


def is_bent(y: Floats, off: Floats) -> bool:
    """Return whether an arc fits places better than their line, by the distances ``off`` [n] at the rows ``y`` [n]."""
    if len(y) < 3:
        return False
    u = (y - y.mean()) / max((y[-1] - y[0]) / 2.0, 1.0)
    arc = u**2 - np.mean(u**2)
    return bool(abs(arc @ off / (arc @ arc)) > THIN_LINES.bend_max)


def fitted(y: Floats, x: Floats, weight: Mask | None = None) -> tuple[float, float, Floats]:
    """Return the start and slope of the line that fits places best, and the distance [n] of each from it."""
    chosen = slice(None) if weight is None else weight
    middle = y[chosen].mean()
    part = y[chosen] - middle
    slope = float(part @ x[chosen] / max(float(part @ part), 1e-9))
    start = float(x[chosen].mean() - slope * middle)
    return start, slope, x - start - slope * y
