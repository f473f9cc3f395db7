"""Numeric options at their edges end in a result or in one line, whatever the way in."""

from __future__ import annotations

import os
import random
import time

import pytest
import torture_options
from torture_case import OK, REFUSED

WORST = {
    "curves": ["9" * 400, "1_000"],
    "lr_points": ["1e308", "nan", "10.0"],
    "lr_scale": ["1e308"],
    "initial_radius": ["1e308", "9223372036854775807"],
    "iterations": ["1000000000", "9" * 400],
    "samples": ["1000000000000", "1024"],
    "segments": ["1000000", "256"],
    "time_budget": ["1e308", "1e9"],
    "threads": ["4096", "5000"],
    "seed": ["1" * 5000, "\u0661\u0662"],
}
"""Options and values that once ended in exit code 1, in a hang or in gigabytes."""


@pytest.fixture(autouse=True)
def prepared() -> None:
    torture_options.prepare()


def test_the_options_are_those_of_the_commands_and_the_settings() -> None:
    options = torture_options.numeric_options()
    assert {"curves", "every", "max_bytes", "lr_final", "threads"} <= set(options["run"])
    assert {"jobs", "retry"} <= set(options["batch"]) and "every" not in options["refine"]
    for names in ({"curves", "seed"}, {"lr_points"}):
        assert {name for each in torture_options.setups(frozenset(names)) for name, _ in each.values} == names


def test_the_worst_values_end_well() -> None:
    texts = [
        torture_options.Setup(way, "run", ((name, value),))
        for name, values in WORST.items()
        for value in values
        for way in ("line", "toml")
    ]
    python = [("seed", 10**5000), ("curves", 10**400), ("lr_points", 1e308), ("fit_size", 10**12), ("threads", 2**63)]
    calls = [torture_options.Setup("python", "vectorize", (pair,)) for pair in python]
    calls.append(torture_options.Setup("python", "vectorize", (("curves", 2**15), ("segments", 256))))
    faults: list[str] = []
    counts, _, _ = torture_options.run_all(
        iter([*texts, *calls, *torture_options.pairs(random.Random(1), 20)]),
        lambda setup, ended: faults.append(f"{setup.name}: {ended.outcome} {ended.detail}"),
    )
    assert not faults
    assert counts[OK] > 5 and counts[REFUSED] > 20


def test_a_fault_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = {"exception": lambda *_: 1 // 0, "crash": lambda *_: os._exit(3), "hang": lambda *_: time.sleep(60)}
    monkeypatch.setattr(torture_options, "SECONDS", 1.0)
    setup = torture_options.Setup("line", "run", (("seed", "1"),))
    for outcome, end in ends.items():
        monkeypatch.setattr(torture_options, "run_setup", end)
        assert torture_options.run_alone(setup).outcome == outcome
    monkeypatch.setattr(torture_options, "run_setup", lambda *_: OK)
    assert torture_options.run_alone(setup).outcome == OK
    monkeypatch.setattr(torture_options, "MAX_MEMORY", 1)
    assert torture_options.run_alone(setup).outcome == "memory"
