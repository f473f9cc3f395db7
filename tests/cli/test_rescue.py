"""A drawing whose place is gone by the end of the run is written elsewhere; a working folder that is gone is named."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import pytest
from commands import invoke, write_photo

from warpvec.cli.arguments import write_drawing
from warpvec.modes import photo as photo_mode
from warpvec.svg.measure import file_facts
from warpvec.writers.registry import WRITERS

SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><rect width="3" height="3" opacity="x"/></svg>'


def test_the_drawing_is_kept_if_its_folder_is_removed_during_the_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    photo, folder, fit = write_photo(tmp_path), tmp_path / "a" / "b", photo_mode.fit
    folder.mkdir(parents=True)

    def removing(*arguments: Any, **options: Any) -> Any:
        shutil.rmtree(folder.parent)
        return fit(*arguments, **options)

    monkeypatch.setattr(photo_mode, "fit", removing)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out-rescued.svg").write_text("mine")
    result = invoke("run", photo, folder / "out.svg", "--curves", "8", "--iterations", "3", "-q")
    assert result.exit_code == 1
    kept = tmp_path / "out-rescued-2.svg"
    reason = f"{str(folder / 'out.svg')!r} could not be written (No such file or directory)"
    assert result.stderr == f"warpvec: error: {reason}; the drawing is in {str(kept)!r}\n"
    assert file_facts(kept.read_bytes())["paths"] > 0
    assert (tmp_path / "out-rescued.svg").read_text() == "mine"


def test_the_svg_is_kept_if_its_kind_of_file_cannot_be_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> bytes:
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(WRITERS, ".png", WRITERS[".png"].__class__(".png", "image/png", fail))
    with pytest.raises(click.ClickException, match=r"No space left.*; the drawing is in .*out-rescued.svg"):
        write_drawing(SVG, str(tmp_path / "out.png"))
    assert (tmp_path / "out-rescued.svg").read_text() == SVG


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")
def test_what_was_to_go_to_a_device_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OSError, match="No space left"):
        write_drawing(SVG, "/dev/full")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not remove a working folder")
def test_a_working_folder_that_is_gone_is_named(tmp_path: Path) -> None:
    photo, folder = write_photo(tmp_path), tmp_path / "gone"
    folder.mkdir()
    command = 'rmdir "$PWD" && exec "$0" -P -m warpvec run "$1" "$2" -q'
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        ["sh", "-c", command, sys.executable, str(photo), str(tmp_path / "out.svg")],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    message = "warpvec: error: the working folder does not exist any more; change to another one\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", message)
