"""Errors, the commands eval, info and sample, progress, and real processes."""

from __future__ import annotations

import dataclasses
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from children import limit, start
from commands import QUICK, assert_refused, invoke, write_photo
from PIL import Image
from stubs import circles, progress_at

import warpvec
from warpvec.cli import progress
from warpvec.modes import photo as photo_mode
from warpvec.watch import progress as reports

pytestmark = pytest.mark.usefixtures("quick_fit")


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A noisy 48 x 32 photo in a folder of its own."""
    return write_photo(tmp_path)


# errors


def test_usage_errors_are_one_line() -> None:
    assert_refused(invoke("run"), "Missing argument 'IN'. See warpvec run --help.")
    assert_refused(invoke("eval", "my", "photo.png", "a.svg"), "extra argument (a.svg). See warpvec eval --help.")
    assert_refused(invoke("eval", "photo.png"), "SVG")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such names")
def test_a_hostile_name_stays_in_its_line(photo: Path, tmp_path: Path) -> None:
    drawing = tmp_path / "a\nb\x1b[31m.svg"
    drawing.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="48" height="32"/>')
    first = invoke("eval", photo, drawing).stdout.splitlines()[0]
    assert first.isprintable() and r"a\nb\x1b[31m.svg: 0 paths" in first


def test_unexpected_failure_is_one_line_with_a_hint(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object, **_: object) -> None:
        raise RuntimeError("the reactor\nis hot")

    monkeypatch.setattr(photo_mode, "fit", fail)
    result = invoke("run", photo, photo.with_name("out.svg"))
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("warpvec: error: RuntimeError: the reactor is hot; run warpvec --debug run ...")
    assert os.listdir(photo.parent) == ["photo.png"]
    debugged = invoke("--debug", "run", photo, photo.with_name("out.svg"))
    assert isinstance(debugged.exception, RuntimeError)


# eval, info, sample


def test_eval_repeats_the_measures_of_run(photo: Path) -> None:
    for name in ("out.svg", "out.svgz"):
        out = photo.with_name(name)
        metrics = json.loads(invoke("run", photo, out, "--json", *QUICK).stdout)
        again = json.loads(invoke("eval", photo, out, "--json").stdout)
        assert again == {name: metrics[name] for name in again}
        counts = {"curves", "gradients", "segments", "parameters", "soft", "strokes", "circles", "ellipses", "rects"}
        counts |= {"stroke_looks", "found", "kinds", "millimeters"}
        assert set(again) == counts | {"bytes", "gzip_bytes", "psnr", "ssim", "transparent"}


def test_eval_counts_what_is_painted_and_its_gradients(photo: Path) -> None:
    stops = '<defs><linearGradient id="a"><stop stop-color="red"/><stop offset="1"/></linearGradient></defs>'
    shapes = '<path d="M0 0h48v32z" fill="url(#a)"/>'
    text = '<svg xmlns="http://www.w3.org/2000/svg" width="48" height="32">{}</svg>'
    drawing = photo.with_name("drawing.svg")
    for drawn, words in ((shapes, "1 path (1 with a gradient), 3 segments, "), (shapes + "<circle/>", "2 paths (1 ")):
        drawing.write_text(text.format(stops + drawn))
        assert f"drawing.svg: {words}" in invoke("eval", photo, drawing).stdout


def test_an_infinite_psnr_is_null_in_json(tmp_path: Path) -> None:
    Image.new("RGB", (8, 8), (255, 0, 0)).save(tmp_path / "red.png")
    (tmp_path / "red.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"><rect width="8" height="8" fill="#f00"/></svg>'
    )
    result = invoke("eval", tmp_path / "red.png", tmp_path / "red.svg", "--json")
    assert json.loads(result.stdout)["psnr"] is None
    assert "PSNR inf dB" in invoke("eval", tmp_path / "red.png", tmp_path / "red.svg").stdout


def test_eval_view_and_lod_read_the_svg_from_stdin(photo: Path) -> None:
    out, page = photo.with_name("out.svg"), photo.with_name("page.html")
    assert invoke("run", photo, out, *QUICK).exit_code == 0
    drawing = out.read_bytes()
    result = invoke("eval", photo, "-", stdin=drawing)
    assert result.stdout == invoke("eval", photo, out).stdout.replace(str(out), "SVG")
    assert invoke("eval", "-", out, stdin=photo.read_bytes()).exit_code == 0
    assert invoke("lod", "-", stdin=drawing).stdout == invoke("lod", out).stdout
    assert invoke("view", "-", "--report", page, stdin=drawing).exit_code == 0
    assert '"name": "drawing"' in page.read_text() or '"name":"drawing"' in page.read_text()


def test_only_one_input_may_be_stdin() -> None:
    remedy = "got - for both; save one of them as a file"
    assert_refused(invoke("eval", "-", "-"), f"SVG must be a file when IMAGE is stdin, {remedy}")
    assert_refused(invoke("lod", "-", "--image", "-"), f"--image must be a file when SVG is stdin, {remedy}")
    assert_refused(invoke("view", "-", "--image", "-"), f"--image must be a file when SVG is stdin, {remedy}")
    assert_refused(invoke("refine", "-", "-", "--from", "-"), f"--from must be a file when IN is stdin, {remedy}")
    assert_refused(invoke("lod", "-", "--split"), "SVG must be a file with --split")


def test_eval_refuses_other_files(photo: Path) -> None:
    assert_refused(invoke("eval", photo, photo), "SVG must")
    wide = photo.with_name("wide.svg")
    wide.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="300" height="10"/>')
    assert_refused(invoke("eval", photo, wide), "SVG must have the proportions of 48 x 32, got 300 x 10; ")
    assert_refused(invoke("eval", photo, photo.with_name("none.svg")), "SVG must be an SVG file", "none.svg")
    assert_refused(invoke("eval", photo, photo.parent), "SVG must be an SVG file")
    assert_refused(invoke("eval", photo.with_name("none.png"), photo), "IMAGE must be", "none.png")


def test_info_names_versions_devices_and_the_cache() -> None:
    facts = json.loads(invoke("info", "--json").stdout)
    assert {"warpvec", "warp", "torch", "numpy", "resvg", "python", "cpu_count", "devices"} <= set(facts)
    assert facts["gpu"] == "used" if len(facts["devices"]) > 1 else facts["gpu"].startswith("not used: ")
    assert facts["devices"][0] == "cpu"
    assert facts["kernel_cache_bytes"] >= 0
    assert f"kernel cache: {facts['kernel_cache']}" in invoke("info").stdout


def test_sample_writes_a_real_photo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    monkeypatch.chdir(tmp_path)
    assert invoke("sample").stdout == "coffee.png\n"
    assert invoke("sample", "chelsea.png", "cat.png").exit_code == 0
    with Image.open("coffee.png") as coffee, Image.open("cat.png") as cat:
        assert (coffee.size, cat.size) == ((600, 400), (451, 300))


def test_sample_replaces_a_file_only_if_told_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    monkeypatch.chdir(tmp_path)
    Path("cup.png").write_bytes(b"mine")
    assert_refused(invoke("sample", "coffee.png", "cup.png"), "OUT must be a new file, got 'cup.png'; add --force")
    assert Path("cup.png").read_bytes() == b"mine"
    assert invoke("sample", "coffee.png", "cup.png", "--force").exit_code == 0
    assert Path("cup.png").read_bytes() != b"mine"


def test_sample_refuses_unknown_names_and_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(invoke("sample", "mars.png"), "NAME must be one of", "coffee.png", "mars.png")
    assert_refused(invoke("sample", "coffee.png", "missing/x.png"), "OUT must be in")
    assert os.listdir(tmp_path) == []


# progress


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_bar_shows_iteration_curves_psnr_and_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    stream = _Terminal()
    with progress.show_progress(stream) as show:
        assert "starting" in stream.getvalue() or stream.getvalue() == ""
        show(progress_at(1, 90, circles(8, 8, 5)))
        show(progress_at(90, 90, circles(8, 8, 5)))
    assert "iteration 1 of 90, 5 paths, 20.00 dB" in stream.getvalue()
    assert "iteration 90 of 90, 5 paths, 20.00 dB, 0 s left" in stream.getvalue()


def test_time_left_goes_by_the_pace_after_the_first_iteration() -> None:
    pace, scene = reports.Pace(), circles(8, 8, 5)
    late = [dataclasses.replace(progress_at(k, 90, scene), seconds=100 + 0.5 * k) for k in (1, 30)]
    assert pace.describe(late[0]).endswith("20.00 dB")
    assert pace.describe(late[1]).endswith(", 30 s left")


@pytest.mark.parametrize("terminal", [False, True])
def test_a_second_fit_has_a_clock_of_its_own(monkeypatch: pytest.MonkeyPatch, terminal: bool) -> None:
    """Its first iteration starts the clock even if it is not shown."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    now = 0.0
    monkeypatch.setattr(reports.time, "monotonic", lambda: now)
    stream, scene = _Terminal() if terminal else io.StringIO(), circles(8, 8, 5)
    with progress.show_progress(stream) as show:
        for iteration in range(1, 11):
            show(dataclasses.replace(progress_at(iteration, 10, scene), seconds=100.0 + iteration))
        for iteration in range(1, 31):
            now = 0.0 if iteration < 20 else 9.0
            show(progress_at(iteration, 40, scene))
    assert "iteration 20 of 40, 5 paths, 20.00 dB, 10 s left" in stream.getvalue()


