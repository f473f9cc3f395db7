"""The attempts to draw a path as a stroke: the simplest first, then with round corners, then with more rows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats32
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.saying import are_curves, said_rows
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.form_candidates import Candidate, candidates
from warpvec.flat.simplification.local_error import errors_in_boxes
from warpvec.flat.simplification.outline_samples import cubic_points, cubic_slopes
from warpvec.flat.strokes.line_fitting import Rows, cost_of, curves_of
from warpvec.flat.strokes.round_corners import corners_of, with_round_corners
from warpvec.flat.strokes.stroke import Stroke

_EXACT = -1
"""Which of ``STROKES.again_shares`` says lines again that match the picture already: the finest."""

_SAMPLES = 16
"""Points of a curve at which its distance from others is taken."""


class Match(Enum):
    """How well a stroke matches the picture: not, well enough, or without a difference that shows.

    One that is `LONG` does so too, but takes more numbers than its outline.
    """

    REFUSED = auto()
    LONG = auto()
    ACCEPTED = auto()
    CLOSE = auto()


@dataclass(frozen=True)
class Attempt:
    """What is known of a path that may become a stroke.

    Attributes:
        first: the stroke as it was found, fitted to the picture.
        detail: as in `find_strokes`.
        nats: of a number.
        next: the stroke that is to be tried; None if there is none.
        best: the best one so far, fitted to the picture; None if there is none. It is the simplest stroke without a
            visible difference. If all strokes differ, it is the last accepted one, which has the most freedom.
        is_close: whether the best one matches without a difference.
        cost: numbers of the best one as it was tried: a fit turns arcs into other cubics.
        level: which of ``STROKES.again_shares`` said how far its lines may move. After these they have twice the rows.
        rise: by how much the error [h, w] rose with sharp corners; None before that is known.
    """

    first: Stroke
    detail: float
    nats: float
    next: Stroke | None
    best: Stroke | None = None
    is_close: bool = False
    cost: float = 0.0
    level: int = 0
    rise: Floats32 | None = None

    @staticmethod
    def of(fitted: Stroke, match: Match, detail: float, nats: float) -> Attempt:
        """Return the first attempt for a stroke as it was found, fitted to the picture."""
        best = fitted if match in (Match.ACCEPTED, Match.CLOSE) else None
        first = Attempt(fitted, detail, nats, None, best, match is Match.CLOSE, fitted.cost)
        return first._with(first._simpler(fitted))

    @property
    def is_over(self) -> bool:
        """Whether nothing is left to try."""
        return self.next is None

    @property
    def stroke(self) -> Stroke | None:
        """The stroke to draw: the next one, else the best."""
        return self.best if self.next is None else self.next

    def after(self, fitted: Stroke, match: Match, rise: Floats32) -> Attempt:
        """Return what is known after the next stroke was drawn.

        Args:
            fitted: that stroke, fitted to the picture.
            match: how well it matches the picture.
            rise: by how much the error [h, w] rose.
        """
        if self.next is None:
            return self
        if match is Match.CLOSE:
            return replace(self, best=fitted, is_close=True, cost=self.next.cost)._with(self._simpler(fitted))
        best = fitted if match is Match.ACCEPTED and not self.is_close else self.best
        if match is Match.LONG and (shorter := self._simpler(fitted, _EXACT)).cost < self.next.cost:
            return replace(self, next=shorter, best=best)
        level, count = self.level + 1, len(STROKES.again_shares)
        sharp = rise if self.rise is None else self.rise
        if level > count:
            return replace(self, next=None, best=best)
        free = fitted.with_halves() if level == count else _rounded(self._simpler(self.first, level), sharp)
        return replace(self, level=level, rise=sharp, best=best)._with(free)

    def _with(self, stroke: Stroke) -> Attempt:
        """Return this with another stroke to try, unless the best one matches as well and is as simple."""
        is_needed = self.best is None or not self.is_close or stroke.cost < self.cost
        return replace(self, next=stroke if is_needed else None)

    def _simpler(self, stroke: Stroke, level: int = 0) -> Stroke:
        """Return a fitted stroke with as few rows as its lines need, and with forms for closed lines that have one."""
        share = STROKES.again_shares[level]
        lines = [said_again(line, share * self.detail, self.nats) for line in stroke.lines]
        stroke = replace(stroke, lines=lines)
        reach = STROKES.form_share * share * self.detail
        forms = [None if line.is_open else _form_of(stroke, k, reach) for k, line in enumerate(lines)]
        return replace(stroke, forms=forms)


def said_again(line: Rows, spread: float, nats: float) -> Rows:
    """Return the cheapest rows of a ``line`` whose places have a deviation of ``spread`` pixels, as chains have them.

    ``nats`` is what a number costs.
    """
    curves = curves_of(line)
    curves = curves[are_curves(curves)]
    if not len(curves):
        return line
    found = Rows(*said_rows({0: Chain.of(curves, not line.is_open)}, spread, nats)[0], line.is_open)
    return found if cost_of(found) < cost_of(line) else line


def _rounded(stroke: Stroke, rise: Floats32) -> Stroke:
    """Return a stroke with round corners where sharp ones have raised the error [h, w] most, and more than elsewhere.

    Forms stay.
    """
    free = [line for line, form in zip(stroke.lines, stroke.forms, strict=True) if form is None]
    if not free:
        return stroke
    corners = [corners_of(line) for line in free]
    places = np.concatenate([curves_of(line)[is_corner, 0] for line, is_corner in zip(free, corners, strict=True)])
    if not len(places):
        return stroke
    reach = STROKES.round_near * stroke.width
    found = errors_in_boxes(rise, places - reach, places + reach)
    middles = np.concatenate([cubic_points(curves_of(line), np.array([0.5])) for line in free]).reshape(-1, 2)
    elsewhere = errors_in_boxes(rise, middles - reach, middles + reach).mean()
    least = max(STROKES.round_error * found.max(), elsewhere)
    lines = list(stroke.lines)
    for k, form in enumerate(stroke.forms):
        if form is None:
            is_corner = corners.pop(0)
            is_worst = is_corner.copy()
            is_worst[is_corner], found = found[: is_corner.sum()] >= least, found[is_corner.sum() :]
            lines[k] = with_round_corners(lines[k], is_worst, stroke.width)
    return replace(stroke, lines=lines)


def _form_of(stroke: Stroke, number: int, tolerance: float) -> Candidate | None:
    """Return the form of a closed line of a stroke, None if it has none. What lies under other lines is no evidence."""
    others = [line for k, line in enumerate(stroke.lines) if k != number]
    return form_of_line(stroke.lines[number], others, stroke.width, tolerance)


def form_of_line(line: Rows, others: list[Rows], width: float, tolerance: float) -> Candidate | None:
    """Return the form of a closed ``line`` within ``tolerance`` pixels; what lies under ``others`` is no evidence."""
    t = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    curves = curves_of(line)
    points = cubic_points(curves, t)
    lengths = np.linalg.norm(cubic_slopes(curves, t), axis=-1) / _SAMPLES
    if others:
        over = np.concatenate([cubic_points(curves_of(other), t) for other in others]).reshape(-1, 2)
        near, _ = cKDTree(over).query(points)
        lengths = np.where(near < STROKES.meeting_reach * width, 0.0, lengths)
    return next(candidates(points, lengths, line.is_line, tolerance), None)
