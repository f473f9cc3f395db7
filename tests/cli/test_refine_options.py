"""`warpvec refine`: the settings of its fit, those it writes to a file, and refusals. No fit is made."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from commands import assert_refused, invoke, write_photo
from stubs import circles

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.goals.goal import SEARCHED_CURVES_MAX, Goal, make_goal
from warpvec.modes.refine import Refine
from warpvec.modes.request import Request
from warpvec.svg.write import write_svg


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """Return a photo; beside it is a drawing of 8 paths with one decimal."""
    (tmp_path / "drawing.svg").write_text(write_svg(circles(32, 48, 8), 48, 32, precision=1))
    return write_photo(tmp_path)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[FitConfig, Goal]]:
    """Settings and goals of the fits, which are recorded and not made."""
    found: list[tuple[FitConfig, Goal]] = []

    def record(mode: Refine, request: Request) -> None:
        found.append((request.settings, request.goal))
        raise LookupError

    monkeypatch.setattr(Refine, "draw", record)
    return found


def _refine(photo: Path, *options: object):
    return invoke("refine", photo, photo.with_name("out.svg"), "--from", photo.with_name("drawing.svg"), *options)


def test_without_a_goal_it_has_the_iterations_of_a_correction(photo: Path, asked: Any) -> None:
    for options in ([], ["--preset", "draft"], ["--iterations", 30, "--recycle-gap", 7, "--precision", 3]):
        _refine(photo, *options)
    first = FitConfig(mode="photo", curves=8, iterations=500, recycle_gap=0, precision=1)
    draft = make_config("draft", mode="photo", curves=8, iterations=500, recycle_gap=0, precision=1)
    given = FitConfig(mode="photo", curves=8, iterations=30, recycle_gap=7, precision=3)
    assert asked == [(first, Goal()), (draft, Goal()), (given, Goal())]


def test_with_a_goal_the_search_sets_the_iterations(photo: Path, asked: Any) -> None:
    _refine(photo, "--max-bytes", "9k")
    _refine(photo, "--curves", "auto", "--preset", "draft", "--lr-scale", 2, "--iterations", 90)
    kept = {"mode": "photo", "curves": SEARCHED_CURVES_MAX, "recycle_gap": 0, "precision": 1}
    first, second = FitConfig(**kept), make_config("draft", **kept, iterations=90, lr_scale=2.0)
    assert asked == [(first, make_goal(max_bytes=9000)), (second, make_goal(auto=True))]


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--preset", "draft", "--lr-scale", "2"],
        ["--max-bytes", "9k", "--gzip"],
        ["--curves", "20", "--iterations", "40", "--precision", "3", "--recycle-gap", "5"],
        ["--curves", "auto"],
    ],
)
def test_a_written_file_asks_for_the_same(photo: Path, asked: Any, options: list[str]) -> None:
    settings = photo.with_name("settings.toml")
    _refine(photo, *options, "--write-config", settings)
    _refine(photo, "--config", settings)
    assert len(asked) == 2
    assert asked[0] == asked[1]
    stated = tomllib.loads(settings.read_text())
    for name in ("curves", "iterations", "precision", "recycle_gap"):
        assert (name in stated) is (f"--{name.replace('_', '-')}" in options)
    assert "segments" not in stated


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--segments", "7"], ["--segments must be 4, as in the SVG, got 7; leave it out"]),
        (["--iterations", "-1"], ["--iterations"]),
        (["--iterations", "0", "--max-bytes", "9k"], ["--iterations must be", "got 0"]),
        (["--iterations", "0", "--curves", "20"], ["--curves must not be given with 0 iterations; leave it out"]),
        (["--iterations", "0", "--colors", "4"], ["--colors must not be given with 0 iterations"]),
        (["--iterations", "0", "--gradients", "2"], ["--gradients must not be given with 0 iterations"]),
        (["--max-bytes", "9k", "--policy", "replacement"], ["--policy must be scaffolding to"]),
        (["--preset", "paper"], ["--path-model must be segments", "got 'sides'", "another preset"]),
        (["--preset", "bezier-splatting", "--path-model", "segments"], ["--policy must be scaffolding"]),
        (["--gzip"], ["--gzip must come with --max-bytes"]),
        (["--device", "abacus"], ["--device must be"]),
    ],
)
def test_what_it_cannot_do_is_refused_and_nothing_written(
    photo: Path, asked: Any, options: list[str], words: list[str]
) -> None:
    assert_refused(_refine(photo, *options), *words)
    assert_refused(_refine(photo, *options, "--write-config", photo.with_name("a.toml")), *words)
    assert not asked
    assert sorted(path.name for path in photo.parent.iterdir()) == ["drawing.svg", "photo.png"]


def test_the_segments_of_the_drawing_may_be_named(photo: Path, asked: Any) -> None:
    _refine(photo, "--segments", 4)
    assert asked[0][0].segments == 4


def test_a_drawing_that_is_missing_is_that_of_from(photo: Path) -> None:
    result = invoke("refine", photo, photo.with_name("out.svg"), "--from", photo.with_name("none.svg"))
    assert_refused(result, "error: --from must be an SVG file", "none.svg")


@pytest.mark.parametrize(
    "options",
    [["--mode", "flat"], ["--detail", "1"], ["--cutout"], ["--strokes", "off"], ["--threshold", "9"], ["--as-is"]],
)
def test_the_help_leaves_out_what_is_refused(photo: Path, options: list[str]) -> None:
    assert_refused(_refine(photo, *options), f"{options[0]} must ")
    text = invoke("refine", "--help-all").stdout
    assert f"{options[0]} " not in text
    assert f"  {options[0]}" in invoke("run", "--help-all").stdout


def test_the_help_names_the_settings_that_are_not_used() -> None:
    text = " ".join(invoke("refine", "--help-all").stdout.split())
    assert "--one-generation, --initial-curves, --initial-radius and --radius-decay are never used" in text
