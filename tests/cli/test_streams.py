"""Closed, full and endless standard streams: a job that does not need them works, others get one clear line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from commands import QUICK, assert_refused, invoke, write_photo
from PIL import Image

import warpvec
from warpvec.image import read
from warpvec.svg import document

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs a POSIX shell")

needs_full_device = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full, which only Linux has")


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


def _shell(redirections: str, *arguments: object) -> tuple[int, str]:
    """Run ``warpvec`` in a process with these redirections of the shell; return its exit code and its stderr."""
    words = [sys.executable, "-m", "warpvec", *map(str, arguments)]
    command = ["sh", "-c", f'exec "$@" {redirections}', "sh", *words]
    environment = {**os.environ, "PYTHONPATH": str(Path(warpvec.__file__).parents[1])}
    run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300, check=False)
    return run.returncode, run.stderr


@pytest.mark.slow
def test_a_run_works_without_any_stream(photo: Path) -> None:
    out, frame = photo.with_name("out.svg"), photo.with_name("fit.gif")
    options = [*QUICK, "--video", frame, "--checkpoint", photo.with_name("state"), "--every", "1"]
    assert _shell("<&- >&- 2>&-", "run", photo, out, *options) == (0, "")
    assert invoke("run", photo, photo.with_name("again.svg"), *QUICK).exit_code == 0
    assert out.read_bytes() == photo.with_name("again.svg").read_bytes()
    with Image.open(frame) as image:
        assert image.size == (48, 32)


@pytest.mark.parametrize(
    ("redirection", "arguments", "line"),
    [
        (">&-", ["run", "{}", "-"], "OUT must be a file when stdout is closed, got - for stdout; name a file"),
        ("<&-", ["run", "-", "out.svg"], "IN must be a file when stdin is closed, got - for stdin; name a file"),
        ("0>/dev/null", ["eval", "{}", "-"], "SVG must be a file when stdin cannot be read, got - (Bad file"),
    ],
)
def test_a_stream_that_is_asked_for_must_be_open(
    redirection: str, arguments: list[str], line: str, photo: Path
) -> None:
    code, stderr = _shell(redirection, *(word.format(photo) for word in arguments))
    assert code == 2
    assert stderr.startswith(f"warpvec: error: {line}")
    assert stderr.count("\n") == 1


@pytest.mark.slow
@needs_full_device
def test_a_full_stdout_is_one_line(photo: Path) -> None:
    for arguments in (["--help"], ["run", photo, "-", *QUICK, "-q"]):
        code, stderr = _shell(">/dev/full", *arguments)
        assert code == 1
        assert stderr.startswith("warpvec: error: the disk is full (No space left on device), ")
        assert stderr.count("\n") == 1


@pytest.mark.slow
@needs_full_device
def test_a_full_stderr_costs_nothing(photo: Path) -> None:
    out = photo.with_name("out.svg")
    assert _shell("2>/dev/full", "run", photo, out, *QUICK) == (0, "")
    assert out.read_text(encoding="utf-8").endswith("</svg>\n")


def test_a_reader_that_leaves_is_told_in_one_line(photo: Path) -> None:
    assert invoke("run", photo, photo.with_name("out.svg"), *QUICK).exit_code == 0
    environment = {**os.environ, "PYTHONPATH": str(Path(warpvec.__file__).parents[1])}
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "warpvec", "lod", str(photo.with_name("out.svg"))]
    run = subprocess.run(
        command, env=environment, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=300, check=False
    )
    os.close(writing)
    assert (run.returncode, run.stderr) == (
        1,
        "warpvec: error: the reader of the output left before all was written\n",
    )


def test_stdin_is_read_up_to_the_limit(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read, "MAX_IMAGE_BYTES", 1000)
    monkeypatch.setattr(document, "MAX_SVG_BYTES", 500)
    out = photo.with_name("out.svg")
    result = invoke("run", "-", out, stdin=bytes(1001))
    assert_refused(result, "IN must have at most 1000 bytes, got more in stdin; give a smaller file")
    small = photo.with_name("small.png")
    Image.new("L", (2, 2)).save(small)
    assert_refused(invoke("eval", small, "-", stdin=bytes(501)), "SVG must have at most 500 bytes, got more in stdin")
    if os.path.exists("/dev/zero"):
        assert_refused(invoke("eval", small, "/dev/zero"), "SVG must have at most 500 bytes, got more in '/dev/zero'")
        assert_refused(invoke("run", "/dev/zero", out), "IN must have at most 1000 bytes, got more in '/dev/zero'")
        assert_refused(invoke("run", photo, out, "--config", "/dev/zero"), "--config must have at most")
        assert_refused(invoke("run", photo, out, "--palette", "/dev/zero"), "--palette must have at most")
        assert_refused(invoke("view", out, "--history", "/dev/zero"), "SVG must be an SVG file")
