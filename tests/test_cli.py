"""The command, as a user meets it: files, streams, exit codes, one line for each mistake, nothing left behind."""

from __future__ import annotations

import dataclasses
import functools
import gzip
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image
from stubs import circles, progress_at, stub_fit

import warpvec
from warpvec import api, progress
from warpvec.cli import main
from warpvec.config import FitConfig, make_config
from warpvec.options import SETTINGS

QUICK = ["--curves", "8", "--iterations", "3"]


@pytest.fixture(autouse=True)
def quick_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(api, "fit", stub_fit)


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A noisy 48 x 32 photo in a folder of its own."""
    path = tmp_path / "photo.png"
    Image.fromarray(np.random.default_rng(1).integers(0, 256, (32, 48, 3), dtype=np.uint8)).save(path)
    return path


def _invoke(*arguments: object, stdin: bytes = b"") -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments], input=stdin)


def _assert_refused(result: Result, *words: str) -> None:
    """One line that says what is wrong, exit code 2, nothing on stdout."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("warpvec: error: ")
    for word in words:
        assert word in line


# run


def test_run_writes_the_file_and_a_summary(photo: Path) -> None:
    out = photo.with_name("out.svg")
    result = _invoke("run", photo, out, *QUICK)
    assert result.exit_code == 0, result.output
    text = out.read_text(encoding="utf-8")
    assert text.count("<path") == 8
    assert 'width="48" height="32"' in text
    assert f"{out}: 8 curves, 32 segments, {len(text.encode()):,} bytes" in result.stdout
    assert "as resvg draws the file" in result.stdout
    assert "3 iterations in 1.5 s on cpu" in result.stdout
    assert sorted(os.listdir(photo.parent)) == ["out.svg", "photo.png"]


def test_run_json_is_one_object_and_names_every_measure(photo: Path) -> None:
    result = _invoke("run", photo, photo.with_name("out.svg"), "--json", *QUICK)
    metrics = json.loads(result.stdout)
    wanted = "curves segments bytes gzip_bytes iterations seconds device internal_psnr psnr ssim mean_opacity"
    assert set(wanted.split()) <= set(metrics)
    assert metrics["curves"] == 8
    assert result.stdout.count("\n") == 1


def test_json_says_null_where_the_psnr_is_infinite(tmp_path: Path) -> None:
    Image.new("RGB", (8, 8), (255, 0, 0)).save(tmp_path / "red.png")
    (tmp_path / "red.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"><rect width="8" height="8" fill="#f00"/></svg>'
    )
    result = _invoke("eval", tmp_path / "red.png", tmp_path / "red.svg", "--json")
    assert json.loads(result.stdout)["psnr"] is None
    assert "PSNR inf dB" in _invoke("eval", tmp_path / "red.png", tmp_path / "red.svg").stdout


def test_streams_carry_the_photo_in_and_the_svg_alone_out(photo: Path) -> None:
    result = _invoke("run", "-", "-", *QUICK, stdin=photo.read_bytes())
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("<?xml")
    assert result.stdout.endswith("</svg>\n")
    assert "8 curves" in result.stderr
    assert os.listdir(photo.parent) == ["photo.png"]


def test_json_goes_to_stderr_where_stdout_carries_the_svg(photo: Path) -> None:
    result = _invoke("run", photo, "-", "--json", "-q", *QUICK)
    assert json.loads(result.stderr)["curves"] == 8
    assert result.stdout.endswith("</svg>\n")


def test_svgz_is_the_same_text_gzipped(photo: Path) -> None:
    for name in ("out.svg", "out.svgz"):
        assert _invoke("run", photo, photo.with_name(name), "--iterations", "1", "--curves", "1").exit_code == 0
    assert gzip.decompress(photo.with_name("out.svgz").read_bytes()).startswith(b"<?xml")


def test_quiet_says_nothing(photo: Path) -> None:
    result = _invoke("run", photo, photo.with_name("out.svg"), "-q", *QUICK)
    assert result.exit_code == 0
    assert result.output == ""


def test_progress_is_plain_lines_where_stderr_is_no_terminal(photo: Path) -> None:
    result = _invoke("run", photo, photo.with_name("out.svg"), *QUICK)
    lines = result.stderr.splitlines()
    assert lines[0] == "iteration 1 of 3, 8 curves, 20.00 dB"
    assert lines[-1] == "iteration 3 of 3, 8 curves, 20.00 dB, 0 s left"


