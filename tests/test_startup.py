"""What a run must not import: torch's compiler, which takes half a second and is not used by any fit."""

from __future__ import annotations

import subprocess
import sys

import pytest

FIT = """
import sys
import numpy as np
from warpvec import vectorize
noise = np.random.default_rng(0).random((16, 16, 3), dtype=np.float32)
result = vectorize(noise, curves=4, initial_curves=2, iterations=6, inflation_gap=1, renderer={renderer!r})
assert result.metrics["curves"] == 4
print("torch._dynamo" in sys.modules)
"""


@pytest.mark.parametrize("renderer", ["exact", "splat"])
def test_a_run_does_not_import_the_compiler(renderer: str) -> None:
    assert _last_line(FIT.format(renderer=renderer)) == "False"


def test_help_imports_neither_torch_nor_warp_nor_numpy() -> None:
    names = ("torch", "warp", "numpy")
    assert _last_line(f"import sys, warpvec.cli; print(any(name in sys.modules for name in {names}))") == "False"


def _last_line(code: str) -> str:
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return run.stdout.splitlines()[-1]
