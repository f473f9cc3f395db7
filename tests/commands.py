"""The command ``warpvec`` in this process, and a photo for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from click.testing import CliRunner, Result
from PIL import Image

from warpvec.cli import main

QUICK = ["--curves", "8", "--iterations", "3"]


def invoke(*arguments: object, stdin: bytes = b"") -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments], input=stdin)


def assert_refused(result: Result, *words: str) -> None:
    """One line that says what is wrong, exit code 2, nothing on stdout."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("warpvec: error: ")
    for word in words:
        assert word in line


def write_photo(folder: Path) -> Path:
    """A noisy 48 x 32 photo in ``folder``."""
    path = folder / "photo.png"
    Image.fromarray(np.random.default_rng(1).integers(0, 256, (32, 48, 3), dtype=np.uint8)).save(path)
    return path
