"""Test the benchmarks of flat art: counts, corners, alpha, the table and the sheet. No test asserts a time."""

from __future__ import annotations

import json
from pathlib import Path

import cutout
import flat
import mono
import numpy as np
import pytest
from click.testing import CliRunner
from flat_corners import corner_distances, seen_corners
from flat_counts import count
from flat_methods import Traced
from flat_originals import Original, Svgo
from flat_sheet import Sheet
from mono_originals import DRAWINGS, drawing, scanned
from PIL import Image

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="64" height="48">'
LOGO = f'{HEAD}<path d="M8,8H40V40H8Z" fill="#c00"/><circle cx="44" cy="24" r="12" fill="#00c"/></svg>'


def _measured(original: str, tracing: str, kind: str = "png") -> flat.Row:
    traced = Traced(tracing, None, 0.0)
    return flat.measure(Original("logo", original), "none", 64, kind, traced, Svgo(""))


def test_counts_follow_use_and_close_fills() -> None:
    svg = f"""{HEAD}<defs><linearGradient id="g"><stop stop-color="#f00"/><stop offset="1" stop-color="#00f"/>
    </linearGradient><g id="two"><rect width="4" height="4"/><circle r="3" fill="#000000"/></g></defs>
    <use xlink:href="#two"/><use xlink:href="#two" x="9"/><path d="M0,0L9,0L9,9" fill="url(#g)"/>
    <line x2="9" y2="9" stroke="#0a0"/><path d="M0,0H5" fill="none"/></svg>"""
    # Twice a rectangle and a circle, a triangle, and a stroked line.
    assert count(svg) == (6, 2 * (4 + 4) + 3 + 1, 2, 2)


def test_original_is_its_own_perfect_tracing() -> None:
    row = _measured(LOGO, LOGO)
    assert (row.psnr, row.psnr_4x, row.ssim) == (99.0, 99.0, pytest.approx(1.0))
    assert (row.paths, row.segments, row.colors, row.alpha) == (1.0, 1.0, 1.0, 0)
    assert row.corner == pytest.approx(0.0, abs=1e-6)
    assert row.bytes is None


def test_curve_that_is_right_in_its_pixels_only_loses_at_four_times_the_size() -> None:
    # Half a pixel of grey looks the same as half a pixel of ink.
    edge = f'{HEAD}<path d="M0,0H20.5V48H0Z"/></svg>'
    pixels = f'{HEAD}<path d="M0,0H20V48H0Z"/><path d="M20,0H21V48H20Z" fill="#808080"/></svg>'
    row = _measured(edge, pixels)
    assert row.psnr is not None
    assert row.psnr > 50 > 35 > row.psnr_4x


def test_corners_that_others_cover_do_not_count() -> None:
    # The circle covers the middle of the right side, but none of the four corners.
    assert len(seen_corners(LOGO, 64, 48)) == 4
    covered = LOGO.replace("</svg>", '<circle cx="40" cy="40" r="7" fill="#0c0"/></svg>')
    assert len(seen_corners(covered, 64, 48)) == 3


def test_corner_distance_is_that_of_the_worst_corner() -> None:
    moved = LOGO.replace("M8,8H40V40H8Z", "M8,8H40V40L8,37Z")
    distances = corner_distances(seen_corners(LOGO, 64, 48), moved, 64, 48)
    assert sorted(distances) == pytest.approx([0, 0, 0, 3], abs=0.05)


def test_grey_in_a_hole_is_an_error_of_alpha() -> None:
    grey = LOGO.replace("</svg>", '<rect x="52" y="40" width="8" height="8" opacity=".5"/></svg>')
    assert _measured(LOGO, grey).alpha == pytest.approx(128, abs=1)
    assert _measured(LOGO, grey, "jpeg").alpha is None


def test_table_has_a_row_for_each_picture_and_says_what_is_missing(tmp_path: Path) -> None:
    (tmp_path / "logo.svg").write_text(LOGO)
    arguments = [str(tmp_path), "--sizes", "16,32", "--methods", "bicubic", "--jpeg", "--svgo", "no-such-svgo"]
    done = CliRunner().invoke(flat.main, arguments, catch_exceptions=False)
    assert "svgo: skipped" in done.stderr
    rows = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))["rows"]
    assert [(row["size"], row["kind"]) for row in rows] == [(16, "png"), (16, "jpeg"), (32, "png"), (32, "jpeg")]
    assert done.stdout.count("| bicubic |") == 4 + 4


def test_unknown_method_is_refused(tmp_path: Path) -> None:
    done = CliRunner().invoke(flat.main, [str(tmp_path), "--methods", "magic"])
    assert done.exit_code == 2
    assert "magic" in done.output


def test_sheet_shows_nodes_and_errors(tmp_path: Path) -> None:
    sheet = Sheet(128)
    sheet.add(Original("logo", LOGO), 64, LOGO.replace('r="12"', 'r="10"'), "logo")
    sheet.save(tmp_path / "sheet.png")
    pixels = np.asarray(Image.open(tmp_path / "sheet.png"))
    first, ours, nodes, error = (pixels[18 : 18 + 96, k * 136 : k * 136 + 128].astype(int) for k in range(4))
    assert np.abs(first - ours).max() > 100
    assert (np.abs(nodes - [0xEE, 0x11, 0x11]).max(2) < 8).sum() >= 4 * 36  # the corners of the square
    assert (error < 128).any()


def test_scans_are_noisy_grey_pictures_of_the_drawings() -> None:
    for seed, name in enumerate(DRAWINGS):
        coverage = mono.ink(drawing(name), 1)
        assert 0.03 < coverage.mean() < 0.6, name
        scan = scanned(coverage, seed)
        assert 5 < scan[coverage == 0].astype(float).std() + 4 < 20, name
        assert mono.iou(np.clip((236.0 - scan) / 208.0, 0, 1), coverage) > 0.7, name


def test_cut_drawings_cover_what_the_stacked_one_did() -> None:
    cells = cutout.measure(Original("logo", LOGO), 64)
    assert cells[1:3] == ["2", "2"]
    assert float(cells[8]) == pytest.approx(float(cells[9]), rel=2e-3)
