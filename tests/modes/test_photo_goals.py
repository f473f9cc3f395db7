"""Goals met by real fits of small pictures: bytes, PSNR, both, and as many curves as pay."""

from __future__ import annotations

import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import assert_refused, invoke
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import warpvec
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw

QUICK: dict[str, Any] = {"iterations": 60, "initial_curves": 8, "inflation_gap": 4, "device": "cpu", "threads": 2}
OPTIONS = [f"--{name.replace('_', '-')}={value}" for name, value in QUICK.items()]


@pytest.fixture(scope="module")
def photo() -> NDArray[np.uint8]:
    """A cat, 72 x 48."""
    data = pytest.importorskip("skimage.data")
    image = Image.fromarray(data.chelsea()[20:260, 60:420])
    return np.asarray(image.resize((72, 48), Image.Resampling.LANCZOS))


def _facts(result: warpvec.Result) -> dict[str, Any]:
    assert result.goal_facts is not None
    return result.goal_facts


@pytest.mark.parametrize("size", [5_000, 12_000])
def test_bytes_are_used_and_not_exceeded(photo: NDArray[np.uint8], size: int) -> None:
    result = warpvec.vectorize(photo, max_bytes=size, **QUICK)
    assert 0.9 * size <= len(result.svg().encode()) <= size
    assert _facts(result)["bytes"] == result.metrics["bytes"] == len(result.svg().encode())


def test_more_bytes_are_more_decibels(photo: NDArray[np.uint8]) -> None:
    few, many = (warpvec.vectorize(photo, max_bytes=size, **QUICK) for size in (4_000, 12_000))
    assert many.metrics["psnr"] > few.metrics["psnr"] + 1.5


def test_the_decibels_are_those_of_the_file(photo: NDArray[np.uint8]) -> None:
    result = warpvec.vectorize(photo, target_psnr=22.0, **QUICK)
    quality = psnr(draw(result.svg()), photo)
    assert 22.0 <= quality <= 22.3
    assert _facts(result)["met"]
    assert _facts(result)["trials"][-1]["psnr"] == pytest.approx(quality)


def test_a_psnr_costs_hardly_more_than_one_fit_of_its_result(photo: NDArray[np.uint8]) -> None:
    iterations = 300
    result = warpvec.vectorize(photo, target_psnr=30.0, **{**QUICK, "iterations": iterations})
    assert 30.0 <= result.file_psnr <= 30.3
    spans = zip(result.history, [{"iteration": 0}, *result.history], strict=False)
    steps = sum(entry["curves"] * (entry["iteration"] - before["iteration"]) for entry, before in spans)
    assert steps / (len(result.scene) * iterations) <= 1.5


def test_decibels_out_of_reach_end_with_the_most_curves(photo: NDArray[np.uint8]) -> None:
    result = warpvec.vectorize(photo, 40, target_psnr=60.0, **QUICK)
    assert not _facts(result)["met"]
    assert 30 < result.metrics["curves"] <= 40


@pytest.mark.parametrize(("size", "target", "met"), [(4_000, 30.0, False), (30_000, 22.0, True)])
def test_the_nearer_of_two_goals_ends_the_search(photo: NDArray[np.uint8], size: int, target: float, met: bool) -> None:
    result = warpvec.vectorize(photo, max_bytes=size, target_psnr=target, minify=False, **QUICK)
    assert _facts(result)["met"] is met
    assert len(result.svg().encode()) <= size
    if met:
        assert target <= result.metrics["psnr"] <= target + 0.3
    else:
        assert len(result.svg().encode()) >= 0.9 * size


@pytest.mark.slow
def test_as_many_curves_as_pay(photo: NDArray[np.uint8]) -> None:
    flat = np.full_like(photo, 90)
    few, many = (warpvec.vectorize(image, "auto", **QUICK) for image in (flat, photo))
    assert few.metrics["curves"] <= 64 < many.metrics["curves"]
    assert len(_facts(few)["trials"]) == 2  # a probe, and the fit


@pytest.fixture(scope="module")
def emoji() -> Image.Image:
    """A face of four flat colours with soft edges, 96 x 96."""
    image = Image.new("RGB", (384, 384), "white")
    draw = ImageDraw.Draw(image)
    draw.ellipse((24, 24, 360, 360), fill=(252, 194, 27))
    for x in (120, 216):
        draw.ellipse((x, 110, x + 48, 180), fill=(47, 47, 47))
    draw.chord((100, 200, 284, 310), 0, 180, fill=(226, 36, 60))
    return image.resize((96, 96), Image.Resampling.LANCZOS)


