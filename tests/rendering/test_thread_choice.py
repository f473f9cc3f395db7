"""The number of threads follows what a simulated machine does: all when it is idle, fewer where sharing does harm."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from warpvec.rendering.thread_choice import Launch, ThreadChoice

WORK = 0.004
"""CPU seconds of a launch."""

Machine = Callable[[int], tuple[float, float]]
"""Gives, for a number of threads, the wall seconds of a launch and the share of their time that threads lose."""


def idle(count: int) -> tuple[float, float]:
    return WORK / count, 0.02


def crowded(count: int) -> tuple[float, float]:
    return WORK * (5.0 if count == 1 else 6.5), 0.8


def gaining(count: int) -> tuple[float, float]:
    return WORK / (0.9 if count == 1 else 1.5), 0.3


def losing(count: int) -> tuple[float, float]:
    return WORK / (0.9 if count == 1 else 0.8), 0.3


def counts_on(machine: Machine, choice: ThreadChoice, launches: int) -> list[int]:
    """Return the number of threads of each launch."""
    counts = []
    for _ in range(launches):
        counts.append(choice.count)
        wall, lost = machine(choice.count)
        cpu = WORK / choice.count
        choice.record(Launch("kernel", 100, wall, choice.count * cpu / (1 - lost), choice.count * cpu))
    return counts


def test_an_idle_machine_uses_all_threads() -> None:
    assert set(counts_on(idle, ThreadChoice(4), 2000)) == {4}


def test_a_crowded_machine_uses_one_thread_until_it_is_idle_again() -> None:
    choice = ThreadChoice(4)
    crowd = counts_on(crowded, choice, 2000)
    assert crowd.count(4) <= 20 and set(crowd[20:]) == {1}
    assert set(counts_on(idle, choice, 200)[100:]) == {4}


@pytest.mark.parametrize(("machine", "best"), [(gaining, 2), (losing, 1)])
def test_on_a_busy_machine_trials_decide(machine: Machine, best: int) -> None:
    counts = counts_on(machine, ThreadChoice(2), 4000)
    assert counts.count(best) > 0.93 * len(counts)
    assert counts.count(3 - best) > 0.02 * len(counts)  # it tries again from time to time


def test_a_thread_that_works_slower_beside_another_is_no_gain() -> None:
    """Two threads on siblings of one core take twice the CPU time each: the same work is not done sooner."""
    choice = ThreadChoice(2)
    counts = []
    for _ in range(4000):
        counts.append(choice.count)
        cpu = WORK * choice.count
        choice.record(Launch("kernel", 100, 1.25 * WORK, cpu / 0.8, cpu))
    assert counts.count(1) > 0.9 * len(counts)


def test_one_thread_is_no_choice() -> None:
    assert set(counts_on(crowded, ThreadChoice(1), 100)) == {1}
