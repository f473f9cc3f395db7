"""``warpvec run``: files, streams, options, and mistakes that are reported in one line and leave nothing behind."""

from __future__ import annotations

import functools
import gzip
import io
import json
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from commands import QUICK, assert_refused, invoke, write_photo
from PIL import Image
from stubs import stub_fit

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.image.metrics import psnr
from warpvec.modes import photo as photo_mode
from warpvec.rendering import devices, launch
from warpvec.writers.registry import WRITERS, listed

pytestmark = pytest.mark.usefixtures("quick_fit")


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A noisy 48 x 32 photo in a folder of its own."""
    return write_photo(tmp_path)


# output


def test_run_writes_the_file_and_a_summary(photo: Path) -> None:
    out = photo.with_name("out.svg")
    result = invoke("run", photo, out, *QUICK)
    assert result.exit_code == 0, result.output
    text = out.read_text(encoding="utf-8")
    assert text.count("<path") == 8
    assert 'width="48" height="32"' in text
    assert f"{out}: 8 paths, 32 segments, {len(text.encode()):,} bytes" in result.stdout
    assert re.search(r"^PSNR \d+\.\d\d dB, SSIM -?\d\.\d{3} \(file drawn by resvg\)$", result.stdout, re.MULTILINE)
    assert re.search(r"^3 iterations in \d+\.\d s on cpu, \d+ threads?$", result.stdout, re.MULTILINE)
    assert sorted(os.listdir(photo.parent)) == ["out.svg", "photo.png"]


def test_out_is_the_svg_beside_the_image_unless_given(photo: Path) -> None:
    out = photo.with_name("photo.svg")
    before = photo.read_bytes()
    result = invoke("run", photo, *QUICK)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: 8 paths")
    assert out.read_text(encoding="utf-8").endswith("</svg>\n")
    assert photo.read_bytes() == before
    assert_refused(invoke("run", out), "IN must be an image such as a PNG or JPEG file", "photo.svg")
    assert_refused(invoke("run", photo.parent / "."), "IN must be")
    result = invoke("run", "-", stdin=before)
    assert_refused(result, "OUT must be given when IN is stdin; add a file name, or - for stdout")
    assert_refused(invoke("run", "-", "--curves", 0, stdin=before), "--curves must be a whole number from 1")
    assert_refused(invoke("run", "-", "--size", 90, stdin=before), "--size must have a unit")
    assert sorted(os.listdir(photo.parent)) == ["photo.png", "photo.svg"]


def test_a_number_of_soft_paths_without_effect_is_named(photo: Path) -> None:
    svg = photo.with_name("out.svg")
    result = invoke("run", photo, svg, *QUICK, "--mode", "photo", "--soft", 2)
    assert "no path is soft: short fits" in result.stdout
    result = invoke("run", photo, svg, *QUICK, "--mode", "photo", "--soft", 2, "--target-psnr", 5)
    assert "no path is soft: a fit to a quality has none" in result.stdout
    assert "no path is soft" not in invoke("run", photo, svg, *QUICK, "--mode", "photo").stdout


def test_a_default_out_replaces_only_files_of_warpvec(tmp_path: Path) -> None:
    photo = write_photo(tmp_path, "&" * 150 + ".png")  # its title, "&amp;&amp;...", comes before the metadata
    out = photo.with_suffix(".svg")
    assert invoke("run", photo, *QUICK).exit_code == 0
    assert invoke("run", photo, *QUICK, "--curves", "3").exit_code == 0
    own = out.read_text(encoding="utf-8")
    assert own.count("<path") == 3
    for text in ("", '<svg xmlns="http://www.w3.org/2000/svg"/>', own.replace("<metadata>", '<metadata id="m">')):
        out.write_text(text, encoding="utf-8")
        result = invoke("run", photo, *QUICK)
        assert_refused(
            result, f"OUT must be given, because '{out}' exists and does not say that warpvec wrote it; name a file"
        )
        assert out.read_text(encoding="utf-8") == text
    assert invoke("run", photo, out, *QUICK).exit_code == 0


def test_a_summary_has_the_internal_psnr_if_verbose_or_for_splat(photo: Path) -> None:
    def summary(*options: str) -> str:
        result = invoke("run", photo, photo.with_name("out.svg"), *options, *QUICK)
        assert result.exit_code == 0, result.output
        return result.stdout

    paper = summary("--preset", "paper").splitlines()
    assert re.fullmatch(r"PSNR \d+\.\d\d dB inside the fit \(of the splat renderer's soft image\)", paper[2])
    assert re.fullmatch(r"sides of degree 5 written as cubics within 0\.0\d\d px", paper[3])
    cubic, exact, plain = summary("--renderer", "splat"), summary("--verbose"), summary()
    assert "soft image" in cubic
    assert "inside the fit (as the exact renderer draws it)" in exact
    assert "inside the fit" not in plain
    assert all("written as cubics" not in text for text in (cubic, exact, plain))


@pytest.mark.parametrize("reason", ["there is an NVIDIA GPU, but torch was built without CUDA", devices.NO_HARDWARE])
def test_a_summary_says_why_auto_chose_the_cpu_if_there_is_a_gpu_or_verbose(
    reason: str, photo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(launch, "gpu_count", lambda: 0)
    monkeypatch.setattr(devices, "why_no_gpu", lambda: reason)

    def place(*options: str) -> str:
        result = invoke("run", photo, photo.with_name("out.svg"), *options, *QUICK, "--threads", 1)
        return re.search(r" iterations in [\d.]+ s on (.*), 1 thread$", result.stdout, re.MULTILINE)[1]

    assert place() == ("cpu" if reason == devices.NO_HARDWARE else f"cpu ({reason})")
    assert place("--verbose") == f"cpu ({reason})"
    assert place("--device", "cpu", "--verbose") == "cpu"
    metrics = json.loads(invoke("run", photo, photo.with_name("out.svg"), "--json", *QUICK).stdout)
    assert (metrics["device"], metrics.get("device_reason")) == (
        "cpu",
        None if reason == devices.NO_HARDWARE else reason,
    )


def test_run_json_is_one_object_and_names_every_measure(photo: Path) -> None:
    result = invoke("run", photo, photo.with_name("out.svg"), "--json", *QUICK)
    metrics = json.loads(result.stdout)
    wanted = "curves segments bytes gzip_bytes iterations seconds device internal_psnr psnr ssim mean_opacity"
    assert set(wanted.split()) <= set(metrics)
    assert metrics["curves"] == 8
    assert result.stdout.count("\n") == 1


def test_stdin_is_the_photo_and_stdout_only_the_svg(photo: Path) -> None:
    result = invoke("run", "-", "-", *QUICK, stdin=photo.read_bytes())
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("<?xml")
    assert result.stdout.endswith("</svg>\n")
    assert "8 paths" in result.stderr
    assert os.listdir(photo.parent) == ["photo.png"]


def test_json_goes_to_stderr_if_stdout_is_the_svg(photo: Path) -> None:
    result = invoke("run", photo, "-", "--json", "-q", *QUICK)
    assert json.loads(result.stderr)["curves"] == 8
    assert result.stdout.endswith("</svg>\n")


def test_svgz_is_the_same_text_gzipped(photo: Path) -> None:
    for name in ("out.svg", "out.svgz"):
        assert invoke("run", photo, photo.with_name(name), "--iterations", "1", "--curves", "1").exit_code == 0
    assert gzip.decompress(photo.with_name("out.svgz").read_bytes()).startswith(b"<?xml")


def test_quiet_says_nothing(photo: Path) -> None:
    result = invoke("run", photo, photo.with_name("out.svg"), "-q", *QUICK)
    assert result.exit_code == 0
    assert result.output == ""


def test_progress_is_plain_lines_if_stderr_is_no_terminal(photo: Path) -> None:
    result = invoke("run", photo, photo.with_name("out.svg"), *QUICK)
    lines = result.stderr.splitlines()
    assert lines[0] == "iteration 1 of 3, 8 paths, 20.00 dB"
    assert lines[-1] == "iteration 3 of 3, 8 paths, 20.00 dB, 0 s left"


def test_frames_are_saved_at_intervals_and_at_the_end(photo: Path) -> None:
    folder = photo.parent / "new" / "frames"
    arguments = ["--iterations", "5", "--save-frames", folder, "--every", "2"]
    assert invoke("run", photo, photo.with_name("out.svg"), *arguments).exit_code == 0
    assert sorted(os.listdir(folder)) == ["frame-000002.png", "frame-000004.png", "frame-000005.png"]
    with Image.open(folder / "frame-000004.png") as frame:
        assert frame.size == (48, 32)


def test_frames_are_drawn_by_the_renderer_of_the_fit(photo: Path) -> None:
    pixels = []
    for name, options in (("exact", []), ("splat", ["--renderer", "splat"]), ("paper", ["--preset", "paper"])):
        torch.manual_seed(1)
        folder = photo.parent / name
        arguments = ["--curves", "8", "--iterations", "1", "--save-frames", folder, *options]
        assert invoke("run", photo, photo.with_name("out.svg"), *arguments).exit_code == 0
        with Image.open(folder / "frame-000001.png") as frame:
            pixels.append(np.asarray(frame.convert("RGB")))
    # The same circles as opaque areas and as Gaussians, which reach farther.
    assert psnr(pixels[1], pixels[2]) > 30
    assert 10 < psnr(pixels[0], pixels[1]) < 30


def test_interrupted_fit_is_saved_and_exits_with_130(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(photo_mode, "fit", functools.partial(stub_fit, interrupted=True))
    out = photo.with_name("out.svg")
    result = invoke("run", photo, out, *QUICK)
    assert result.exit_code == 130
    assert out.read_text(encoding="utf-8").endswith("</svg>\n")
    assert "8 paths" in result.stdout
    assert "interrupted: the best result so far" in result.stdout


def test_interrupt_outside_the_fit_exits_with_130_and_writes_nothing(
    photo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*arguments: object, **_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(photo_mode, "fit", interrupt)
    assert invoke("run", photo, photo.with_name("out.svg")).exit_code == 130
    assert os.listdir(photo.parent) == ["photo.png"]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], FitConfig(mode="photo")),  # what the picture is
        (["--preset", "paper"], make_config("paper")),
        (["--preset", "paper", "--no-interior-gradient"], make_config("paper", interior_gradient=False)),
        (
            ["--preset", "paper", "--lr-points", "0.02", "--flat", "--no-compensate", "--recycle-gap", "0"],
            make_config("paper", lr_points=0.02, one_generation=True, compensate=False, recycle_gap=0),
        ),
    ],
)
def test_options_reach_the_fit_and_the_preset_decides_the_rest(
    photo: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], expected: FitConfig
) -> None:
    seen: list[FitConfig] = []

    def record(target: Any, config: FitConfig, part: Any, **_: Any) -> Any:
        seen.append(config)
        return stub_fit(target, FitConfig(curves=1, iterations=1), part)

    monkeypatch.setattr(photo_mode, "fit", record)
    assert invoke("run", photo, "-", *options).exit_code == 0
    assert seen == [expected]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--curves", "0"], ["--curves must be a whole number from 1 to ", "got 0"]),
        (["--curves", "many"], ["--curves must be a whole number or auto, got 'many'"]),
        (["--fit-size", "0"], ["--fit-size must be", "got 0"]),
        (["--iterations", "-1"], ["--iterations must be"]),
        (["--threads", "0"], ["--threads must be"]),
        (["--time-budget", "0"], ["--time-budget must be"]),
        (["--time-budget", "inf"], ["--time-budget must be a finite", "got inf"]),
        (["--precision", "400"], ["--precision must be", "from 0 to 6", "got 400"]),
        (["--growth", "1.00001"], ["--growth must be 1 or at least 1.01", "got 1.00001"]),
        (["--save-frames", ""], ["--save-frames must be a folder", "got ''", "choose another"]),
        (["--radius-decay", "nan"], ["--radius-decay must", "nan"]),
        (
            ["--preset", "fast"],
            ["--preset must be one of draft, default, best, paper, paper-released, bezier-splatting", "fast"],
        ),
        (["--renderer", "splatt"], ["--renderer must be one of exact, splat, got 'splatt'; did you mean splat?"]),
        (["--preset", "paper", "--renderer", "exact"], ["--path-model must be segments with", "exact", "'sides'"]),
        (["--degree", "13"], ["--degree must be a whole number from 2 to 12", "got 13"]),
        (["--lines", "0"], ["--lines must be", "got 0"]),
        (["--policy", "none"], ["--policy must be one of scaffolding, replacement", "none"]),
        (["--z-order", "depth"], ["--z-order must be one of", "depth"]),
        (["--device", "gpu"], ["--device must be auto or one of cpu", "'gpu'"]),
        (["--device", "cuda:99"], ["--device must be auto or one of cpu", "'cuda:99'"]),
        (["--background", "sea"], ["--background must be", "'sea'"]),
        (["--every", "0"], ["'--every'", "0 is not in the range x>=1"]),
    ],
)
def test_wrong_settings_are_refused_before_anything_is_written(
    photo: Path, options: list[str], words: list[str]
) -> None:
    assert_refused(invoke("run", photo, photo.with_name("out.svg"), *options), *words)
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
def test_other_data_than_an_image_is_refused(tmp_path: Path, data: bytes, word: str, as_stream: bool) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(data)
    result = invoke("run", "-" if as_stream else path, tmp_path / "out.svg", stdin=data)
    assert_refused(result, "IN must be", word)
    assert os.listdir(tmp_path) == ["photo.jpg"]


def test_missing_photo_and_folder_as_photo_are_refused(tmp_path: Path) -> None:
    assert_refused(invoke("run", tmp_path / "none.png", tmp_path / "out.svg"), "IN must be", "none.png")
    assert_refused(invoke("run", tmp_path, tmp_path / "out.svg"), "IN must be", str(tmp_path))
    assert os.listdir(tmp_path) == []


def test_out_is_checked_before_the_photo_is_read(tmp_path: Path) -> None:
    none = tmp_path / "none.png"
    assert_refused(invoke("run", none, tmp_path / "missing" / "out.svg"), "OUT must be in", "missing")
    assert_refused(invoke("run", none, tmp_path), "OUT must name a file")
    rule = f"OUT must end in {listed(tuple(WRITERS))}"
    assert_refused(invoke("run", none, tmp_path / "out.gif"), rule, "out.gif")
    assert os.listdir(tmp_path) == []


def test_the_photo_is_never_overwritten(photo: Path) -> None:
    before = photo.read_bytes()
    assert_refused(invoke("run", photo, photo), "OUT must be another file than IN", "photo.png")
    assert photo.read_bytes() == before


def test_write_protected_folders_are_refused(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    locked = photo.parent / "locked"
    locked.mkdir()
    # The mode of the folder would not stop root.
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != locked)
    assert_refused(invoke("run", photo, locked / "out.svg"), "OUT must be", "locked")
    result = invoke("run", photo, photo.with_name("out.svg"), "--save-frames", locked)
    assert_refused(result, "--save-frames must be a folder you may write to", "locked")


def test_frames_folder_that_is_a_file_is_refused(photo: Path) -> None:
    result = invoke("run", photo, photo.with_name("out.svg"), "--save-frames", photo)
    assert_refused(result, "--save-frames must be", "photo.png")
    assert os.listdir(photo.parent) == ["photo.png"]


def test_out_may_be_a_device(photo: Path) -> None:
    assert invoke("run", photo, os.devnull, *QUICK).exit_code == 0