@pytest.mark.slow
def test_a_picture_of_few_areas_takes_few_curves(emoji: Image.Image) -> None:
    settings = {**QUICK, "iterations": 400}
    auto = warpvec.vectorize(emoji, "auto", **settings)
    assert auto.metrics["curves"] <= 256  # of 2,048
    assert auto.metrics["psnr"] > 32
    result = warpvec.vectorize(emoji, target_psnr=28.0, **settings)
    assert result.metrics["psnr"] >= 28.0
    assert result.metrics["curves"] <= 20  # below the 64 of the probe
    misses = [trial["curves"] for trial in _facts(result)["trials"] if trial["psnr"] < 28.0]
    assert result.metrics["psnr"] <= 28.25 or result.metrics["curves"] <= 1.04 * max(misses) + 2


@pytest.mark.parametrize("goal", [{"max_bytes": 5_000}, {"target_psnr": 30.0}])
def test_a_photo_of_one_colour_ends_at_once(photo: NDArray[np.uint8], goal: dict[str, Any]) -> None:
    result = warpvec.vectorize(np.full_like(photo, 90), **goal, **QUICK)
    assert len(result.svg().encode()) < 5_000
    assert result.metrics["psnr"] > 40


@pytest.mark.parametrize("settings", [{"colors": 4}, {"opacity": "opaque"}, {"min_area": 6.0}])
def test_a_file_size_is_met_with_other_settings(photo: NDArray[np.uint8], settings: dict[str, Any]) -> None:
    result = warpvec.vectorize(photo, max_bytes=5_000, **QUICK, **settings)
    assert 0.9 * 5_000 <= len(result.svg().encode()) <= 5_000
    if "colors" in settings:
        assert len(set(re.findall(r'fill="(.*?)"', result.svg()))) <= 4


# on the command line


@pytest.fixture
def file(photo: NDArray[np.uint8], tmp_path: Path) -> Path:
    Image.fromarray(photo).save(tmp_path / "cat.png")
    return tmp_path / "cat.png"


def test_run_reports_the_size_and_the_fits_of_the_search(file: Path) -> None:
    out = file.with_name("out.svg")
    result = invoke("run", file, out, "--max-bytes", "6k", "--time-budget", "60", *OPTIONS)
    assert result.exit_code == 0, result.output
    size = out.stat().st_size
    assert 5_400 <= size <= 6_000
    assert f"{size:,} bytes" in result.stdout
    assert f"goal: {size:,} of 6,000 bytes" in result.stdout


def test_run_counts_the_bytes_of_the_gzipped_file(file: Path) -> None:
    out = file.with_name("out.svgz")
    result = invoke("run", file, out, "--max-bytes", "4k", "--json", "-q", *OPTIONS)
    assert result.exit_code == 0, result.output
    facts = json.loads(result.stdout)["goal"]
    assert facts["gzip"] and facts["bytes"] == out.stat().st_size
    assert 3_600 <= out.stat().st_size <= 4_000
    assert len(gzip.decompress(out.read_bytes())) > 4_000


def test_a_perfect_file_is_reported_as_json_too(tmp_path: Path) -> None:
    Image.new("RGB", (16, 16), (0, 0, 0)).save(tmp_path / "black.png")
    arguments = ["--target-psnr", "30", "--json", "-q", "--backdrop", "white", "--palette", "#000", *OPTIONS]
    result = invoke("run", tmp_path / "black.png", tmp_path / "out.svg", *arguments)
    assert result.exit_code == 0, result.output
    metrics = json.loads(result.stdout)
    assert metrics["psnr"] is None and metrics["goal"]["trials"][-1]["psnr"] is None
    assert metrics["goal"]["met"]


def test_a_file_size_too_small_for_one_path_is_refused(file: Path) -> None:
    out = file.with_name("out.svg")
    assert_refused(invoke("run", file, out, "--max-bytes", "200", "-q", *OPTIONS), "is too small for one path")
    assert not out.exists()


def test_frames_of_all_fits_are_kept(file: Path) -> None:
    folder = file.with_name("frames")
    result = invoke("run", file, file.with_name("out.svg"), "--max-bytes", "5k", "--json", "-q", *OPTIONS,
                    "--save-frames", folder, "--every", "15")  # fmt: skip
    iterations = json.loads(result.stdout)["iterations"]
    numbers = sorted(int(path.stem.removeprefix("frame-")) for path in folder.iterdir())
    assert numbers == list(range(15, iterations + 1, 15))


def test_the_page_is_written_beside_the_file(file: Path) -> None:
    pytest.importorskip("warpvec.viewer.page")
    page, out = file.with_name("page.html"), file.with_name("out.svg")
    result = invoke("run", file, out, "--curves", "8", "--report", page, "-q", *OPTIONS)
    assert result.exit_code == 0, result.output
    text = page.read_text(encoding="utf-8")
    assert text.lstrip().lower().startswith("<!doctype html>")
    missing = file.with_name("missing") / "page.html"
    assert_refused(invoke("run", file, out, "--report", missing), "--report must be in an existing folder")
