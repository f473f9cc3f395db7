"""Temporary files: those of dead processes are removed, and nothing else is."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from warpvec import temporary_files
from warpvec.files import write_atomic
from warpvec.temporary_files import remove_live_files, remove_stale_files, temporary_file

NEEDS_LOCKS = pytest.mark.skipif(temporary_files.fcntl is None, reason="needs locks of files")

WRITER = """
import sys
from pathlib import Path
from warpvec.temporary_files import temporary_file
with temporary_file(Path(sys.argv[1]) / "out.svg", sys.argv[2]) as path:
    print(path, flush=True)
    sys.stdin.read()
"""

OTHER_KERNEL = ".warpvec-00000000-0123456789abcdef.tmp"


@pytest.fixture(autouse=True)
def _no_folder_is_swept_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(temporary_files, "_swept", {})


def start_writer(folder: Path, suffix: str = "") -> tuple[subprocess.Popen[str], Path]:
    """Start a process that holds a temporary file in ``folder``; return it and the file."""
    command = [sys.executable, "-c", WRITER, str(folder), suffix]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    return process, Path(process.stdout.readline().strip())


def end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate()


def make_old(path: Path) -> None:
    os.utime(path, (0.0, 0.0))


@NEEDS_LOCKS
@pytest.mark.parametrize("suffix", ["", ".mp4"])
def test_the_next_write_removes_the_file_of_a_killed_process(tmp_path: Path, suffix: str) -> None:
    process, left = start_writer(tmp_path, suffix)
    end(process)
    assert left.exists()
    write_atomic(tmp_path / "out.svg", b"x")
    assert os.listdir(tmp_path) == ["out.svg"]


def test_the_file_of_a_living_process_stays(tmp_path: Path) -> None:
    process, live = start_writer(tmp_path)
    try:
        if temporary_files.fcntl is not None:
            make_old(live)
        write_atomic(tmp_path / "out.svg", b"x")
        assert live.exists()
    finally:
        end(process)


def test_the_file_of_another_thread_stays(tmp_path: Path) -> None:
    with temporary_file(tmp_path / "out.svg") as live:
        remove_stale_files(tmp_path)
        assert live.exists()


def test_files_of_other_machines_stay_for_a_day(tmp_path: Path) -> None:
    left = tmp_path / OTHER_KERNEL
    left.touch()
    remove_stale_files(tmp_path)
    assert left.exists()
    make_old(left)
    remove_stale_files(tmp_path)
    assert not left.exists()


def test_files_stay_for_a_day_where_there_are_no_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(temporary_files, "lock_file", lambda handle: None)
    with temporary_file(tmp_path / "out.svg") as left:
        remove_stale_files(tmp_path)
        assert left.exists()
        make_old(left)
        remove_stale_files(tmp_path)
        assert not left.exists()


def test_only_regular_files_with_exactly_our_names_are_removed(tmp_path: Path) -> None:
    (tmp_path / "kept").write_bytes(b"kept")
    (tmp_path / OTHER_KERNEL).symlink_to(tmp_path / "kept")
    (tmp_path / OTHER_KERNEL.replace("0", "1")).mkdir()
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / OTHER_KERNEL.replace("0", "2"))
    for name in (".warpvec-photo.tmp", OTHER_KERNEL + "~", OTHER_KERNEL.upper(), "a" + OTHER_KERNEL, ".warpvec-.tmp"):
        (tmp_path / name).touch()
        make_old(tmp_path / name)
    before = sorted(os.listdir(tmp_path))
    remove_stale_files(tmp_path)
    assert sorted(os.listdir(tmp_path)) == before
    assert (tmp_path / "kept").read_bytes() == b"kept"


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs owners of files")
def test_files_of_other_users_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / OTHER_KERNEL).touch()
    make_old(tmp_path / OTHER_KERNEL)
    user = os.geteuid()
    monkeypatch.setattr(temporary_files.os, "geteuid", lambda: user + 1)
    remove_stale_files(tmp_path)
    assert (tmp_path / OTHER_KERNEL).exists()


def test_a_folder_that_cannot_be_read_does_not_fail_the_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(temporary_files.os, "scandir", refuse)
    write_atomic(tmp_path / "out.svg", b"x")
    assert os.listdir(tmp_path) == ["out.svg"]


@NEEDS_LOCKS
def test_a_file_that_is_removed_before_its_lock_is_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lock = temporary_files.lock_file

    def sweep_first(handle: int) -> bool | None:
        monkeypatch.setattr(temporary_files, "lock_file", lock)
        remove_stale_files(tmp_path)
        return lock(handle)

    monkeypatch.setattr(temporary_files, "lock_file", sweep_first)
    with temporary_file(tmp_path / "out.svg") as path:
        assert os.listdir(tmp_path) == [path.name]
    assert os.listdir(tmp_path) == []


def test_a_process_that_ends_removes_its_files_and_creates_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(temporary_files, "_creating", threading.Lock())  # never released
    with temporary_file(tmp_path / "out.svg"):
        remove_live_files()
        assert os.listdir(tmp_path) == []
        thread = threading.Thread(target=write_atomic, args=(tmp_path / "late.svg", b"x"), daemon=True)
        thread.start()
        thread.join(0.2)
        assert os.listdir(tmp_path) == []
    temporary_files._creating.release()
    thread.join()


def test_a_folder_is_swept_again_after_some_minutes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    swept: list[Path] = []
    monkeypatch.setattr(temporary_files, "remove_stale_files", swept.append)
    for later in (0.0, 1.0, 10_000.0):
        now = 50_000.0 + later
        monkeypatch.setattr(temporary_files.time, "monotonic", lambda now=now: now)
        with temporary_file(tmp_path / "a.svg"):
            pass
    assert swept == [tmp_path, tmp_path]
    with temporary_file(tmp_path / "b.svg"):
        pass
    assert list(temporary_files._swept) == [tmp_path]


def test_a_file_is_written_through_the_handle_that_locks_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A Windows share refuses every other handle."""
    opened: list[str] = []
    monkeypatch.setattr(temporary_files.os, "open", _noting(os.open, opened))
    monkeypatch.setattr("builtins.open", _noting(open, opened))
    write_atomic(tmp_path / "out.svg", b"content")
    assert (tmp_path / "out.svg").read_bytes() == b"content"
    assert len([path for path in opened if ".warpvec-" in path]) == 1


def _noting(opener: Any, opened: list[str]) -> Any:
    def call(path: Any, *arguments: Any, **options: Any) -> Any:
        opened.append(str(path))
        return opener(path, *arguments, **options)

    return call
