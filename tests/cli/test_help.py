"""Help, and hints after mistyped commands."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import pytest
from commands import assert_refused, invoke

from warpvec import __version__
from warpvec.cli.options import OPTIONS, REFUSED
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import PRESETS
from warpvec.config.setting import settings_of
from warpvec.drawing.file_options import FileOptions
from warpvec.goals.registry import QUANTITIES
from warpvec.modes.refine import ITERATIONS


@pytest.mark.parametrize("command", ["run", "refine", "batch"])
def test_help_fits_on_a_screen_with_the_presets_first(command: str) -> None:
    text = invoke(command, "--help").stdout
    assert len(text.splitlines()) <= 48
    assert max(map(len, text.splitlines())) <= 80
    last = text.index("Settings:")
    for name, preset in PRESETS.items():
        assert f"  {name} " in text[:last]
        assert preset.sentence in " ".join(text[:last].split())
    modes = () if command == "refine" else ("mode", "detail", "cutout")
    for name in (*QUANTITIES, *modes, "size", "curves", "opaque", "palette", "config", "help_all"):
        assert f"  --{name.replace('_', '-')} " in text
    assert "--lr-points" not in text
    assert "--no-lod" not in text


@pytest.mark.parametrize("command", ["run", "refine", "batch"])
def test_help_all_shows_every_option(command: str) -> None:
    result = invoke(command, "--help-all")
    assert result.exit_code == 0
    names = {each.name for each in dataclasses.fields(FitConfig)}
    assert {*OPTIONS} == {*names, *QUANTITIES, "gzip", "opaque", *settings_of(FileOptions)}
    refused = REFUSED.get(command, ())
    for name in {*OPTIONS, "write_config", "background"} - {*refused}:
        flag = OPTIONS[name].flag if name in OPTIONS else None
        assert f"--{(flag or name).replace('_', '-')} " in result.stdout
    assert "Policy replacement:" in result.stdout
    if command == "run":
        assert all(
            f"--{name} " in result.stdout for name in ("checkpoint", "resume", "every", "save-frames", "verbose")
        )


def test_the_help_of_batch_shows_the_option_that_its_error_names() -> None:
    assert "  --keep-suffix " in invoke("batch", "--help").stdout


def test_the_help_of_refine_shows_the_defaults_of_refine() -> None:
    text = " ".join(invoke("refine", "--help").stdout.split())
    assert "auto chooses. [those of the drawing]" in text
    assert f"more give a better picture. [{ITERATIONS}]" in text
    assert "[512]" not in text
    assert "[512]" in invoke("run", "--help").stdout


def test_help_of_warpvec_and_of_a_command() -> None:
    assert invoke("help").stdout == invoke("--help").stdout
    assert "Commands:" in invoke("help").stdout
    assert invoke("help", "eval").stdout == invoke("eval", "--help").stdout
    assert invoke("help", "run").stdout == invoke("run", "--help").stdout
    assert_refused(invoke("help", "rnu"), "did you mean `warpvec run`?")


@pytest.mark.parametrize("flag", ["-V", "--version"])
def test_version(flag: str) -> None:
    assert invoke(flag).stdout.strip().endswith(__version__)


def test_mistyped_commands_and_options_are_suggested(tmp_path: Path) -> None:
    assert_refused(invoke("photo.png"), "no command is called 'photo.png'; did you mean `warpvec run photo.png`?")
    assert_refused(invoke("my photo.JPG", "-", "-q"), "did you mean `warpvec run 'my photo.JPG' - -q`?")
    assert_refused(invoke("a.svg"), "did you mean `warpvec view a.svg`?")
    (tmp_path / "photo").touch()
    assert_refused(invoke(tmp_path / "photo"), f"did you mean `warpvec run {tmp_path / 'photo'}`?")
    assert_refused(invoke("evla", "photo.png"), "did you mean `warpvec eval`?")
    assert_refused(invoke("zigzag"), "no command is called 'zigzag'; see warpvec --help for the commands")
    assert_refused(invoke("vectorize", "a.png"), "no command is called 'vectorize'; did you mean `warpvec run`?")
    assert_refused(invoke("view", "-o", "a.html"), "No such option '-o'. See warpvec view --help.")
    assert_refused(invoke("run", "--colour"), "No such option '--colour'", "--colors")
    assert_refused(invoke("--fast"), "--fast")


def test_without_a_command_it_shows_the_help() -> None:
    result = invoke()
    assert result.exit_code == 2
    assert "Commands:" in result.stderr


def test_the_command_line_imports_nothing_slow() -> None:
    slow = {"torch", "warp", "numpy", "rich", "PIL", "warpvec.modes", "warpvec.paper.splat"}
    code = f"""
import sys
from warpvec.cli.main import main
for words in (["--help"], ["run", "--help-all"], ["help", "lod"]):
    try:
        main(words)
    except SystemExit as end:
        assert not end.code
print(sorted({slow} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