def test_frames_are_saved_every_so_often_and_at_the_end(photo: Path) -> None:
    folder = photo.parent / "new" / "frames"
    arguments = ["--iterations", "5", "--save-frames", folder, "--every", "2"]
    assert _invoke("run", photo, photo.with_name("out.svg"), *arguments).exit_code == 0
    assert sorted(os.listdir(folder)) == ["frame-000002.png", "frame-000004.png", "frame-000005.png"]
    with Image.open(folder / "frame-000004.png") as frame:
        assert frame.size == (48, 32)


def test_interrupted_fit_is_saved_and_exits_with_130(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(api, "fit", functools.partial(stub_fit, interrupted=True))
    out = photo.with_name("out.svg")
    result = _invoke("run", photo, out, *QUICK)
    assert result.exit_code == 130
    assert out.read_text(encoding="utf-8").endswith("</svg>\n")
    assert "8 curves" in result.stdout


def test_interrupt_outside_the_fit_exits_with_130_and_writes_nothing(
    photo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(api, "fit", interrupt)
    assert _invoke("run", photo, photo.with_name("out.svg")).exit_code == 130
    assert os.listdir(photo.parent) == ["photo.png"]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], FitConfig()),
        (["--preset", "paper"], make_config("paper")),
        (
            ["--preset", "paper", "--lr-points", "0.02", "--flat", "--no-compensate", "--recycle-gap", "0"],
            make_config("paper", lr_points=0.02, flat=True, compensate=False, recycle_gap=0),
        ),
    ],
)
def test_options_reach_the_fit_and_the_rest_falls_to_the_preset(
    photo: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], expected: FitConfig
) -> None:
    seen: list[FitConfig] = []

    def record(target: Any, config: FitConfig, on_progress: Any) -> Any:
        seen.append(config)
        return stub_fit(target, FitConfig(curves=1, iterations=1), on_progress)

    monkeypatch.setattr(api, "fit", record)
    assert _invoke("run", photo, "-", *options).exit_code == 0
    assert seen == [expected]


def test_every_setting_is_an_option_of_run() -> None:
    names = [name for section in SETTINGS.values() for name in section]
    assert sorted(names) == sorted(field.name for field in dataclasses.fields(FitConfig))
    text = _invoke("run", "--help").stdout
    for name in names:
        assert f"--{name.replace('_', '-')} " in text


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--curves", "0"], ["--curves must be", "at least 1", "got 0"]),
        (["--curves", "many"], ["--curves", "many"]),
        (["--fit-size", "0"], ["--fit-size must be", "got 0"]),
        (["--iterations", "-1"], ["--iterations must be"]),
        (["--threads", "0"], ["--threads must be"]),
        (["--time-budget", "0"], ["--time-budget must be"]),
        (["--time-budget", "inf"], ["--time-budget must be a finite", "got inf"]),
        (["--precision", "400"], ["--precision must be", "from 0 to 6", "got 400"]),
        (["--growth", "1.00001"], ["--growth must be 1 or at least 1.01", "got 1.00001"]),
        (["--save-frames", ""], ["--save-frames must be a folder", "got ''", "choose another"]),
        (["--radius-decay", "nan"], ["--radius-decay must", "nan"]),
        (["--preset", "fast"], ["--preset must be one of draft, default, best, paper", "fast"]),
        (["--renderer", "blur"], ["--renderer must be one of", "blur"]),
        (["--z-order", "depth"], ["--z-order must be one of", "depth"]),
        (["--device", "gpu"], ["--device must be auto or one of cpu", "'gpu'"]),
        (["--device", "cuda:99"], ["--device must be auto or one of cpu", "'cuda:99'"]),
        (["--background", "sea"], ["--background must be", "'sea'"]),
        (["--every", "0"], ["--every", "0"]),
        (["--colour"], ["No such option", "--colour"]),
    ],
)
def test_wrong_settings_are_refused_before_anything_is_written(
    photo: Path, options: list[str], words: list[str]
) -> None:
    _assert_refused(_invoke("run", photo, photo.with_name("out.svg"), *options), *words)
    assert os.listdir(photo.parent) == ["photo.png"]


