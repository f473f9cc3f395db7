"""Hostile inputs give a result or an error of one line; and the bench that makes them sees every kind of fault."""

from __future__ import annotations

import json
import os
import random
import tempfile
from collections import Counter

import pytest
import torture
import torture_changes
import torture_checkpoints
import torture_corpus
import torture_image_files
import torture_images
import torture_svgs
import torture_toml
from torture_case import OK, REFUSED, Wrong
from torture_runner import Ended, run_all

# The runner kills a case that hangs. It only waits meanwhile, for many cases in a row.
pytestmark = [pytest.mark.slow, pytest.mark.longest_wait(600)]

CASES = {
    "images": 60,
    "svgs": 40,
    "checkpoints": 100,
    "toml": 50,
    "commands": 40,
    "batch": 1,
    "options": 30,
    "disks": 1,
    "kills": 1,
}
"""Numbers of cases that together take about half a minute on two cores; `bench/torture.py` runs any number."""

PATIENCE = 5.0
"""Factor of all time limits: other tests run at the same time. Hangs are found all the same."""

FAKE_KIND = """
import ctypes, os, tempfile, time
from pathlib import Path
from torture_case import OK, Case, Wrong
from warpvec.errors import InputError

def fail():
    raise KeyError(1)

def refuse(rule):
    raise InputError("x", rule)

def fill_the_memory():
    data = b"x" * (2**31 + 2**28)
    time.sleep(len(data))

def case(chance):
    return Case("a name", lambda folder: {run} or OK, b"the input", seconds=0.2 if "hang" in __name__ else 30.0)
"""

BEHAVIOURS = {
    "work": ("None", "ok"), "refuse": ("refuse('must be y')", "refused"), "fail": ("fail()", "exception"),
    "exit": ("exit(3)", "exception"), "say_much": ("refuse('must be\\ny')", "wrong"), "crash": ("os.abort()", "crash"),
    "end": ("os._exit(0)", "crash"), "hang": ("time.sleep(60)", "hang"),
    "leave": ("tempfile.mkdtemp() and OK", "wrong"),
    "leave_beside": ("Path('.warpvec-1.tmp').touch()", "wrong"), "fill": ("fill_the_memory()", "memory"),
}  # fmt: skip
"""Name of a kind -> what its case does, and how that must be counted."""


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    torture.warm_up()


def tortured(folder, kinds, limits, seed=0):
    """Run so many cases of the kinds; return the counts of each kind, and the faults."""
    shares = dict.fromkeys(kinds, 1.0)
    tallies, faults = run_all(shares, seed, limits, folder / "faults", patience=PATIENCE, report=lambda _: None)
    return {kind: tally.outcomes for kind, tally in tallies.items()}, faults


def shown(faults: list[Ended]) -> str:
    return "\n".join(f"{fault.kind} {fault.number}: {fault.outcome} {fault.detail} ({fault.name})" for fault in faults)


# Cases of the largest pictures come last. They take 2 GB, too much for tests that run side by side.
def test_no_fault_of_the_corpus_is_back(tmp_path):
    count = sum(not name.startswith(torture_corpus.LARGEST) for name, _ in torture_corpus.entries())
    counts, faults = tortured(tmp_path, ["corpus"], {"corpus": count})
    assert not faults, shown(faults)
    assert counts["corpus"].total() == count > 10


@pytest.mark.parametrize("kind", list(CASES))
def test_hostile_inputs_give_a_result_or_one_line(kind, tmp_path):
    counts, faults = tortured(tmp_path, [kind], CASES)
    assert not faults, shown(faults)
    assert counts[kind].total() == CASES[kind]
    # Some damage must go unnoticed and some files must be refused, or the cases are no good.
    assert min(counts[kind][OK], counts[kind][REFUSED]) > CASES[kind] / 25 or CASES[kind] < 10


def test_every_kind_of_fault_is_seen_and_kept(tmp_path, monkeypatch):
    for name, (run, _) in BEHAVIOURS.items():
        (tmp_path / f"torture_fake_{name}.py").write_text(FAKE_KIND.replace("{run}", run))
    monkeypatch.syspath_prepend(tmp_path)
    kinds = [f"fake_{name}" for name in BEHAVIOURS]
    counts, faults = tortured(tmp_path, kinds, dict.fromkeys(kinds, 1))
    expected = {f"fake_{name}": Counter([outcome]) for name, (_, outcome) in BEHAVIOURS.items()}
    assert counts == expected, shown(faults)
    for fault in faults:
        path = tmp_path / "faults" / f"{fault.kind}-0-0.json"
        assert json.loads(path.read_text())["outcome"] == fault.outcome
        assert path.with_suffix(".input").read_bytes() == b"the input"


def test_a_file_that_is_opened_beside_the_drawing_is_seen(tmp_path, monkeypatch):
    monkeypatch.setitem(torture_svgs.READERS, "opens", lambda data, folder: (folder / "p.png").read_bytes())
    with pytest.raises(Wrong, match="p.png was opened"):
        torture_svgs.check(b"", tmp_path, "opens")


def test_words_of_native_code_are_seen(tmp_path, monkeypatch):
    monkeypatch.setitem(torture_images.WAYS, "talks", lambda data, folder: os.write(2, b"TIFF: ..."))
    with tempfile.TemporaryFile() as stream:
        before = os.dup(2)
        os.dup2(stream.fileno(), 2)
        try:
            with pytest.raises(Wrong, match="stderr"):
                torture_images.check(b"", tmp_path, "talks")
        finally:
            os.dup2(before, 2)
            os.close(before)


@pytest.mark.parametrize("module", [torture_images, torture_svgs, torture_checkpoints, torture_toml])
def test_equal_seeds_give_equal_inputs(module):
    first, again, other = (
        [module.case(random.Random(seed + number)).data for number in range(20)] for seed in (0, 0, 100)
    )
    assert first == again != other


@pytest.mark.parametrize("name", torture_checkpoints.SETTINGS)
def test_checkpoints_are_accepted_before_they_are_damaged(name, tmp_path):
    assert torture_checkpoints.check(torture_checkpoints.checkpoint_of(name), tmp_path, name) == OK


def test_a_changed_png_keeps_its_checksums():
    (data, *_) = torture_image_files.seeds("png")
    cut = data.replace(b"IDAT", b"IDAX")
    assert torture_changes.with_checksums(data) == data
    assert torture_changes.with_checksums(cut) != cut
