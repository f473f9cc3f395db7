"""A thousand damaged files of each kind, the same on every machine, give a result or an error of one line."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import fuzz
import pytest

FUZZ = Path(fuzz.__file__)
COUNT = 1000


@pytest.mark.parametrize("kind", ["png", "jpeg", "webp", "tiff", "svg"])
def test_damaged_files_give_a_result_or_one_line(kind):
    # A child process, because its memory is limited. libtiff writes to stderr by itself.
    command = [sys.executable, "-W", "error", str(FUZZ), kind, str(COUNT)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    report = json.loads(done.stdout)
    assert report["faults"] == []
    # Some damage must go unnoticed and some files must be refused.
    assert min(report["outcomes"].values()) > COUNT / 20 and len(report["outcomes"]) == 2


def test_faults_of_a_reader_are_found():
    def fails(_: bytes) -> None:
        raise KeyError(1)

    def exits(_: bytes) -> None:
        sys.exit(3)

    assert fuzz._outcome(fails, b"") == "KeyError(1)"
    assert fuzz._outcome(exits, b"") == "SystemExit(3)"
    assert fuzz._outcome(bytes, b"") == "result"


def test_equal_seeds_give_equal_files():
    assert fuzz.damaged_files("png", 20, 1) == fuzz.damaged_files("png", 20, 1) != fuzz.damaged_files("png", 20, 2)
