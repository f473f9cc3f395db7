"""The ladder of attempts to draw a path as a stroke."""

from __future__ import annotations

import numpy as np

from warpvec.flat.price import ARC
from warpvec.flat.simplification.form_candidates import Candidate
from warpvec.flat.strokes.attempts import Attempt, Match
from warpvec.flat.strokes.line_fitting import Rows, cost_of
from warpvec.flat.strokes.stroke import Stroke
from warpvec.geometry.forms.registry import CIRCLE
from warpvec.geometry.strokes import BUTT, ROUND

NO_RISE = np.zeros((64, 64), np.float32)


def _ring() -> Stroke:
    circle = Candidate(CIRCLE, np.array([30.0, 31.0, 20.0, 0.0, 0.0, 0.0]))
    line = Rows(circle.curves, np.zeros(len(circle.curves), np.bool_), False)
    return Stroke([0, 1], [line], 4.0, BUTT, ROUND, [None])


def test_a_ring_that_the_picture_refuses_is_tried_until_the_ladder_ends() -> None:
    attempt = Attempt.of(_ring(), Match.REFUSED, 0.1, 8.5)
    tried = 0
    while not attempt.is_over:
        assert attempt.stroke is not None and attempt.stroke.forms[0] is not None  # no corner could be round
        attempt, tried = attempt.after(attempt.stroke, Match.REFUSED, NO_RISE), tried + 1
    assert attempt.best is None and tried > 1


def test_a_stroke_that_is_longer_than_its_outline_is_not_drawn() -> None:
    attempt = Attempt.of(_ring(), Match.LONG, 0.1, 8.5)
    while attempt.next is not None:
        attempt = attempt.after(attempt.next, Match.LONG, NO_RISE)
    assert attempt.stroke is None


def test_arcs_of_one_circle_are_said_once() -> None:
    (ring,) = _ring().lines
    end = ring.control[-1:, :1].repeat(3, 1)
    half = Rows(
        np.concatenate([ring.control[:2], ring.control[2:3, :1].repeat(3, 1)]), np.array([False, False, True]), True
    )
    quarter = Rows(np.concatenate([ring.control[-2:-1], end]), np.array([False, True]), True)
    assert cost_of(ring) == cost_of(half) == cost_of(quarter) == ARC


def test_of_what_is_only_accepted_the_last_stays_until_one_is_close() -> None:
    attempt = Attempt.of(_ring(), Match.ACCEPTED, 0.1, 8.5)
    assert attempt.best is not None and not attempt.is_over
    freer = _ring()
    attempt = attempt.after(freer, Match.ACCEPTED, NO_RISE)
    assert attempt.best is freer and not attempt.is_close
    attempt = attempt.after(_ring(), Match.REFUSED, NO_RISE)
    assert attempt.best is freer
    close = _ring()
    attempt = attempt.after(close, Match.CLOSE, NO_RISE)
    assert attempt.best is close and attempt.is_close
