"""Two names for one file on the command line are refused before anything is written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from commands import QUICK, assert_refused, invoke, write_photo
from stubs import circles, stub_fit

from warpvec.cli.paths import check_distinct_files
from warpvec.errors import InputError
from warpvec.modes import photo as photo_mode
from warpvec.svg.write import write_svg


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, which has a photo, a drawing and a link to it. Fits are quick."""
    write_photo(tmp_path)
    (tmp_path / "drawing.svg").write_text(write_svg(circles(32, 48, 8), 48, 32))
    (tmp_path / "link.svg").symlink_to("drawing.svg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(photo_mode, "fit", stub_fit)
    return tmp_path


def _contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["run", "photo.png", "o.svg", "--report", "./o.svg"], ["OUT", "--report"]),
        (["run", "photo.png", "o.svg", "--report", "photo.png"], ["IN", "--report"]),
        (["run", "photo.png", "--report", "photo.svg"], ["OUT", "--report"]),
        (["run", "photo.png", "o.svg", "--checkpoint", "photo.png"], ["IN", "--checkpoint"]),
        (["run", "photo.png", "o.svg", "--write-config", "photo.png"], ["IN", "--write-config"]),
        (["run", "photo.png", "o.svg", "--write-config", "o.svg"], ["OUT", "--write-config"]),
        (["run", "photo.png", "o.svg", "--checkpoint", "s", "--report", "s"], ["--report", "--checkpoint"]),
        (["run", "photo.png", "o.svg", "--video", "a.gif", "--report", "a.gif"], ["--video", "--report"]),
        (["run", "photo.png", "o.svg", "--cut-once", "o.svg"], ["OUT", "--cut-once"]),
        (["run", "photo.png", "o.svg", "--save-frames", "./o.svg"], ["OUT", "--save-frames"]),
        (["run", "photo.png", "link.svg", "--report", "drawing.svg"], ["OUT", "--report"]),
        (["lod", "drawing.svg", "--levels", "0", "-o", "link.svg"], ["SVG", "-o"]),
        (["refine", "photo.png", "o.svg", "--from", "drawing.svg", "--write-config", "link.svg"], ["--from"]),
        (["refine", "drawing.svg", "link.svg", "--from", "other.svg"], ["IN", "OUT"]),
        (["view", "drawing.svg", "--report", "link.svg"], ["SVG", "--report"]),
        (["view", "drawing.svg", "--image", "photo.png", "--report", "photo.png"], ["--image", "--report"]),
        (["lod", "drawing.svg", "--image", "photo.png", "--levels", "0", "-o", "photo.png"], ["--image", "-o"]),
    ],
)
def test_two_names_for_one_file_are_refused(folder: Path, arguments: list[str], names: list[str]) -> None:
    before = _contents(folder)
    assert_refused(invoke(*arguments), "must be another file than", *names)
    assert _contents(folder) == before


def test_a_file_is_no_folder_for_another(folder: Path) -> None:
    before = _contents(folder)
    refused = invoke("run", "photo.png", "o.svg", "--save-frames", "o.svg/frames")
    assert_refused(refused, "--save-frames must not be inside of OUT", "'o.svg/frames'")
    assert _contents(folder) == before


def test_a_drawing_and_a_file_of_settings_may_be_replaced(folder: Path) -> None:
    (folder / "a.toml").write_text("curves = 3")
    options = ["--from", "drawing.svg", "--config", "a.toml", "--write-config", "./a.toml", "--iterations", "1", "-q"]
    assert invoke("refine", "photo.png", "link.svg", *options).exit_code == 0
    assert (folder / "link.svg").is_symlink()
    assert (folder / "drawing.svg").read_text().count("<path") == 3
    assert "curves = 3" in (folder / "a.toml").read_text()


def test_streams_and_devices_may_be_given_twice(folder: Path) -> None:
    result = invoke("run", "-", "-", "--report", os.devnull, *QUICK, stdin=(folder / "photo.png").read_bytes())
    assert result.exit_code == 0, result.output
    assert invoke("run", "photo.png", os.devnull, "--report", os.devnull, *QUICK).exit_code == 0


def test_impossible_file_names_are_not_compared() -> None:
    check_distinct_files({"IN": "a\0b", "OUT": "a\0b", "--report": None})
    with pytest.raises(InputError, match="^OUT must be another file than IN, got 'a' for both; choose another name$"):
        check_distinct_files({"IN": "a", "OUT": "a"})
