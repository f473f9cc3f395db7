"""Progress that is shown now and then: when, and with which time left."""

from __future__ import annotations

from dataclasses import replace

import pytest
from stubs import circles, progress_at

from warpvec.watch import progress as reports
from warpvec.watch.progress import Regularly


def test_the_time_left_of_a_second_fit_is_from_its_own_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    now, lines, scene = 0.0, list[str](), circles(8, 8, 5)
    monkeypatch.setattr(reports.time, "monotonic", lambda: now)
    reporter = Regularly(lambda _, text: lines.append(text), 0.5)
    for iteration in range(1, 11):
        reporter(replace(progress_at(iteration, 10, scene), seconds=100.0 + iteration))
    for iteration in range(1, 21):
        now = 0.0 if iteration < 20 else 9.0
        reporter(progress_at(iteration, 40, scene))
    assert lines[-1] == "iteration 20 of 40, 5 paths, 20.00 dB, 10 s left"
