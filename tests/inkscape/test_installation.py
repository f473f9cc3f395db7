"""Installing and removing the extension for Inkscape."""

from __future__ import annotations

import ast
import json
import subprocess
from pathlib import Path

import pytest
from commands import assert_refused, invoke, write_photo
from inkscape_runs import EXTENSION
from PIL import Image

from warpvec.inkscape import installation


def test_the_installed_command_is_this_warpvec(tmp_path: Path) -> None:
    result = invoke("inkscape", "install", "--folder", tmp_path)
    assert result.exit_code == 0
    assert "restart Inkscape" in result.stdout
    command = json.loads((tmp_path / "warpvec" / "command.json").read_text())["command"]
    done = subprocess.run([*command, "--version"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("warpvec")


def test_uninstalling_leaves_the_files_of_others(tmp_path: Path) -> None:
    invoke("inkscape", "install", "--folder", tmp_path)
    invoke("inkscape", "install", "--folder", tmp_path)
    (tmp_path / "warpvec" / "mine.py").write_text("")
    assert invoke("inkscape", "uninstall", "--folder", tmp_path).exit_code == 0
    assert [path.name for path in tmp_path.rglob("*")] == ["warpvec", "mine.py"]
    assert_refused(invoke("inkscape", "uninstall", "--folder", tmp_path), "--folder must contain the extension")
    (tmp_path / "warpvec" / "mine.py").unlink()
    invoke("inkscape", "install", "--folder", tmp_path)
    invoke("inkscape", "uninstall", "--folder", tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert_refused(invoke("inkscape", "install", "--folder", tmp_path / "file"), "--folder must be a folder")


def test_inkscape_says_where_the_extension_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "bin" / "inkscape"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\necho {tmp_path / 'data'}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent))
    assert invoke("inkscape", "install").exit_code == 0
    assert (tmp_path / "data" / "extensions" / "warpvec" / "warpvec_trace.inx").is_file()
    program.write_text("#!/bin/sh\nexit 1\n")
    monkeypatch.setenv("INKSCAPE_PROFILE_DIR", str(tmp_path / "profile"))
    assert_refused(invoke("inkscape", "install"), "--folder must be given", "Preferences")
    (tmp_path / "profile").mkdir()
    assert invoke("inkscape", "install").exit_code == 0
    assert (tmp_path / "profile" / "extensions" / "warpvec" / "command.json").is_file()


@pytest.mark.parametrize(
    ("platform", "environment", "expected"),
    [
        ("linux", {}, "/home/u/.config/inkscape"),
        ("linux", {"XDG_CONFIG_HOME": "/c"}, "/c/inkscape"),
        ("darwin", {}, "/home/u/Library/Application Support/org.inkscape.Inkscape/config/inkscape"),
        ("win32", {"APPDATA": "/roaming"}, "/roaming/inkscape"),
        ("win32", {}, "/home/u/AppData/Roaming/inkscape"),
    ],
)
def test_the_folders_of_systems(platform: str, environment: dict[str, str], expected: str) -> None:
    assert installation.default_data_folder(platform, environment, Path("/home/u")) == Path(expected)


def test_the_scripts_are_of_the_oldest_python_that_inkscape_has() -> None:
    for path in EXTENSION.glob("*.py"):
        ast.parse(path.read_text(), path.name, feature_version=(3, 9))


def test_the_size_of_an_image_is_that_of_the_upright_one(tmp_path: Path) -> None:
    photo = Image.open(write_photo(tmp_path, height=20, width=30))
    exif = Image.Exif()
    exif[0x0112] = 6  # a quarter turn
    photo.save(tmp_path / "turned.jpg", exif=exif)
    assert json.loads(invoke("inkscape", "size", tmp_path / "turned.jpg").stdout) == [20, 30]
    assert_refused(invoke("inkscape", "size", tmp_path / "none.png"), "IMAGE must be")
