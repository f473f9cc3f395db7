"""Find runs of segments that one line or one cubic can replace, and measure what each change costs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.outline_samples import OutlineSamples
from warpvec.flat.simplification.span_fitting import Ends, FittedSpans, Span, fit_cubics, fit_lines, spans_of


@dataclass(frozen=True, eq=False)
class Outlines:
    """The closed outlines of a scene, as arrays.

    Attributes:
        samples: points of all R segments.
        is_line: which segments are lines [R].
        is_smooth: which segments start at a smooth node [R].
        tangents: unit direction of the outline at the start of each segment [R, 2]; 0 at corners.
        preceding: row before each in its loop [R].
        loop_first: first row of each loop, and R last [L + 1].
    """

    samples: OutlineSamples
    is_line: Mask
    is_smooth: Mask
    tangents: Floats
    preceding: Integers
    loop_first: Integers


@dataclass(frozen=True, eq=False)
class CandidateSpans:
    """Candidates: K spans of ``size`` segments from ``first`` on [K], as a cubic or a line.

    ``cost`` [K, 2] is that of the cubic and of the line, infinite where it is not allowed; ``handles`` [K, 2, 2, 2].
    """

    first: Integers
    size: int
    cost: Floats
    handles: Floats


def span_candidates(outlines: Outlines, detail: Floats) -> Iterator[CandidateSpans]:
    """Yield the spans of 1, 2, ... segments that may replace theirs."""
    sizes = np.diff(outlines.loop_first)
    loop_start = np.repeat(outlines.loop_first[:-1], sizes)
    loop_size = np.repeat(sizes, sizes)
    rows = np.arange(len(loop_start))
    corners, is_straight = _corners(outlines), _straight_lines(outlines)
    is_open = np.ones(len(rows), np.bool_)  # spans from here that may be extended
    for size in range(1, SIMPLIFICATION.span_segments_max + 1):
        first = rows[is_open & (loop_size > size)] if size > 1 else rows
        if not len(first):
            return
        place = (first - loop_start[first])[:, None] + np.arange(size)
        members = loop_start[first, None] + place % loop_size[first, None]
        free = ~corners[members[:, 1:]].any(1)
        first, members = first[free], members[free]
        if not len(first):
            return
        after = loop_start[first] + (first - loop_start[first] + size) % loop_size[first]
        spans, excess = _fitted(outlines, members, after, detail, is_straight)
        if size == 1:
            spans.cost[loop_size == 1, 1] = np.inf
        yield spans
        hopeful = np.zeros(len(rows), np.bool_)
        hopeful[first[excess < SIMPLIFICATION.hopeless]] = True
        following = loop_start + (rows - loop_start + 1) % loop_size
        is_open = hopeful | hopeful[following] if size > 1 else np.ones(len(rows), np.bool_)


def _corners(outlines: Outlines) -> Mask:
    """Return which nodes [R] are clear corners."""
    cosine, preceding = _cosine(outlines), outlines.preceding
    is_turned = cosine < np.cos(np.radians(SIMPLIFICATION.corner_degrees))
    leg_min = np.where(_line_corners(outlines), SIMPLIFICATION.line_leg, SIMPLIFICATION.corner_leg)
    seen = outlines.samples.seen
    return is_turned & (np.minimum(seen, seen[preceding]) >= leg_min)


def _cosine(outlines: Outlines) -> Floats:
    """Return the cosine of the turn at each node [R]."""
    samples = outlines.samples
    ahead = samples.points[:, 0] - samples.control[:, 0]
    behind = (samples.control[:, 3] - samples.points[:, -1])[outlines.preceding]
    product = np.linalg.norm(ahead, axis=1) * np.linalg.norm(behind, axis=1)
    cosine = np.divide((ahead * behind).sum(1), product, out=np.ones(len(product)), where=product > 0.0)
    return np.asarray(cosine)  # 1 where a segment has no direction


def _line_corners(outlines: Outlines) -> Mask:
    """Return at which nodes [R] a level or upright line ends with a sharp turn."""
    is_sharp = _cosine(outlines) < np.cos(np.radians(SIMPLIFICATION.line_corner_degrees))
    across = np.abs(outlines.samples.control[:, 3] - outlines.samples.control[:, 0])
    is_upright = across.min(1) <= np.sin(np.radians(SIMPLIFICATION.line_lean_degrees)) * np.linalg.norm(across, axis=1)
    is_stem = outlines.is_line & is_upright
    return is_sharp & (is_stem | is_stem[outlines.preceding])


def _straight_lines(outlines: Outlines) -> Mask:
    """Return which segments [R] are lines that are straight on purpose: long ones, and those that end sharply."""
    ends = _line_corners(outlines)
    is_sharp = ends.copy()
    is_sharp[outlines.preceding[ends]] = True
    length_min = np.where(is_sharp, SIMPLIFICATION.line_sharp, SIMPLIFICATION.line_long)
    return outlines.is_line & (outlines.samples.seen >= length_min)


def _fitted(
    outlines: Outlines, members: Integers, after: Integers, detail: Floats, is_straight: Mask
) -> tuple[CandidateSpans, Floats]:
    """Return the spans of ``members`` [K, k], and the least error of each in what is allowed.

    No cubic may replace segments [R] that are ``is_straight``.
    """
    samples, first, last = outlines.samples, members[:, 0], members[:, -1]
    ends = Ends(samples.control[first, 0], samples.control[last, 3], outlines.tangents[first], outlines.tangents[after])
    span, detail = spans_of(samples, members), detail[members].min(1)
    line = fit_lines(span.points, ends)
    line_cost, line_excess = _allowed(line, span, samples, detail)
    control, before = samples.control, outlines.preceding[first]
    handles = control[before, 3] - control[before, 2], control[after, 1] - control[after, 0]
    line_cost[_is_turned(ends, handles)] = np.inf
    if members.shape[1] == 1:
        old, is_line = samples.control[first, 1:3], outlines.is_line[first]
        cost = np.stack([np.where(is_line, np.inf, 0.0), np.where(is_line, 0.0, line_cost)], 1)
        return CandidateSpans(first, 1, cost, np.stack([old, line.handles], 1)), np.zeros(len(first))
    cubic = fit_cubics(span, ends)
    cost, excess = _allowed(cubic, span, samples, detail)
    has_line = is_straight[members].any(1)
    cost[has_line | (outlines.is_line[members].all(1) & np.isfinite(line_cost))] = np.inf
    spans = CandidateSpans(
        first, members.shape[1], np.stack([cost, line_cost], 1), np.stack([cubic.handles, line.handles], 1)
    )
    return spans, np.minimum(excess, line_excess)


def _allowed(fits: FittedSpans, span: Span, samples: OutlineSamples, detail: Floats) -> tuple[Floats, Floats]:
    """Return the costs of fits [K], infinite where they are not allowed, and how many times the allowed one each is."""
    distance = np.linalg.norm(fits.places - span.points, axis=-1)
    weight = span.visibility * span.lengths
    cost = (np.square(distance) * weight).sum(1) + fits.price
    mean = cost / (detail**2 * weight.sum(1) + 1e-9)
    peak = np.square(distance * np.sqrt(span.visibility)).max(1) / (SIMPLIFICATION.peak * detail) ** 2
    excess = np.maximum(mean, peak)
    is_allowed = excess <= 1.0
    hidden = (span.visibility < SIMPLIFICATION.hidden_visibility) & (distance > SIMPLIFICATION.exposure)
    some = np.flatnonzero(is_allowed & hidden.any(1))
    is_allowed[some] = _stays_hidden(fits.places[some], span, samples, some, hidden[some])
    return np.where(is_allowed, cost, np.inf), excess


def _stays_hidden(places: Floats, span: Span, samples: OutlineSamples, some: Integers, moves: Mask) -> Mask:
    """Return which of the spans ``some`` [K] stay hidden on the way to ``places`` [K, M, 2] where each ``moves``."""
    points, path = span.points[some], span.path[some]
    offset = places - points
    is_seen = np.linalg.norm(offset, axis=-1) > SIMPLIFICATION.hidden_move
    for step in range(1, SIMPLIFICATION.sweep_steps + 1):
        is_seen |= ~samples.is_hidden(path, points + offset * (step / SIMPLIFICATION.sweep_steps))
    # Points that spread far apart say nothing of what is between them.
    before, after = (np.linalg.norm(np.diff(each, axis=1), axis=-1) for each in (points, places))
    spreads = after > 2.0 * before + 1.0
    is_seen[:, 1:] |= spreads
    is_seen[:, :-1] |= spreads
    return ~(is_seen & moves).any(1)


def _is_turned(ends: Ends, handles: tuple[Floats, Floats]) -> Mask:
    """Return which lines turn away from the tangent at one of their ends, beyond which there are ``handles`` [K, 2]."""
    chord = ends.end - ends.start
    unit = chord / np.maximum(np.linalg.norm(chord, axis=1), 1e-9)[:, None]
    turned = np.zeros(len(unit), np.bool_)
    for tangent, handle in zip((ends.leaving, ends.arriving), handles, strict=True):
        sine = np.abs(unit[:, 0] * tangent[:, 1] - unit[:, 1] * tangent[:, 0])
        away = (unit * tangent).sum(1) < np.cos(np.radians(SIMPLIFICATION.line_turn))
        turned |= tangent.any(1) & (away | (sine * np.linalg.norm(handle, axis=1) > SIMPLIFICATION.turn_move))
    return turned
