"""The options for flat art on the command line: the summary, options that go together, and files for print."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from commands import QUICK, assert_refused, invoke, write_photo
from PIL import Image, ImageDraw
from svg_files import skip_without_cairo

import warpvec


@pytest.fixture
def icon(tmp_path: Path) -> Path:
    """Return the path of a disc in a square on white, 48 x 32."""
    big = Image.new("RGB", (192, 128), "white")
    pen = ImageDraw.Draw(big)
    pen.rectangle((20, 20, 107, 107), fill="navy")
    pen.ellipse((40, 40, 87, 87), fill="gold")
    path = tmp_path / "icon.png"
    big.resize((48, 32), Image.Resampling.BOX).save(path)
    return path


def test_the_summary_says_the_mode_and_how_to_override_it(icon: Path) -> None:
    out = icon.with_suffix(".svg")
    text = invoke("run", icon).stdout
    assert "mode: flat art (mostly 3 colours, " in text
    assert "; --mode photo overrides" in text
    assert 'gold #ffd700"' in out.read_text()
    assert "mode:" not in invoke("run", icon, "--mode", "photo", *QUICK).stdout
    photo = write_photo(icon.parent)
    assert "--mode flat overrides" in invoke("run", photo, *QUICK).stdout
    assert "the preset best is for photos" in invoke("run", icon, "--preset", "best").stdout
    assert "is for photos" not in text + invoke("run", photo, "--preset", "draft", *QUICK).stdout
    report = json.loads(invoke("run", icon, "--json", "--size", "3in").stdout)
    assert (report["mode"], report["curves"]) == ("flat", 2)
    assert 'width="3in" height="2in"' in out.read_text()


def test_the_summary_says_which_options_decide_the_mode(icon: Path) -> None:
    def line(*options: str) -> str:
        lines = invoke("run", icon, *QUICK, *options).stdout.splitlines()
        return next((each for each in lines if each.startswith("mode:")), "")

    assert line("--lod", "--lr-final", "0.1") == "mode: photo (because of --lod, --lr-final); else the picture decides"
    assert line("--cutout").startswith("mode: flat art (because of --cutout); ")
    assert line("--mode", "photo", "--lod") == ""
    assert line("--gradients", "0").endswith("; --mode photo overrides")
    assert line("--gradients", "auto").endswith("; --mode photo overrides")


def test_checkpoints_mean_a_photo(icon: Path) -> None:
    saved = icon.with_name("fit.npz")
    result = invoke("run", icon, "--checkpoint", saved, "--every", "2", *QUICK)
    assert result.exit_code == 0
    assert "mode: photo (because of --checkpoint); else the picture decides" in result.stdout
    assert_refused(
        invoke("run", icon, "--mode", "flat", "--checkpoint", saved), "--checkpoint must not be given", "flat"
    )
    assert_refused(invoke("run", icon, "--cutout", "--resume", saved), "--resume must not be given", "--mode photo")
    assert invoke("run", icon, "--resume", saved, "-q").exit_code == 0


def test_settings_of_another_mode_are_refused_in_one_line(icon: Path) -> None:
    assert_refused(invoke("run", icon, "--mode", "flat", "--lod"), "--lod must not be given in the mode flat")
    assert_refused(invoke("run", icon, "--mode", "photo", "--cutout"), "--cutout must not be given in the mode photo")
    rule = "--detail must not be given in the mode photo, which does not use it, got 0.5; leave it out"
    assert_refused(invoke("run", icon, "--mode", "photo", "--detail", "0.5"), rule)
    assert_refused(invoke("run", icon, "--threshold", "300"), "--threshold must be a whole number from 0 to 255")
    assert_refused(invoke("run", icon, "--size", "9 feet"), "--size must be a width above 0 in mm, cm")
    drawing = icon.with_suffix(".svg")
    assert invoke("run", icon, "-q").exit_code == 0
    refused = invoke("refine", icon, drawing, "--from", drawing, "--mode", "flat")
    assert_refused(refused, "--mode must be photo to refine a drawing, got 'flat'")


def test_the_page_and_frames_of_flat_art_are_written(icon: Path) -> None:
    page, frames = icon.with_suffix(".html"), icon.with_name("frames")
    assert invoke("run", icon, "--report", page, "--save-frames", frames, "--every", "5", "-q").exit_code == 0
    assert "gold #ffd700" in page.read_text()
    assert len(list(frames.iterdir())) > 1


@pytest.mark.parametrize(("mode", "frames_min"), [("flat", 8), ("mono", 1)])
def test_a_video_of_flat_art_ends_with_its_drawing(icon: Path, mode: str, frames_min: int) -> None:
    video, drawing = icon.with_name("fit.gif"), icon.with_name("drawing.png")
    assert invoke("run", icon, "--mode", mode, "--video", video, "-q").exit_code == 0
    warpvec.vectorize(icon, mode=mode).save(drawing)
    with Image.open(video) as film, Image.open(drawing) as expected:
        count = getattr(film, "n_frames", 1)
        film.seek(count - 1)
        last, shown = (np.asarray(image.convert("RGB")).astype(float) for image in (film, expected))
    assert count >= frames_min
    assert np.abs(last - shown).mean() < 2.0


def test_a_file_for_print_is_the_only_file(icon: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    skip_without_cairo()
    folder = icon.parent / "print"
    folder.mkdir()
    result = invoke("run", icon, folder / "icon.pdf", "--size", "90mm")
    assert "bytes as SVG" in result.stdout
    assert (folder / "icon.pdf").read_bytes().startswith(b"%PDF")
    assert [path.name for path in folder.iterdir()] == ["icon.pdf"]
    monkeypatch.setitem(sys.modules, "cairosvg", None)
    refused = invoke("run", icon, folder / "icon.eps")
    assert_refused(refused, "OUT must end in .svg unless CairoSVG is installed", "pip install 'warpvec[print]'")


@pytest.mark.slow
def test_a_batch_chooses_for_each_image(icon: Path) -> None:
    source, target = icon.parent / "in", icon.parent / "out"
    source.mkdir()
    icon.rename(source / "icon.png")
    write_photo(source)
    assert invoke("batch", source, target, "--jobs", "1", "-q", *QUICK).exit_code == 0
    records = [json.loads(line) for line in (target / "batch.jsonl").read_text().splitlines()]
    assert {record["input"]: record["mode"] for record in records} == {"icon.png": "flat", "photo.png": "photo"}


def test_the_summary_counts_what_is_left_out(tmp_path: Path) -> None:
    ink = np.full((64, 64), 255, np.uint8)
    ink[10:40, 10:40] = 0
    ink[45:62:4, 46:62:4] = 0
    Image.fromarray(ink).save(tmp_path / "scan.png")
    result = invoke("run", tmp_path / "scan.png", "--mode", "mono")
    assert "20 specks removed" in result.stdout


def test_the_summary_lists_the_colours_and_the_size_in_millimetres(tmp_path: Path) -> None:
    image = np.full((48, 64, 3), (255, 255, 255), np.uint8)
    image[8:24, 8:24], image[28:40, 30:50] = (200, 0, 0), (0, 0, 200)
    Image.fromarray(image).save(tmp_path / "flags.png")
    result = invoke("run", tmp_path / "flags.png", "--palette", "white,#c80000,#0000c8,lime", "--size", "2in")
    assert "gzipped; 50.8 x 38.1 mm" in result.stdout
    assert "3 colours: #fff, #c80000, #0000c8" in result.stdout
    assert "of these 2 rectangles; " in result.stdout
    assert "shape" not in result.stdout
