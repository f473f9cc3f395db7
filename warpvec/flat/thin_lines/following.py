"""Follow straight pieces through crossings to the ends of their lines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.thin_lines.grounds import Grounds
from warpvec.flat.thin_lines.pieces import STEEP_MAX, Piece, fitted, is_bent, straight_pieces


class ThinLine(NamedTuple):
    """A straight thin line x = start + slope * y from ``top`` to ``bottom``, or with x and y exchanged.

    Attributes:
        is_level: whether x and y are exchanged.
        ink: its ink in a row, summed up [3], in levels.
        is_crisp: whether it fills whole pixels, and none beside them.
        unclean: the share of its rows that do not show the line alone: there is other ink, too, a shape hides it, or
            its ink is off.
    """

    start: float
    slope: float
    top: float
    bottom: float
    is_level: bool
    ink: Floats
    is_crisp: bool = False
    unclean: float = 0.0

    @property
    def ends(self) -> Floats:
        """Where it starts and ends [2, 2], in pixels, x first."""
        y = np.array([self.top, self.bottom])
        points = np.stack([self.start + self.slope * y, y], 1)
        return points[:, ::-1] if self.is_level else points

    def has(self, x: float, y: float) -> bool:
        """Return whether a place lies on it."""
        return self.top <= y <= self.bottom and abs(self.start + self.slope * y - x) < 0.75

    @property
    def length(self) -> float:
        """Its length in pixels."""
        return float(np.hypot(1.0, self.slope) * (self.bottom - self.top))


class _Profile(NamedTuple):
    """The ink along a line in rows [n]: summed up across it [n, 3], its middle, how much there is, its most.

    ``beside`` is the least ink of a pixel on one side, and on the other side if there is more; ``own`` is the ink of
    the pixel in which the line is, times the pixels of the row that count.
    """

    total: Floats
    middle: Floats
    amount: Floats
    most: Floats
    beside: Floats
    own: Floats


class _Part(NamedTuple):
    """A picture in which steep lines are looked for.

    Attributes:
        residual: the picture less its paper [h, w, 3].
        ink: the sum of that over the channels [h, w].
        local: the picture less the ground of each pixel [h, w, 3].
        is_even: pixels [h, w] around which there is one ground.
        is_shape: those [h, w] whose ground is another one than the paper.
    """

    residual: Floats
    ink: Floats
    local: Floats
    is_even: Mask
    is_shape: Mask

    def at(self, mask: Mask, start: float, slope: float) -> Mask:
        """Return a ``mask`` [h, w] in each row [h] on the line x = start + slope * y."""
        y = np.arange(len(mask))
        return mask[y, np.floor(start + slope * (y + 0.5)).astype(np.int64).clip(0, mask.shape[1] - 1)]


def follow_lines(levels: Floats, paper: Floats, grounds: Grounds) -> list[ThinLine]:
    """Return the straight thin lines of a picture ``levels`` [h, w, 3] on a ``paper`` [3].

    They go on through pixels of shapes, which say nothing of them.
    """
    found = []
    for is_level in (False, True):
        part, color, is_even = levels, grounds.color, grounds.is_even
        if is_level:
            part, color = (np.ascontiguousarray(each.swapaxes(0, 1)) for each in (part, color))
            is_even = is_even.T
        residual = part - paper
        is_shape = is_even & (np.abs(color - paper).sum(2) >= THIN_LINES.contrast_min)
        found += _steep_lines(_Part(residual, np.abs(residual).sum(2), part - color, is_even, is_shape), is_level)
    return _each_once(found)


def _each_once(lines: list[ThinLine]) -> list[ThinLine]:
    """Return ``lines`` without those of 45 degrees that were found both ways: the longer ones stay."""
    kept: list[ThinLine] = []
    for line in sorted(lines, key=lambda line: -line.length):
        if not any(_lies_on(line, other) for other in kept):
            kept.append(line)
    return kept


def _lies_on(line: ThinLine, other: ThinLine) -> bool:
    """Return whether ``line``, found the other way, lies on ``other``: both are near 45 degrees."""
    is_diagonal = line.slope * other.slope > 0 and min(abs(line.slope), abs(other.slope)) > 1.0 / STEEP_MAX**3
    x, y = line.ends.mean(0)[:: -1 if other.is_level else 1]
    return line.is_level != other.is_level and is_diagonal and other.has(x, y)


def _steep_lines(part: _Part, is_level: bool) -> list[ThinLine]:
    pieces = sorted(straight_pieces(part.ink), key=lambda piece: piece.first - piece.last)
    found: list[ThinLine] = []
    for piece in pieces:
        if _is_known(piece, found):
            continue
        line = _followed(part, piece, is_level)
        if line is not None:
            found.append(line)
    return found


def _is_known(piece: Piece, lines: list[ThinLine]) -> bool:
    """Return whether a piece lies on one of the ``lines``."""
    middle = (piece.first + piece.last + 1) / 2.0
    return any(line.has(piece.start + piece.slope * middle, middle) for line in lines)


def _followed(part: _Part, piece: Piece, is_level: bool) -> ThinLine | None:
    """Return the line that goes on from ``piece`` both ways; None if that is no thin line."""
    start, slope = piece.start, piece.slope
    clean = np.arange(piece.first, piece.last + 1)
    # The first rounds go on from a short piece. In the last one, each row must lie on the line.
    for reach in (2.0, 2.0, 1.0):
        profile = profile_of(part.residual, part.ink, start, slope)
        hides = part.at(part.is_shape, start, slope)
        clean = clean[~hides[clean]]
        if not len(clean):
            return None
        look = np.median(profile.total[clean], 0)
        size = float(np.linalg.norm(look))
        if size * np.sqrt(3.0) < THIN_LINES.contrast_min:
            return None
        share = profile.total @ look / size**2
        # Ink that only stands beside the line is that of a frame: the line's own pixel has an even share of its ink.
        own = profile.own / np.abs(look).sum()
        is_full = (share >= THIN_LINES.support_min) | (profile.amount >= np.abs(look).sum())
        is_there = hides | (is_full & (own >= THIN_LINES.support_min))
        first, last = _run(is_there, int(clean[len(clean) // 2]))
        rows = np.arange(first, last + 1)
        off = np.linalg.norm(profile.total[rows] - look, axis=1)
        is_clean = off <= THIN_LINES.clean_difference * size
        is_clean &= np.abs(profile.middle[rows] - start - slope * (rows + 0.5)) < reach * THIN_LINES.straight_max
        is_clean &= ~hides[rows]
        is_open = ~hides[rows] & (share[rows] <= THIN_LINES.reach_max)
        if is_clean.sum() < max(THIN_LINES.length_min, THIN_LINES.clean_share_min * is_open.sum()):
            return None
        start, slope, bend = fitted((rows + 0.5).astype(np.float64), profile.middle[rows], is_clean)
        if abs(slope) > STEEP_MAX:
            return None
        clean = rows[is_clean]
    paper_max = np.maximum(THIN_LINES.paper_share * profile.most[clean], THIN_LINES.contrast_min)
    is_on_paper = np.mean(profile.beside[clean] <= paper_max) >= 0.5
    if not is_on_paper or is_bent((clean + 0.5).astype(np.float64), bend[is_clean]):
        return None
    line = _ended(start, slope, profile, rows, clean, np.minimum(share, own), is_level)
    plain = clean[part.at(part.is_even, start, slope)[clean]]
    line = line._replace(unclean=1.0 - len(clean) / len(rows))
    return _with_look(line, part, profile, clean, plain)


def profile_of(residual: Floats, ink: Floats, start: float, slope: float) -> _Profile:
    """Return the ink in each row [h] around a line, as far as one of the largest width reaches."""
    height, width = ink.shape
    y = np.arange(height)
    x = start + slope * (y + 0.5)
    half = (THIN_LINES.width_max * 0.75 + abs(slope)) / 2.0 + 0.5
    base = np.floor(x - half + 0.5).astype(np.int64)
    columns = base[:, None] + np.arange(int(np.ceil(2.0 * half)) + 1)
    is_in = (columns + 0.5 >= (x - half)[:, None]) & (columns + 0.5 <= (x + half)[:, None])
    is_in &= (columns >= 0) & (columns < width)
    part = np.where(is_in[..., None], residual[y[:, None], columns.clip(0, width - 1)], 0.0)
    amount = np.where(is_in, ink[y[:, None], columns.clip(0, width - 1)], 0.0)
    whole = amount.sum(1)
    middle = (amount * (columns + 0.5)).sum(1) / np.maximum(whole, 1e-9)
    column = np.floor(x).astype(np.int64)
    own = 2.0 * half * np.where((column >= 0) & (column < width), ink[y, column.clip(0, width - 1)], 0.0)
    return _Profile(part.sum(1), middle, whole, amount.max(1), _beside(ink, column), own)


def _beside(ink: Floats, column: Integers) -> Floats:
    """Return the least ink within three pixels on one side of each ``column`` [h], or on the other if that is more."""
    rows = np.arange(len(column))[:, None]
    padded = np.pad(ink, ((0, 0), (3, 3)))
    steps = np.arange(1, 4)
    column = column.clip(0, ink.shape[1] - 1)[:, None] + 3
    return np.maximum(padded[rows, column + steps].min(1), padded[rows, column - steps].min(1))


def _run(is_there: Mask, place: int) -> tuple[int, int]:
    """Return the first and last row of the run of ``is_there`` [h] around ``place``."""
    gaps = np.flatnonzero(~is_there)
    k = int(np.searchsorted(gaps, place))
    first = int(gaps[k - 1]) + 1 if k else 0
    last = int(gaps[k]) - 1 if k < len(gaps) else len(is_there) - 1
    return min(first, place), max(last, place)


def _ended(
    start: float, slope: float, profile: _Profile, rows: Integers, clean: Integers, share: Floats, is_level: bool
) -> ThinLine:
    """Return a line with its ends: part of a pixel has part of the ink, and in larger shapes it goes on for a pixel."""
    first, last = max(int(rows[0]), int(clean[0]) - 3), min(int(rows[-1]), int(clean[-1]) + 3)

    def part(row: int) -> float:
        return float(np.clip(share[row], 0.0, 1.0)) if 0 <= row < len(share) else 0.0

    def beyond(edge: int, step: int) -> float:
        """Return how far the line goes on from the row ``edge``, where its run ends."""
        outside = part(edge + step)
        own = 1.0 - part(edge) if outside < 0.1 else 0.0
        return (outside if outside < THIN_LINES.support_min else 0.0) - own

    top = first - (beyond(first, -1) if first == rows[0] else 0.0)
    bottom = last + 1 + (beyond(last, 1) if last == rows[-1] else 0.0)
    return ThinLine(start, slope, top, bottom, is_level, np.median(profile.total[clean], 0))


def _with_look(line: ThinLine, part: _Part, profile: _Profile, clean: Integers, plain: Integers) -> ThinLine:
    """Return ``line`` with the ink that its ``plain`` rows tell: the ``clean`` rows with one ground around the line.

    The ink of a line between two grounds is known if the line fills whole pixels: the pixels beside it have none of it.
    """
    if len(plain) >= THIN_LINES.length_min:
        return line._replace(ink=np.median(profile.total[plain], 0), is_crisp=_is_crisp(profile, plain))
    own = profile_of(part.local, np.abs(part.local).sum(2), line.start, line.slope)
    if not _is_crisp(own, clean):
        return line
    x = np.floor(line.start + line.slope * (clean + 0.5)).astype(np.int64).clip(0, part.ink.shape[1] - 1)
    return line._replace(ink=np.median(part.residual[clean, x], 0), is_crisp=True)


def _is_crisp(profile: _Profile, rows: Integers) -> bool:
    """Return whether a line fills whole pixels in most of the ``rows``, and none beside them."""
    return bool(np.median(profile.most[rows] / np.maximum(profile.amount[rows], 1e-9)) > 0.97)
