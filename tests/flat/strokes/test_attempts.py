"""The ladder of attempts to draw a path as a stroke."""

from __future__ import annotations

import numpy as np

from warpvec.flat.simplification.form_candidates import Candidate
from warpvec.flat.strokes.attempts import Attempt, Match
from warpvec.flat.strokes.line_fitting import Rows
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
