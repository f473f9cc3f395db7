"""The records of what a run decided: made only for those who listen, and true to the drawing."""

from __future__ import annotations

import json
import logging

import numpy as np

import warpvec
from warpvec.watch import decisions
from warpvec.watch.decisions import noted


def disc(radius: float) -> np.ndarray:
    """Return a picture of a disc at (24, 24), anti-aliased by 8 x 8 samples a pixel."""
    y, x = (np.mgrid[:384, :384] + 0.5) / 8.0
    ink = (np.hypot(x - 24.0, y - 24.0) <= radius).reshape(48, 8, 48, 8).mean((1, 3))
    return np.rint(255.0 - ink[..., None] * [60.0, 200.0, 220.0]).astype(np.uint8)


def test_a_circle_says_why_it_is_one() -> None:
    with noted() as found:
        result = warpvec.vectorize(disc(14.0))
    assert result.metrics["circles"] == 1
    forms = [each for each in found if each.stage == "forms" and each.is_taken]
    assert forms and all(each.words > each.picture for each in forms)
    np.testing.assert_allclose(forms[-1].place, [10.0, 10.0, 38.0, 38.0], atol=0.2)
    assert [each.after for each in found if each.stage == "mode"] == [result.config.mode]
    assert json.loads(forms[-1].line())["taken"] is True


def test_nothing_is_recorded_unless_somebody_listens(monkeypatch) -> None:
    monkeypatch.setattr(decisions, "note", lambda decision: (_ for _ in ()).throw(AssertionError(decision)))
    monkeypatch.setattr("warpvec.flat.simplification.critic.note", decisions.note)
    warpvec.vectorize(disc(14.0))
    with noted():
        pass
    assert not decisions.LOGGER.handlers and decisions.LOGGER.level == logging.NOTSET
