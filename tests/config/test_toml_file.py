"""Settings in TOML files: writing and reading them, names, and mistakes that are reported in one line."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import pytest

from warpvec.config.toml_file import read_settings, write_settings
from warpvec.errors import InputError

KNOWN = {"curves", "lr_points", "flat", "palette", "preset"}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "settings.toml"


def _read(path: Path, text: str) -> dict[str, str]:
    path.write_text(text, encoding="utf-8")
    return read_settings(str(path), KNOWN, {"flat"})


def test_names_may_have_hyphens_and_values_are_as_on_the_command_line(path: Path) -> None:
    text = 'curves = 7\nlr-points = 1e-7\nflat = true\n# a comment\npalette = "#123,#456"'
    assert _read(path, text) == {"curves": "7", "lr_points": "1e-07", "flat": "True", "palette": "#123,#456"}
    assert _read(path, "lr_points = 0.5") == {"lr_points": "0.5"}
    assert _read(path, "") == {}


@pytest.mark.parametrize(
    "value", [0, -3, 10**18, 0.1, 1e-7, 1e22, 1.0, math.pi, True, False, "", "ä\n\t\"'\\", "#123", "\x7f", "\x00\u2028"]
)
def test_written_values_are_read_back(path: Path, value: Any) -> None:
    write_settings(str(path), {"flat" if isinstance(value, bool) else "curves": value})
    (text,) = read_settings(str(path), KNOWN, {"flat"}).values()
    assert text == str(value)
    assert os.listdir(path.parent) == [path.name]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("tempo = 3", "tempo in '.*settings.toml' must be the name of an option of this command; see --help-all"),
        ("curves = [7]", "curves in .* must be a number, a text, true or false, got \\[7\\]$"),
        ("[curves]\nn = 7", "curves in .* must be a number"),
        ("curves = 2020-01-01", "curves in .* must be a number"),
        ('flat = "yes"', "flat in .* must be true or false, got 'yes'; write one, without quotes"),
        ("curves = ", "config must be a TOML file, got .*settings.toml"),
        ("curves 7", "config must be a TOML file"),
        ("curves = " + "[" * 5000, "config must be a TOML file"),
        ("curves = 0x" + "f" * 5000, "curves in .* must be a number of fewer digits"),
        ("x" * 5000 + " = 1", "x{100}\\.\\.\\. in .* must be the name of an option"),
        ("curves = 7\ncurves = 8", "config must be a TOML file"),
    ],
)
def test_mistakes_are_reported_in_one_line(path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=f"^{words}") as caught:
        _read(path, text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [b"\xff\xfe", None])
def test_unreadable_files_are_reported_in_one_line(path: Path, data: bytes | None) -> None:
    if data is None:
        path.mkdir()
    else:
        path.write_bytes(data)
    with pytest.raises(InputError, match="^config must be a TOML file"):
        read_settings(str(path), KNOWN)
    with pytest.raises(InputError, match="^config must be a TOML file"):
        read_settings(str(path / "missing"), KNOWN)


def test_a_name_of_many_dots_is_refused_before_it_is_read(path: Path) -> None:
    with pytest.raises(InputError, match="^config must have at most"):
        _read(path, ".".join("a" * 10_000) + " = 1")


def test_a_file_that_cannot_be_written_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="^write_config must be in an existing folder"):
        write_settings(str(tmp_path / "missing" / "settings.toml"), {"curves": 1})
