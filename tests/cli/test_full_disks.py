"""A full disk for one output: the others are complete, and the fit is lost only with OUT itself."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from commands import assert_refused, invoke, write_photo
from runs import drawn
from torture_disks import FILES, is_whole, small_disk

from warpvec import files
from warpvec.batch.engines.local import LocalEngine
from warpvec.config.fit_config import FitConfig
from warpvec.image.read import read_image
from warpvec.modes import photo as photo_mode

FIT = ["--curves", "24", "--iterations", "12", "--every", "1", "-q"]


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A folder on a disk without space."""
    try:
        with small_disk(tmp_path) as folder:
            yield folder
    except OSError as error:
        pytest.skip(f"needs a disk of its own, which only root can mount: {error}")


def test_a_batch_to_a_full_disk_draws_nothing(
    photo: Path, disk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "in").mkdir()
    shutil.copy(photo, tmp_path / "in")
    monkeypatch.setattr(LocalEngine, "run", lambda *_: pytest.fail("it drew"))
    refused = invoke("batch", tmp_path / "in", disk)
    assert_refused(refused, "OUT_DIR must have room for drawings", "No space left on device")
    assert not any(disk.iterdir())


def _run(photo: Path, places: dict[str, Path]) -> Result:
    options = [word for name, place in places.items() if name != "OUT" for word in (name, place)]
    return invoke("run", photo, places["OUT"], *FIT, *options)


def _warning(option: str, reason: str = "No space left on device") -> str:
    return f"warpvec: warning: {option} could not be written ({reason}); going on\n"


@pytest.mark.parametrize(
    ("full", "file"),
    [*FILES.items(), ("--video", "fit.webp")]
    + ([("--video", "fit.mp4")] if find_spec("imageio_ffmpeg") is not None else []),
)
def test_the_other_files_are_whole(
    full: str, file: str, photo: Path, disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(photo.parent)
    assert invoke("run", photo, photo.with_name("undisturbed.svg"), *FIT).exit_code == 0
    places = {name: photo.with_name(other) for name, other in FILES.items()} | {full: disk / file}
    result = _run(photo, places)
    assert [name for name, place in places.items() if not is_whole(name, place)] == [full]
    if full == "OUT":
        assert result.exit_code == 1
        kept = photo.with_name("out-rescued.svg")
        reason = f"{str(disk / file)!r} could not be written (No space left on device)"
        assert result.stderr == f"warpvec: error: {reason}; the drawing is in {str(kept)!r}\n"
        assert kept.read_bytes() == photo.with_name("undisturbed.svg").read_bytes()
    else:
        reason = "ffmpeg could not write all of it; the disk may be full" if file.endswith(".mp4") else None
        assert (result.exit_code, result.stderr) == (0, _warning(full, *([reason] if reason else [])))
        assert places["OUT"].read_bytes() == photo.with_name("undisturbed.svg").read_bytes()
    assert not list(photo.parent.rglob(".warpvec-*"))


def test_other_failures_of_side_files_are_warnings_too(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, out, real = photo.with_name("gone"), photo.with_name("out.svg"), photo_mode.fit
    folder.mkdir()

    def fit(*arguments: Any, **named: Any) -> Any:
        shutil.rmtree(folder)
        return real(*arguments, **named)

    monkeypatch.setattr(photo_mode, "fit", fit)
    result = _run(photo, {name: folder / file for name, file in FILES.items()} | {"OUT": out})
    assert result.exit_code == 0
    assert out.read_text(encoding="utf-8").endswith("</svg>\n")
    lines = sorted(result.stderr.splitlines())
    assert len(lines) == 4
    for line, option in zip(lines, ["--checkpoint", "--report", "--save-frames", "--video"], strict=True):
        assert line.startswith(f"warpvec: warning: {option} could not be written (")


def test_a_checkpoint_is_tried_again_and_warned_of_once(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state, fsync, count = photo.with_name("state"), os.fsync, 0

    def fail(handle: int) -> None:
        nonlocal count
        count += 1
        if count <= 3:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(handle)

    monkeypatch.setattr(files.os, "fsync", fail)
    result = invoke("run", photo, photo.with_name("out.svg"), *FIT, "--checkpoint", state)
    assert (result.exit_code, result.stderr) == (0, _warning("--checkpoint"))
    resumed = photo.with_name("resumed.svg")
    assert invoke("run", photo, resumed, "-q", "--resume", state).exit_code == 0
    assert resumed.read_bytes() == photo.with_name("out.svg").read_bytes()


@pytest.fixture
def failing_fsync(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    def fail(_: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    return lambda: monkeypatch.setattr(files.os, "fsync", fail)


def test_python_is_told_of_a_checkpoint_that_cannot_be_written(photo: Path, failing_fsync: Callable[[], None]) -> None:
    errors: list[OSError] = []
    failing_fsync()
    config = FitConfig(mode="photo", curves=4, iterations=2)
    result = drawn(read_image(photo), config, checkpoint=photo.with_name("state"), on_error=errors.append)
    assert [error.errno for error in errors] == [errno.EIO]
    assert result.svg().endswith("</svg>\n")


def test_refine_goes_on_without_its_settings(photo: Path, disk: Path) -> None:
    first, second = photo.with_name("first.svg"), photo.with_name("second.svg")
    assert invoke("run", photo, first, *FIT).exit_code == 0
    options = ["--iterations", "2", "-q", "--write-config", disk / "settings.toml"]
    result = invoke("refine", photo, second, "--from", first, *options)
    assert (result.exit_code, result.stderr) == (0, _warning("--write-config"))
    assert second.read_text(encoding="utf-8").endswith("</svg>\n")
