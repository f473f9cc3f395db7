"""The room of the published methods is no part of the rest: without it, warpvec works without what it adds."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import warpvec

FIT = """
import sys
from pathlib import Path
import numpy as np
import warpvec
assert Path(warpvec.__file__).is_relative_to(sys.argv[1])
photo = np.random.default_rng(0).integers(0, 256, (16, 24, 3), dtype=np.uint8)
result = warpvec.vectorize(photo, 4, mode="photo", iterations=3, threads=1)
print(result.metrics["curves"], *sorted(warpvec.PRESETS), hasattr(result.config, "samples"))
try:
    warpvec.vectorize(photo, 4, renderer="splat")
except warpvec.InputError as error:
    print(error)
from warpvec.__main__ import main
sys.argv = ["warpvec", "run", "--help-all"]
main()
"""


@pytest.mark.slow
def test_without_the_folder_paper_and_its_line_warpvec_works(tmp_path: Path) -> None:
    package = tmp_path / "warpvec"
    shutil.copytree(Path(warpvec.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.rmtree(package / "paper")
    rooms = package / "config" / "rooms.py"
    lines = rooms.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line.replace('("warpvec.paper",)', "()") for line in lines]
    assert sum(old != new for old, new in zip(lines, kept, strict=True)) == 1
    rooms.write_text("".join(kept), encoding="utf-8")
    words = [sys.executable, "-c", FIT, str(tmp_path)]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    first, refusal, *_ = done.stdout.splitlines()
    assert first == "4 best default draft False"
    assert refusal.startswith("renderer must be one of exact, got 'splat'")
    help_text = done.stdout.partition("Usage:")[2]
    assert "--iterations" in help_text
    assert not [word for word in ("--samples", "splat ", "sides ", "replacement") if word in help_text]
