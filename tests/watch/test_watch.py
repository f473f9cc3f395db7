"""The watch over a run: deferred Ctrl-C, the clock, and the parts whose histories make that of the run."""

from __future__ import annotations

import math
import signal
import threading
from typing import Any

import pytest
from stubs import circles, progress_at

from warpvec.watch import watch as watching
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Watch

SCENE = circles(32, 48, 4)


def test_the_first_interrupt_is_deferred_and_the_second_raised() -> None:
    with Watch() as watch:
        assert not watch.is_stopped()
        signal.raise_signal(signal.SIGINT)
        assert watch.is_stopped() and watch.is_over()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert watch.facts().interrupted


class RaisesInDestructor:
    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


def test_an_interrupt_in_a_destructor_is_not_lost() -> None:
    with Watch() as watch:
        RaisesInDestructor()
        assert watch.is_stopped()


def test_the_callers_own_handler_stays() -> None:
    seen: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: seen.append(number))
    try:
        with Watch() as watch:
            signal.raise_signal(signal.SIGINT)
            assert not watch.is_stopped()
        assert seen == [signal.SIGINT]
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_threads_are_left_alone() -> None:
    found: list[bool] = []

    def work() -> None:
        with Watch() as watch:
            found.append(watch.is_stopped())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [False]


def test_a_part_within_a_run_gives_ctrl_c_back_only_with_the_run() -> None:
    with Watch() as watch:
        with watch.part():
            pass
        signal.raise_signal(signal.SIGINT)
        with watch.part() as later:
            assert later.is_stopped()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with Watch() as anew:
        assert not anew.is_stopped()


class Asked:
    """A listener that is asked to end the run after its first result."""

    def __init__(self) -> None:
        self.is_held = False

    def has_signal(self) -> bool:
        return self.is_held

    def hold(self) -> None:
        self.is_held = True


def test_a_given_listener_hears_of_the_first_result_and_stops_the_run() -> None:
    watch = Watch(listener=Asked())
    part = watch.part()
    assert not watch.is_stopped()
    part.report(progress_at(1, 9, SCENE))
    assert watch.is_stopped() and part.is_stopped()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time in seconds, in a list of one number."""
    now = [100.0]
    monkeypatch.setattr(watching.time, "perf_counter", lambda: now[0])
    return now


def test_parts_share_the_time_of_the_run(clock: list[float]) -> None:
    watch = Watch(time_budget=10.0)
    assert watch.part(share=0.3).time_budget == pytest.approx(3.0)
    assert watch.part(left=0.4).time_budget == pytest.approx(6.0)
    clock[0] += 8.0
    assert watch.part(share=0.3).time_budget == pytest.approx(2.0)
    assert watch.part(left=0.4).time_budget == watching.SECONDS_LEAST
    assert watch.has_time_for(0.2) and not watch.has_time_for(0.21)
    last = watch.part()
    clock[0] += 3.0
    assert watch.is_over() and last.is_late() and not watch.facts().interrupted
    assert watch.part().time_budget == watching.SECONDS_LEAST


def test_without_a_budget_there_is_always_time(clock: list[float]) -> None:
    watch = Watch()
    part = watch.part(share=0.1)
    clock[0] += 1e9
    assert (part.time_budget, watch.seconds_left()) == (None, math.inf)
    assert watch.has_time_for(1.0) and not watch.is_over() and not part.is_late()


def test_the_history_of_a_run_is_that_of_its_parts(clock: list[float]) -> None:
    seen: list[Progress] = []
    watch = Watch(seen.append)
    first = watch.part()
    for iteration in (1, 2, 3):
        first.report(progress_at(iteration, 3, SCENE), is_entry=iteration != 2)
    clock[0] += 5.0
    watch.side_part().report(progress_at(8, 9, SCENE), is_entry=True)
    second = watch.part(planned=7)
    for iteration in (1, 2):
        second.report(progress_at(iteration, 2, SCENE), is_entry=iteration == 2)
    facts = watch.facts()
    assert facts.iterations == watch.iterations == 5
    assert [(entry["iteration"], entry["seconds"]) for entry in facts.history] == [(1, 0.5), (3, 1.5), (5, 6.0)]
    # The second part is shown as what the run still plans, and the side part not at all.
    shown: list[tuple[Any, ...]] = [(each.iteration, each.iteration_count, each.seconds) for each in seen]
    assert shown == [(1, 3, 0.5), (2, 3, 1.0), (3, 3, 1.5), (4, 7, 5.5), (5, 7, 6.0)]


def test_a_part_that_was_interrupted_makes_the_run_interrupted(clock: list[float]) -> None:
    watch = Watch()
    part = watch.part()
    part.interrupted = True
    assert part.result(SCENE, "cpu").interrupted
    assert watch.facts().interrupted


def test_a_resumed_part_goes_on_with_its_seconds_iterations_and_history(clock: list[float]) -> None:
    watch = Watch(time_budget=10.0)
    part = watch.part()
    entry = {"iteration": 20, "curves": 4, "psnr": 20.0, "seconds": 6.0}
    part.resume(7.0, 25, [entry])
    assert (part.seconds(), watch.seconds_left(), watch.iterations) == (7.0, 3.0, 25)
    assert watch.facts().history == [entry]


def test_a_watch_ahead_is_over_while_a_share_of_the_time_is_left() -> None:
    watch = Watch(time_budget=10.0)
    watch.resume(7.5)
    assert watch.ahead(0.3).is_over() and not watch.ahead(0.2).is_over() and not watch.is_over()
    endless = Watch()
    assert endless.ahead(0.3) is endless
