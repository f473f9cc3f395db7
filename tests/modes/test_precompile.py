"""`warpvec info --compile` leaves nothing to compile for a run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.image.write import write_png
from warpvec.modes.precompile import compile_kernels

NOTED = """
import os
import warp as wp
from warpvec.__main__ import main

load, kernels = wp.Module.load, set()

def note(module, *arguments, **options):
    loaded = load(module, *arguments, **options)
    kernels.add(f"{module.name} {loaded.module_hash.hex()}")
    return loaded

wp.Module.load = note
try:
    main()
finally:
    print(wp.config.kernel_cache_dir, *sorted(kernels), sep="\\n", file=open(os.environ["NOTED"], "w"))
"""
"""A command that notes which forms of the kernels it loads, and from where: cached ones take no time to be compiled."""


def loaded(noted: Path, *arguments: object) -> set[str]:
    command = [sys.executable, "-c", NOTED, *map(str, arguments)]
    subprocess.run(command, check=True, capture_output=True, timeout=300, env=dict(os.environ, NOTED=str(noted)))
    return set(noted.read_text().splitlines())


def _drawing() -> NDArray[np.float32]:
    """Return a drawing of a ramp and a line on white [64, 64, 3]."""
    image = np.ones((64, 64, 3), np.float32)
    image[8:28, 8:56] = np.linspace(0.2, 0.8, 48, dtype=np.float32)[None, :, None]
    image[40:44, 8:56] = 0.0
    return image


@pytest.mark.slow  # five commands
def test_a_run_after_it_compiles_nothing(tmp_path: Path) -> None:
    photo, noted = tmp_path / "photo.png", tmp_path / "noted"
    write_png(photo, np.random.default_rng(0).random((40, 56, 3), dtype=np.float32))
    compiled = loaded(noted, "info", "--compile")
    assert len(compiled) > 10
    drawing = tmp_path / "drawing.png"
    write_png(drawing, _drawing())
    assert loaded(noted, "run", drawing, tmp_path / "out.svg", "--mode", "flat", "--quiet") <= compiled
    settings = ["--curves", 20, "--device", "cpu", "--quiet"]
    many = ["--iterations", 60, "--recycle-gap", 10]
    papers = [["--preset", preset, "--iterations", 5] for preset in ("paper", "paper-released", "bezier-splatting")]
    for fit in (many, *papers, ["--renderer", "splat", *many], ["--gradients", 8, *many]):
        assert loaded(noted, "run", photo, tmp_path / "out.svg", *fit, *settings) <= compiled


def test_an_unknown_device_is_refused() -> None:
    with pytest.raises(InputError, match="device must be"):
        compile_kernels("tpu")
