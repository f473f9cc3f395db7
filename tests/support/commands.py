"""Run the command ``warpvec`` in this process, and write a photo for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from click.testing import CliRunner, Result
from PIL import Image

from warpvec.cli.main import main

QUICK = ["--curves", "8", "--iterations", "3"]


def invoke(*arguments: object, stdin: bytes = b"") -> Result:
    """Run ``warpvec`` with these arguments in this process."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments], input=stdin)


def assert_refused(result: Result, *words: str) -> None:
    """Check that a command printed one line on stderr with these words, nothing on stdout, and exited with 2."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("warpvec: error: ")
    for word in words:
        assert word in line


def write_photo(folder: Path, name: str = "photo.png", height: int = 32, width: int = 48, seed: int = 1) -> Path:
    """Write a noisy photo to ``folder`` and return its path."""
    path = folder / name
    Image.fromarray(np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)).save(path)
    return path