def test_lines_come_at_most_every_few_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([0.0, 1.0, 4.9, 5.0, 6.0])
    monkeypatch.setattr(reports.time, "monotonic", lambda: next(now))
    stream = io.StringIO()
    with progress.show_progress(stream) as show:
        for iteration in range(1, 6):
            show(progress_at(iteration, 100, circles(8, 8, 1)))
    assert [line.split()[1] for line in stream.getvalue().splitlines()] == ["1", "4"]


# real processes


def _start(*arguments: object) -> subprocess.Popen[str]:
    """Start the command in a process, with the warpvec that is tested even if another one is installed."""
    command = [sys.executable, "-m", "warpvec", *(str(argument) for argument in arguments)]
    environment = {**os.environ, "PYTHONPATH": str(Path(warpvec.__file__).parents[1])}
    return start(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def _finish(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Wait for the process and return its exit code, stdout and stderr."""
    with process:
        stdout, stderr = process.communicate(timeout=limit())
    return process.returncode, stdout, stderr


def test_process_with_bad_input_exits_with_2(tmp_path: Path) -> None:
    returncode, stdout, stderr = _finish(_start("run", tmp_path / "none.png", tmp_path / "out.svg"))
    assert returncode == 2
    assert stdout == ""
    (line,) = stderr.splitlines()
    assert line.startswith("warpvec: error: IN must be")
    assert os.listdir(tmp_path) == []


@pytest.mark.slow
def test_real_run_is_reproducible_and_leaves_one_file(photo: Path) -> None:
    options = ["--curves", 16, "--iterations", 30, "--inflation-gap", 5, "--json"]
    files = []
    for threads in (1, 2):
        out = photo.with_name("out.svg")
        returncode, stdout, stderr = _finish(_start("run", photo, out, *options, "--threads", threads))
        assert returncode == 0, stderr
        assert json.loads(stdout)["iterations"] == 30
        assert "iteration 30 of 30" in stderr
        files.append(out.read_bytes())
    assert files[0] == files[1]
    assert sorted(os.listdir(photo.parent)) == ["out.svg", "photo.png"]


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to send")
def test_ctrl_c_saves_the_best_so_far_and_exits_with_130(photo: Path) -> None:
    out, frames = photo.with_name("out.svg"), photo.parent / "frames"
    options = ["--curves", 16, "--iterations", 1_000_000, "--save-frames", frames, "--every", 5]
    process = _start("run", photo, out, *options)
    try:
        _wait_for_a_frame(frames, process)
        process.send_signal(signal.SIGINT)
        returncode, stdout, stderr = _finish(process)
    finally:
        process.kill()
    assert returncode == 130, stderr
    assert out.read_text(encoding="utf-8").endswith("</svg>\n")
    assert "file drawn by resvg" in stdout


def _wait_for_a_frame(folder: Path, process: subprocess.Popen[str]) -> None:
    """Wait for the first frame, which shows that the fit has started."""
    while not (folder.is_dir() and any(folder.glob("*.png"))):
        assert process.poll() is None, "it ended before its first frame"
        time.sleep(0.1)
