"""Compiled kernels go to a temporary folder where Warp's own cannot be written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

START = """
import os
import sys
from warpvec.rendering import kernel_cache
from warpvec.rendering.launch import start_warp

def fail(folder):
    raise OSError(28, "No space left on device")

if "full" in sys.argv:
    kernel_cache._check_room = fail
start_warp()
start_warp()
import warp
print(warp.config.kernel_cache_dir)
print(*sorted(os.listdir(warp.config.kernel_cache_dir)))
print(os.environ["WARP_CACHE_PATH"])
"""


def start(cache: Path, temporary: Path, *arguments: str) -> tuple[list[str], str]:
    """Start Warp in a process of its own; return what that prints on stdout, in lines, and on stderr."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "WARP_CACHE_PATH": str(cache)}
    command = [sys.executable, "-c", START, *arguments]
    done = subprocess.run(
        command, env={**environment, "TMPDIR": str(temporary)}, capture_output=True, check=True, text=True
    )
    return done.stdout.split("\n"), done.stderr


def test_a_folder_that_cannot_be_made_is_replaced_and_named_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (used, kernels, base, _), message = start(tmp_path / "file", tmp_path)
    assert Path(used).parent == Path(base) and Path(base).parent == tmp_path and not kernels
    assert message.count("\n") == 1
    assert f"'{tmp_path / 'file'}" in message and "Not a directory" in message and "set WARP_CACHE_PATH" in message
    assert [path.name for path in tmp_path.iterdir()] == ["file"]  # the temporary one is gone


def test_the_kernels_of_a_folder_that_cannot_be_written_are_used_without_a_word(tmp_path: Path) -> None:
    (own, *_), message = start(tmp_path, tmp_path)
    assert Path(own).parent == tmp_path and not message
    (Path(own) / "wp_kernel").mkdir()
    (used, kernels, *_), message = start(tmp_path, tmp_path, "full")
    assert Path(used) != Path(own) and kernels == "wp_kernel" and not message
    assert (Path(own) / "wp_kernel").is_dir() and not list(tmp_path.glob("warpvec-*"))
