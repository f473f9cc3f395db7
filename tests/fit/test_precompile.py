"""`warpvec info --compile` leaves nothing to compile for a run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from warpvec.errors import InputError
from warpvec.fit.precompile import compile_kernels
from warpvec.image.write import write_png


def warpvec(cache: Path, *arguments: object) -> None:
    environment = {**os.environ, "WARP_CACHE_PATH": str(cache)}
    command = [sys.executable, "-m", "warpvec", *map(str, arguments)]
    subprocess.run(command, env=environment, check=True, capture_output=True, timeout=300)


def modules(cache: Path) -> set[str]:
    return {path.name for path in cache.rglob("wp_*") if path.is_dir()}


@pytest.mark.slow  # it compiles all kernels
def test_a_run_after_it_compiles_nothing(tmp_path: Path) -> None:
    cache, photo = tmp_path / "cache", tmp_path / "photo.png"
    write_png(photo, np.random.default_rng(0).random((40, 56, 3), dtype=np.float32))
    warpvec(cache, "info", "--compile")
    compiled = modules(cache)
    assert len(compiled) > 10
    settings = ["--curves", 20, "--device", "cpu", "--quiet"]
    warpvec(cache, "run", photo, tmp_path / "a.svg", "--iterations", 60, "--recycle-gap", 10, *settings)
    warpvec(cache, "run", photo, tmp_path / "b.svg", "--preset", "paper", "--iterations", 5, *settings)
    ramps = ["--gradients", 8, "--iterations", 60, "--recycle-gap", 10]
    warpvec(cache, "run", photo, tmp_path / "c.svg", *ramps, *settings)
    assert modules(cache) == compiled


def test_an_unknown_device_is_refused() -> None:
    with pytest.raises(InputError, match="device must be"):
        compile_kernels("tpu")
