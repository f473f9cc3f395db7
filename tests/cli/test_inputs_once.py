"""Every command reads each input once: a pipe gives its bytes one time, and a second reading would wait for ever."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from commands import QUICK, invoke, write_photo

pytestmark = [
    pytest.mark.usefixtures("quick_fit"),
    pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes"),
]

Pipe = Callable[[bytes], Path]

WAIT_SECONDS = 60.0
"""A command that opens a pipe again waits for a writer, and takes longer."""


@pytest.fixture
def pipe(tmp_path: Path) -> Pipe:
    """Make a pipe that gives some bytes once."""
    folder = tmp_path / "pipes"
    folder.mkdir()

    def make(data: bytes) -> Path:
        path = folder / f"pipe{len(os.listdir(folder))}.svg"
        os.mkfifo(path)
        threading.Thread(target=path.write_bytes, args=(data,), daemon=True).start()
        return path

    return make


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


@pytest.fixture
def drawing(photo: Path) -> Path:
    out = photo.with_name("drawing.svg")
    assert invoke("run", photo, out, *QUICK).exit_code == 0
    return out


def _invoke(*arguments: object) -> None:
    """Run a command that must end well and soon."""
    results = []
    thread = threading.Thread(target=lambda: results.append(invoke(*arguments)), daemon=True)
    thread.start()
    thread.join(WAIT_SECONDS)
    assert results, f"{arguments[0]} waits for an input that it has read before"
    assert results[0].exit_code == 0, results[0].output


def test_run(photo: Path, pipe: Pipe) -> None:
    out, page, settings = (photo.with_name(name) for name in ("out.svg", "page.html", "new.toml"))
    outputs = ["--report", page, "--write-config", settings, "--video", photo.with_name("fit.gif"), "--every", 1]
    palette = pipe(b"#102030, #405060")
    config = pipe(b"curves = 8\niterations = 3\n")
    _invoke("run", pipe(photo.read_bytes()), out, "--config", config, "--palette", palette, *outputs)
    assert page.read_text(encoding="utf-8").endswith("</html>\n")
    assert "data:image/png;base64," in page.read_text(encoding="utf-8")


def test_refine(photo: Path, drawing: Path, pipe: Pipe) -> None:
    config = pipe(b"iterations = 3\n")
    inputs = [pipe(photo.read_bytes()), photo.with_name("out.svg"), "--from", pipe(drawing.read_bytes())]
    _invoke("refine", *inputs, "--config", config, "--write-config", photo.with_name("new.toml"))


def test_eval(photo: Path, drawing: Path, pipe: Pipe) -> None:
    _invoke("eval", pipe(photo.read_bytes()), pipe(drawing.read_bytes()))


def test_view(photo: Path, drawing: Path, pipe: Pipe) -> None:
    options = ["--image", pipe(photo.read_bytes()), "--history", pipe(b"[]"), "--report", photo.with_name("p.html")]
    _invoke("view", pipe(drawing.read_bytes()), *options)


def test_lod(photo: Path, drawing: Path, pipe: Pipe) -> None:
    kept = photo.with_name("kept.svg")
    _invoke(
        "lod", pipe(drawing.read_bytes()), "--levels", "0", "-o", kept, "--list", "--image", pipe(photo.read_bytes())
    )
    assert kept.exists()
    split = pipe(drawing.read_bytes())
    _invoke("lod", split, "--split")
    assert split.with_name(f"{split.stem}-level-0.svg").exists()
