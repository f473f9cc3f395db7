"""The bench of quality over bytes: its rows, what it keeps, and the gain between two curves."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import rate
import rate_curves
import rate_methods
import rate_report
from click.testing import CliRunner
from PIL import Image


@pytest.fixture
def photo() -> Image.Image:
    random = np.random.default_rng(0).integers(0, 255, (6, 8, 3)).astype(np.uint8)
    return Image.fromarray(random).resize((64, 48), Image.Resampling.BICUBIC)


@pytest.mark.parametrize("kind", ["JPEG", "WEBP"])
def test_a_raster_file_is_the_best_within_the_bytes(photo: Image.Image, kind: str) -> None:
    small, large = (rate_methods.of_raster(photo, kind, size) for size in (700, 1_500))
    assert small is not None and large is not None
    assert small.bytes <= 700 < large.bytes <= 1_500
    assert large.psnr > small.psnr + 1.0
    assert rate_methods.of_raster(photo, kind, 60) is None


def test_the_gain_is_the_height_between_two_curves() -> None:
    before = [(1_000.0, 20.0), (4_000.0, 24.0), (20_000.0, 27.0)]
    assert rate_report.gain(before, [(size, value + 1.25) for size, value in before]) == pytest.approx(1.25)
    # At four times the bytes for the same decibels; where they overlap, 4 dB a factor of four.
    line = [(4.0**k, 4.0 * k) for k in range(5, 9)]
    assert rate_report.gain(line, [(4.0 * size, value) for size, value in line]) == pytest.approx(-4.0)
    assert np.isnan(rate_report.gain(before, [(30_000.0, 30.0), (40_000.0, 31.0)]))


def test_curves_and_names_stay_within_their_panel(tmp_path: Path) -> None:
    rising = [(5_000.0, 21.3), (50_000.0, 27.2), (150_000.0, 31.9)]
    curves = {name: [(size, value + more) for size, value in rising] for name, more in (("a", 0.0), ("b", 0.1))}
    rate_curves.write_curves([rate_curves.Panel("PSNR", curves, [5_000, 150_000])], tmp_path / "curves.svg")
    text = (tmp_path / "curves.svg").read_text()
    dots = [(float(x), float(y)) for x, y in re.findall(r'<circle cx="(.*?)" cy="(.*?)"', text)]
    assert len(dots) == 6
    assert all(rate_curves.LEFT <= x <= rate_curves.WIDTH - rate_curves.RIGHT for x, _ in dots)
    assert all(rate_curves.TOP <= y <= rate_curves.HEIGHT - rate_curves.BOTTOM for _, y in dots)
    assert dots[0][1] > dots[1][1] > dots[2][1] and dots[3][1] < dots[0][1]
    names = [float(y) for y in re.findall(r'y="([\d.]+)" fill', text)]
    assert len(names) == 2 and names[1] - names[0] >= rate_curves.LABEL_GAP


def test_a_second_run_takes_its_results_from_the_file(
    photo: Image.Image, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    photo.save(tmp_path / "one.png")
    out, picture = tmp_path / "out" / "rate.json", tmp_path / "out" / "curves.svg"
    options = [
        str(tmp_path),
        "--sizes",
        "700,1500",
        "--methods",
        "JPEG,WEBP",
        "--out",
        str(out),
        "--curves",
        str(picture),
    ]
    first = CliRunner().invoke(rate.main, options)
    assert first.exit_code == 0, first.output
    assert picture.read_text().count("<polyline") == 4 and len(json.loads(out.read_text())["points"]) == 4
    monkeypatch.setattr(rate, "of_raster", None)
    second = CliRunner().invoke(rate.main, options)
    assert second.exit_code == 0, second.output
    tables = [[line for line in run.stdout.splitlines() if line.startswith("| ")] for run in (first, second)]
    assert tables[0] == tables[1] and len(tables[0]) == 8
    refused = CliRunner().invoke(rate.main, [*options, "--set", "segments=3"])
    assert refused.exit_code == 2 and "other settings" in refused.output