def _jpeg(size: tuple[int, int] = (64, 64)) -> bytes:
    stream = io.BytesIO()
    Image.effect_noise(size, 90).save(stream, format="JPEG")
    return stream.getvalue()


@pytest.mark.parametrize(
    ("data", "word"),
    [
        (b"", "empty"),
        (b"plain text, no image", "not recognised"),
        (_jpeg()[:-400], "truncated"),
        (b"BM" + bytes(52), "IN must be"),
        (b"\x89PNG\r\n\x1a\n", "IN must be"),
    ],
)
@pytest.mark.parametrize("as_stream", [False, True])
def test_what_is_no_image_is_refused(tmp_path: Path, data: bytes, word: str, as_stream: bool) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(data)
    result = _invoke("run", "-" if as_stream else path, tmp_path / "out.svg", stdin=data)
    _assert_refused(result, "IN must be", word)
    assert os.listdir(tmp_path) == ["photo.jpg"]


def test_missing_photo_and_folder_as_photo_are_refused(tmp_path: Path) -> None:
    _assert_refused(_invoke("run", tmp_path / "none.png", tmp_path / "out.svg"), "IN must be", "none.png")
    _assert_refused(_invoke("run", tmp_path, tmp_path / "out.svg"), "IN must be", str(tmp_path))
    assert os.listdir(tmp_path) == []


def test_out_is_checked_before_the_photo_is_read(tmp_path: Path) -> None:
    none = tmp_path / "none.png"
    _assert_refused(_invoke("run", none, tmp_path / "missing" / "out.svg"), "OUT must be in", "missing")
    _assert_refused(_invoke("run", none, tmp_path), "OUT must name a file")
    _assert_refused(_invoke("run", none, tmp_path / "out.png"), "OUT must end in .svg or .svgz", "out.png")
    assert os.listdir(tmp_path) == []


def test_the_photo_is_never_overwritten(photo: Path) -> None:
    before = photo.read_bytes()
    _assert_refused(_invoke("run", photo, photo), "OUT must end in .svg or .svgz")
    assert photo.read_bytes() == before


def test_write_protected_folders_are_refused(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    locked = photo.parent / "locked"
    locked.mkdir()
    # Not by its mode: root may write to any folder.
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != locked)
    _assert_refused(_invoke("run", photo, locked / "out.svg"), "OUT must be", "locked")
    result = _invoke("run", photo, photo.with_name("out.svg"), "--save-frames", locked)
    _assert_refused(result, "--save-frames must be a folder you may write to", "locked")


def test_frames_folder_that_is_a_file_is_refused(photo: Path) -> None:
    result = _invoke("run", photo, photo.with_name("out.svg"), "--save-frames", photo)
    _assert_refused(result, "--save-frames must be", "photo.png")
    assert os.listdir(photo.parent) == ["photo.png"]


def test_out_may_be_a_device(photo: Path) -> None:
    assert _invoke("run", photo, os.devnull, *QUICK).exit_code == 0


# the group


def test_usage_errors_are_one_line() -> None:
    _assert_refused(_invoke("run"), "IN")
    _assert_refused(_invoke("trace"), "trace")
    _assert_refused(_invoke("--fast"), "--fast")


def test_without_a_command_it_shows_the_help() -> None:
    result = _invoke()
    assert result.exit_code == 2
    assert "Commands:" in result.stderr
    assert _invoke("--help").exit_code == 0


def test_unexpected_failure_is_one_line_with_a_hint(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object) -> None:
        raise RuntimeError("the reactor\nis hot")

    monkeypatch.setattr(api, "fit", fail)
    result = _invoke("run", photo, photo.with_name("out.svg"))
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("warpvec: error: RuntimeError: the reactor is hot; warpvec --debug run ...")
    assert os.listdir(photo.parent) == ["photo.png"]
    debugged = _invoke("--debug", "run", photo, photo.with_name("out.svg"))
    assert isinstance(debugged.exception, RuntimeError)


# eval, info, sample


def test_eval_repeats_the_measures_of_run(photo: Path) -> None:
    for name in ("out.svg", "out.svgz"):
        out = photo.with_name(name)
        metrics = json.loads(_invoke("run", photo, out, "--json", *QUICK).stdout)
        again = json.loads(_invoke("eval", photo, out, "--json").stdout)
        assert again == {name: metrics[name] for name in again}
        assert set(again) == {"curves", "segments", "bytes", "gzip_bytes", "psnr", "ssim"}


