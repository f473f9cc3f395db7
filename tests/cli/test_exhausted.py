"""A full disk, full memory or a missing permission: one line, exit code 1 or 2, and no damaged files."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
import warp as wp
from click.testing import Result
from commands import QUICK, assert_refused, invoke, write_photo

from warpvec import files
from warpvec.modes import photo as photo_mode
from warpvec.watch.watch import Watch


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


def _run(photo: Path, *options: object) -> Result:
    return invoke("run", photo, photo.with_name("out.svg"), *QUICK, "-q", *options)


def _line(result: Result) -> str:
    assert result.exit_code == 1, result.output
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("warpvec: error: ")
    return line.removeprefix("warpvec: error: ")


@pytest.fixture
def full_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files.os, "fsync", _failing(errno.ENOSPC))


def _failing(number: int) -> Callable[[int], None]:
    def fail(_: int) -> None:
        raise OSError(number, os.strerror(number))

    return fail


REMEDY = "free some space and run again"

DRAWING = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><g><path d="M0 0h5v5z"/></g></svg>'


@pytest.mark.usefixtures("full_disk")
@pytest.mark.parametrize("old", [None, b"older"])
def test_a_full_disk_is_reported_in_one_line_and_damages_no_file(photo: Path, old: bytes | None) -> None:
    out = photo.with_name("out.svg")
    if old is not None:
        out.write_bytes(old)
    line = _line(_run(photo))
    assert line == f"the disk is full (No space left on device), {str(out)!r} could not be written; {REMEDY}"
    assert sorted(os.listdir(photo.parent)) == (["photo.png"] if old is None else ["out.svg", "photo.png"])
    assert old is None or out.read_bytes() == old


@pytest.mark.slow
@pytest.mark.usefixtures("full_disk")
@pytest.mark.parametrize(
    ("arguments", "file"),
    [
        (("view", "drawing.svg", "--report", "page.html"), "page.html"),
        (("sample", "coffee.png", "cup.png"), "cup.png"),
        (("lod", "drawing.svg", "--levels", "0", "-o", "low.svg"), "low.svg"),
        (("batch", "photos", "drawings"), "drawings/batch.jsonl"),
    ],
)
def test_every_command_names_the_file_for_which_the_disk_is_full(
    arguments: tuple[str, ...], file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if arguments[0] == "sample":
        pytest.importorskip("skimage")
    monkeypatch.chdir(tmp_path)
    Path("drawing.svg").write_text(DRAWING, encoding="utf-8")
    Path("photos").mkdir()
    Path("photos", "photo.png").write_bytes(b"no photo")
    result = invoke(*arguments)
    assert result.exit_code == 1
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("warpvec: error: ")]
    path = str(tmp_path / file) if arguments[0] == "batch" else file
    assert line.endswith(f"the disk is full (No space left on device), {path!r} could not be written; {REMEDY}")


def test_a_limit_on_the_size_of_files_is_reported_in_one_line(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files.os, "fsync", _failing(errno.EFBIG))
    out = str(photo.with_name("out.svg"))
    assert _line(_run(photo)) == (
        f"a file would be larger than is allowed (File too large), {out!r} could not be written; "
        "raise the limit (ulimit -f)"
    )


def test_a_disk_that_became_read_only_is_named_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the system makes it after an error of the disk."""
    monkeypatch.setattr(files.os, "fsync", _failing(errno.EROFS))
    monkeypatch.chdir(tmp_path)
    Path("drawing.svg").write_text(DRAWING, encoding="utf-8")
    line = _line(invoke("view", "drawing.svg", "--report", "page.html"))
    assert line == "'page.html' could not be written (Read-only file system); make its folder one that can be written"


def _no_folder(*_: object, **__: object) -> str:
    raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found")


def test_a_page_needs_a_name_where_there_is_no_folder_for_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "mkdtemp", _no_folder)
    monkeypatch.chdir(tmp_path)
    Path("drawing.svg").write_text(DRAWING, encoding="utf-8")
    assert_refused(invoke("view", "drawing.svg"), "--report must be given where no folder for temporary files")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full, which only Linux has")
def test_a_full_device_is_reported_in_one_line(photo: Path) -> None:
    line = _line(invoke("run", photo, "/dev/full", *QUICK, "-q"))
    assert line == f"the disk is full (No space left on device), '/dev/full' could not be written; {REMEDY}"


def _immense_in_torch() -> Any:
    return torch.empty(2**62, dtype=torch.uint8)


def _immense_in_warp() -> Any:
    return wp.empty((2**30, 2**18), dtype=wp.uint8, device="cpu")


def _on_a_gpu() -> Any:
    raise torch.cuda.OutOfMemoryError("CUDA out of memory. Tried to allocate 2.00 GiB.\nGPU 0 has 80 GiB in all.")


def _in_python() -> Any:
    raise MemoryError


@pytest.mark.parametrize("allocate", [_immense_in_torch, _immense_in_warp, _on_a_gpu, _in_python])
def test_full_memory_is_reported_in_one_line(
    photo: Path, allocate: Callable[[], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(photo_mode, "fit", lambda *_, **__: allocate())
    line = _line(_run(photo, "--video", photo.with_name("fit.gif"), "--every", "1"))
    assert line.startswith("memory has run out (")
    assert line.endswith("); give a smaller --fit-size or fewer --curves")
    assert os.listdir(photo.parent) == ["photo.png"]


def test_full_memory_leaves_the_checkpoint(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, state = photo_mode.fit, photo.with_name("state")

    def exhaust(progress: Any) -> None:
        if progress.iteration == 3:
            raise MemoryError

    def fit(target: Any, config: Any, part: Any, **others: Any) -> Any:
        return real(target, config, Watch(exhaust).part(), **others)

    settings = ["--curves", "8", "--iterations", "6", "-q"]
    assert invoke("run", photo, photo.with_name("whole.svg"), *settings).exit_code == 0
    with monkeypatch.context() as exhausted:
        exhausted.setattr(photo_mode, "fit", fit)
        run = invoke("run", photo, photo.with_name("out.svg"), *settings, "--checkpoint", state, "--every", "1")
        assert _line(run).startswith("memory has run out")
    assert not photo.with_name("out.svg").exists()
    assert invoke("run", photo, photo.with_name("out.svg"), "-q", "--resume", state).exit_code == 0
    assert photo.with_name("out.svg").read_bytes() == photo.with_name("whole.svg").read_bytes()


@pytest.mark.parametrize("option", ["--checkpoint", "--report", "--video", "--write-config"])
def test_write_protected_folders_are_refused_before_the_fit(
    photo: Path, option: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    locked = photo.with_name("locked")
    locked.mkdir()
    # The mode of the folder would not stop root.
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != locked)
    assert_refused(_run(photo, option, locked / "a.gif"), f"{option} must be in a folder you may write to", "locked")
    assert os.listdir(locked) == []
    assert not photo.with_name("out.svg").exists()
