"""Compiled kernels go to a temporary folder where Warp's own cannot be written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import children
import pytest
from children import wait_for

from warpvec.rendering import locked_folders

pytestmark = pytest.mark.slow

START = """
import os
import sys
import warp
from warpvec.rendering import kernel_cache

def fail(folder):
    raise OSError(28, "No space left on device")

def no_folder(*_):
    raise FileNotFoundError("no temporary folder")

if "nowhere" in sys.argv:
    kernel_cache.make_locked_folder = no_folder
if "full" in sys.argv:
    kernel_cache._check_room = fail
if "with torch" in sys.argv:
    from warpvec.rendering.launch import start_warp

    start_warp()
    start_warp()
else:  # as it does, in a fifth of the time
    warp.config.log_level = warp.LOG_ERROR
    stderr = os.dup(2)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    try:
        message = kernel_cache.init_warp()
    finally:
        os.dup2(stderr, 2)
    if message is not None:
        print(message, file=sys.stderr)
print(warp.config.kernel_cache_dir)
print(*sorted(os.listdir(warp.config.kernel_cache_dir)))
print(os.environ["WARP_CACHE_PATH"])
if "compile" in sys.argv:
    os.mkdir(os.path.join(warp.config.kernel_cache_dir, "wp_other"))
"""


def start(cache: Path, temporary: Path, *arguments: str) -> tuple[list[str], str]:
    """Start Warp in a process of its own; return what that prints on stdout, in lines, and on stderr."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "WARP_CACHE_PATH": str(cache)}
    command = [sys.executable, "-c", START, *arguments]
    done = subprocess.run(command, env={**environment, "TMPDIR": str(temporary)}, capture_output=True, text=True)
    return done.stdout.split("\n"), done.stderr


def test_a_folder_that_cannot_be_made_is_replaced_and_named_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (used, kernels, base, _), message = start(tmp_path / "file", tmp_path, "with torch")
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


def test_kernels_that_are_compiled_all_the_same_are_told_at_the_end(tmp_path: Path) -> None:
    (own, *_), _ = start(tmp_path, tmp_path)
    (Path(own) / "wp_kernel").mkdir()
    _, message = start(tmp_path, tmp_path, "full", "compile")
    assert message.count("\n") == 1 and "so this run compiles its own" in message


def test_no_place_for_kernels_at_all_is_wrong_input(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    _, message = start(tmp_path / "file", tmp_path, "nowhere")
    assert "InputError: WARP_CACHE_PATH must name a folder" in message


def test_kernels_are_used_where_they_are_if_there_is_no_place_for_others(tmp_path: Path) -> None:
    """As in a container whose disk is read-only."""
    (own, *_), _ = start(tmp_path, tmp_path)
    (Path(own) / "wp_kernel").mkdir()
    (used, kernels, *_), message = start(tmp_path, tmp_path, "full", "nowhere")
    assert (used, kernels, message) == (own, "wp_kernel", "")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no locks of folders")
def test_the_folders_of_killed_processes_are_removed(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for name in ("dead", "alive", "new"):
        (tmp_path / f"warpvec-kernels-{name}" / "1.0").mkdir(parents=True)
        if name != "new":
            os.utime(tmp_path / f"warpvec-kernels-{name}", (0, 0))
    handle = locked_folders._lock(tmp_path / "warpvec-kernels-alive")
    assert handle is not None
    start(tmp_path / "file", tmp_path)
    os.close(handle)
    assert sorted(path.name for path in tmp_path.glob("warpvec-*")) == ["warpvec-kernels-alive", "warpvec-kernels-new"]


def test_the_headers_that_warp_compiles_are_gone_when_a_signal_has_ended_the_process(tmp_path: Path) -> None:
    """The signal comes while native code compiles, as it does most often: a compilation takes half a minute."""
    names: list[str] = []
    for number in (signal.SIGTERM, signal.SIGKILL, signal.SIGTERM):
        process = begin_compilation(tmp_path / "cache", tmp_path)
        names.append(wait_for(lambda: {path.parent.name for path in tmp_path.glob("w*/*.tmp")} - {*names}).pop())
        process.send_signal(number)
        process.wait()
        if number == signal.SIGKILL:  # the next process that compiles removes what this one could not
            os.utime(tmp_path / names[-1], (0, 0))
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]


def begin_compilation(cache: Path, temporary: Path) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "WARP_CACHE_PATH": str(cache), "TMPDIR": str(temporary)}
    return children.start([sys.executable, "-m", "warpvec", "info", "--compile"], env=environment)


@pytest.mark.parametrize("given", ["", "relative"])
def test_a_cache_that_is_no_absolute_path_leaves_nothing_in_the_current_folder(given: str, tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    (tmp_path / "current").mkdir()
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "XDG_CACHE_HOME": given, "HOME": str(home)}
    environment.pop("WARP_CACHE_PATH", None)
    code = "import os, warp; from warpvec.rendering.kernel_cache import init_warp; init_warp(); print(os.environ)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path / "current",
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert not any((tmp_path / "current").iterdir()) and (home / ".cache" / "warp").is_dir()
    assert f"'XDG_CACHE_HOME': '{given}'" in done.stdout