def test_eval_refuses_what_is_no_svg(photo: Path) -> None:
    _assert_refused(_invoke("eval", photo, photo), "SVG must")
    _assert_refused(_invoke("eval", photo, photo.with_name("none.svg")), "OUT must be an SVG file", "none.svg")
    _assert_refused(_invoke("eval", photo, photo.parent), "OUT must be an SVG file")


def test_info_names_versions_devices_and_the_cache() -> None:
    facts = json.loads(_invoke("info", "--json").stdout)
    assert {"warpvec", "warp", "torch", "numpy", "resvg", "python", "cpu_count", "devices"} <= set(facts)
    assert facts["devices"][0] == "cpu"
    assert facts["kernel_cache_bytes"] >= 0
    assert f"kernel cache: {facts['kernel_cache']}" in _invoke("info").stdout


def test_sample_writes_a_real_photo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    monkeypatch.chdir(tmp_path)
    assert _invoke("sample").stdout == "coffee.png\n"
    assert _invoke("sample", "chelsea.png", "cat.png").exit_code == 0
    with Image.open("coffee.png") as coffee, Image.open("cat.png") as cat:
        assert (coffee.size, cat.size) == ((600, 400), (451, 300))


def test_sample_refuses_unknown_names_and_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _assert_refused(_invoke("sample", "mars.png"), "NAME must be one of", "coffee.png", "mars.png")
    _assert_refused(_invoke("sample", "coffee.png", "missing/x.png"), "OUT must be in")
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
    assert "iteration 1 of 90, 5 curves, 20.00 dB" in stream.getvalue()
    assert "iteration 90 of 90, 5 curves, 20.00 dB, 0 s left" in stream.getvalue()


def test_time_left_goes_by_the_pace_after_the_first_iteration() -> None:
    pace, scene = progress.Pace(), circles(8, 8, 5)
    late = [dataclasses.replace(progress_at(k, 90, scene), seconds=100 + 0.5 * k) for k in (1, 30)]
    assert pace.describe(late[0]).endswith("20.00 dB")
    assert pace.describe(late[1]).endswith(", 30 s left")


def test_lines_come_at_most_every_few_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([0.0, 1.0, 4.9, 5.0, 6.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(now))
    stream = io.StringIO()
    with progress.show_progress(stream) as show:
        for iteration in range(1, 6):
            show(progress_at(iteration, 100, circles(8, 8, 1)))
    assert [line.split()[1] for line in stream.getvalue().splitlines()] == ["1", "4"]


# real processes


def _start(*arguments: object) -> subprocess.Popen[str]:
    """The command in a process of its own, with the warpvec that is tested, installed or not."""
    command = [sys.executable, "-m", "warpvec", *(str(argument) for argument in arguments)]
    environment = {**os.environ, "PYTHONPATH": str(Path(warpvec.__file__).parents[1])}
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def _finish(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Exit code, stdout and stderr."""
    with process:
        stdout, stderr = process.communicate(timeout=300)
    return process.returncode, stdout, stderr


def test_help_imports_neither_torch_nor_warp() -> None:
    code = "import sys, warpvec.cli; print(sorted({'torch', 'warp', 'numpy', 'rich', 'PIL'} & set(sys.modules)))"
    root = Path(warpvec.__file__).parents[1]
    assert subprocess.check_output([sys.executable, "-c", code], text=True, cwd=root).strip() == "[]"
    returncode, stdout, _ = _finish(_start("--help"))
    assert returncode == 0
    assert "Commands:" in stdout


def test_process_with_bad_input_exits_with_2(tmp_path: Path) -> None:
    returncode, stdout, stderr = _finish(_start("run", tmp_path / "none.png", tmp_path / "out.svg"))
    assert returncode == 2
    assert stdout == ""
    (line,) = stderr.splitlines()
    assert line.startswith("warpvec: error: IN must be")
    assert os.listdir(tmp_path) == []


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
    assert "as resvg draws the file" in stdout


def _wait_for_a_frame(folder: Path, process: subprocess.Popen[str]) -> None:
    """Returns when the fit is under way, for which a frame is the sign."""
    while not (folder.is_dir() and any(folder.glob("*.png"))):
        assert process.poll() is None, "it ended before its first frame"
        time.sleep(0.1)
