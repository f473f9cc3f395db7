"""Test the commands for the paper's tables and figures with a tiny run of each."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import paper
import paper_fits
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from warpvec.config.presets import make_config

# Few samples, so that a fit is fast.
QUICK = ("--set", "samples=6", "--set", "lines=2", "--set", "threads=1")
RUNS = {
    "table1": ("--curves", "4,6"),
    "table2": ("--curves", "4", "--presets", "paper"),
    "interior": ("--curves", "4"),
    "hierarchy": ("--curves", "4"),
    "table3": ("--curves", "20", "--images", "kodim07", "--iterations", "3,4"),
    "trajectory": ("--curves", "4", "--every", "2"),
    "lod": ("--curves", "4,20"),
    "layers": ("--curves", "20"),
    "compare": ("--curves", "4", "--images", "kodim07"),
}
"""Command -> its arguments after the folder and the iterations."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two smooth photos of 48 x 32 pixels."""
    path = tmp_path_factory.mktemp("photos")
    x, y = np.meshgrid(np.linspace(0, 1, 48), np.linspace(0, 1, 32))
    for name, channels in {"kodim01": (x, y, x * y), "kodim07": (x, 1 - x, (x - 0.5) ** 2 + y**2)}.items():
        Image.fromarray((255 * np.stack(channels, -1).clip(0, 1)).astype(np.uint8)).save(path / f"{name}.png")
    return path


def run(folder: Path, out: Path, name: str, *arguments: object, code: int = 0) -> Result:
    """Run a command with the arguments of ``RUNS``, followed by ``arguments``."""
    given = RUNS[name] if "--iterations" in RUNS[name] else (*RUNS[name], "--iterations", "3")
    line = [name, folder, "--out", out / f"{name}.csv", *given, *QUICK, *arguments]
    result = CliRunner().invoke(paper.main, [str(argument) for argument in line], catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result


@pytest.fixture(scope="module")
def runs(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The first run of each command, and the folder of all results under "out"."""
    out = tmp_path_factory.mktemp("results")
    return {"out": out, **{name: run(folder, out, name) for name in RUNS}}


def rows_of(out: Path, name: str) -> list[dict[str, str]]:
    with (out / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


# Every command


# Number of fits of each command; two variants with equal settings are one fit.
FIT_COUNTS = {
    "table1": 2 * 3 * 2, "table2": 2, "interior": 2, "hierarchy": 4, "table3": 2 * (5 + 4 + 4),
    "trajectory": 2, "lod": 2, "layers": 1, "compare": 4,
}  # fmt: skip


@pytest.mark.parametrize("name", RUNS)
def test_every_fit_is_a_row_and_is_made_once(
    name: str, folder: Path, runs: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = rows_of(runs["out"], name)
    assert len({row["key"] for row in rows}) == len(rows) == FIT_COUNTS[name]
    monkeypatch.setattr(paper_fits, "fit_photo", lambda *_, **__: pytest.fail("fitted again"))
    again = run(folder, runs["out"], name)
    table, _, machine = again.stdout.partition("\n\ncpu")
    assert table == runs[name].stdout.partition("\n\ncpu")[0]
    assert rows_of(runs["out"], name) == rows
    assert machine


@pytest.mark.parametrize("name", RUNS)
def test_the_table_is_written_beside_the_csv(name: str, runs: dict[str, Any]) -> None:
    table, _, machine = (runs["out"] / f"{name}.md").read_text().partition("\n\ncpu")
    assert runs[name].stdout.startswith(table)
    assert table.startswith("| " if name != "table3" else "(a) ")
    assert "source " in machine


@pytest.mark.parametrize(
    "name",
    [
        "interior-kodim07-4.png", "hierarchy-kodim07-4.png", "lod-kodim07.png", "layers-kodim07-20.png",
        "trajectory-kodim01-4.png", "trajectory-kodim01-4.webp", "trajectory-kodim01-4-history.csv",
    ],
)  # fmt: skip
def test_figures_are_written(name: str, runs: dict[str, Any]) -> None:
    assert (runs["out"] / name).stat().st_size > 100


def test_equal_settings_give_equal_numbers(folder: Path, runs: dict[str, Any], tmp_path: Path) -> None:
    run(folder, tmp_path, "interior")
    rows = [[{**row, "seconds": ""} for row in rows_of(out, "interior")] for out in (tmp_path, runs["out"])]
    assert rows[0] == rows[1]


# Usage


@pytest.mark.parametrize(
    ("name", "arguments", "message"),
    [
        ("interior", ("--images", "kodim99"), "got 'kodim99'; choose from kodim01, kodim07"),
        ("interior", ("--iterations", "3,4"), "must be one number"),
        ("table3", ("--iterations", "3,4,5"), "must be one or two numbers"),
        ("table3", ("--curves", "3,4"), "--curves must be one number"),
        ("table3", ("--panels", "lr,depth"), "--panels must be among lr, radius, gap, got depth"),
        ("interior", ("--set", "samples=1"), "samples must be"),
        ("table1", ("--presets", "papers"), "preset must be one of"),
    ],
)
def test_wrong_usage_is_an_error(
    name: str, arguments: tuple[str, ...], message: str, folder: Path, tmp_path: Path
) -> None:
    assert message in " ".join(run(folder, tmp_path, name, *arguments, code=2).stderr.split())
    assert not list(tmp_path.glob("*.md"))


# The fits of a command


def settings_of(row: dict[str, str]) -> dict[str, Any]:
    settings: dict[str, Any] = json.loads(row["settings"])
    return settings


def test_ablations_change_one_thing(runs: dict[str, Any]) -> None:
    off, on = map(settings_of, rows_of(runs["out"], "interior"))
    assert [off.pop("interior_gradient"), on.pop("interior_gradient")] == [False, True]
    assert off == on
    found = [
        (row["flat"], row["lr_scale"], row.get("z_order"))
        for row in map(settings_of, rows_of(runs["out"], "hierarchy"))
    ]
    assert found == [(True, 0.02, "area"), (True, 1.0, "area"), (False, 0.02, None), (False, 1.0, None)]


def test_flat_fits_use_the_given_order(folder: Path, tmp_path: Path) -> None:
    run(folder, tmp_path, "hierarchy", "--set", "z_order=creation")
    assert {settings_of(row)["z_order"] for row in rows_of(tmp_path, "hierarchy")} == {"creation"}


def test_sweeps_change_one_setting_of_the_preset(runs: dict[str, Any]) -> None:
    rows = [settings_of(row) for row in rows_of(runs["out"], "table3")]
    values = {name: sorted({row[name] for row in rows if name in row}) for name in ("radius_decay", "inflation_gap")}
    assert sorted({row["lr_scale"] for row in rows if "lr_scale" in row}) == [0.02, 0.1, 0.2, 1.0, 2.0]
    # The paper's own values are fits of the first panel already.
    assert values == {"radius_decay": [0.1, 0.25, 0.75, 1.0], "inflation_gap": [25, 50, 200, 400]}
    preset = make_config("paper")
    defaults = {sweep.setting: sweep.default for sweep in paper.TABLE_3.values()}
    assert defaults == {"lr_scale": paper.LR_REFERENCE, "radius_decay": preset.radius_decay, "inflation_gap": 100}
    assert (preset.lr_scale, preset.inflation_gap) == (1.0, 100)


def test_each_preset_also_gets_the_time_of_the_other(runs: dict[str, Any]) -> None:
    own, exact, default, soft = rows_of(runs["out"], "compare")
    assert [row["preset"] for row in (own, exact, default, soft)] == ["paper", "default", "default", "paper"]
    assert settings_of(exact)["time_budget"] == float(own["seconds"])
    assert settings_of(soft)["time_budget"] == float(default["seconds"])
    assert settings_of(exact)["iterations"] == 1_000_000
    assert (own["iterations"], default["iterations"]) == ("3", "3")


@pytest.mark.parametrize("name", ["interior", "hierarchy"])
def test_ablations_show_the_papers_values(name: str, runs: dict[str, Any]) -> None:
    cells = [line.split(" | ")[-3] for line in runs[name].stdout.splitlines() if line.startswith("| kodim07")]
    assert cells == {"interior": ["23.46", "28.08"], "hierarchy": ["24.47", "19.19", "-", "24.68"]}[name]


def test_without_weights_the_lpips_column_has_a_note(runs: dict[str, Any]) -> None:
    message = "weights not found: give --lpips-weights PATH"
    lines = [line for line in runs["table1"].stdout.splitlines() if line.startswith(("| paper", "| default"))]
    assert [line.count(message) for line in lines] == [2] * 4
    assert {row["lpips_weights"] for row in rows_of(runs["out"], "table1")} == {message}
    assert {row["soft_lpips"] for row in rows_of(runs["out"], "table1")} == {""}


# Levels, layers, frames


def test_the_last_level_is_the_whole_fit(runs: dict[str, Any]) -> None:
    last = next(row for row in rows_of(runs["out"], "lod") if row["curves"] == "20")
    table = runs["lod"].stdout.partition("first generations")[2]
    assert f"| kodim07 | 1 | 20 | {float(last['soft_psnr']):.2f} |" in table
    assert "| kodim07 | 0 | 16 |" in table


def test_frames_have_equal_iterations_and_end_in_the_fit(folder: Path, runs: dict[str, Any]) -> None:
    fits = paper_fits.Fits(runs["out"] / "trajectory.csv")
    photo = paper_fits.Photo(folder / "kodim01.png")
    for row in rows_of(runs["out"], "trajectory"):
        case = paper_fits.Case(photo, row["preset"], {**settings_of(row), "curves": 4}, 2)
        frames = fits.frames(case)
        assert (case.key, list(frames)) == (row["key"], [1, 2, 3])
        assert np.array_equal(frames[3], fits.soft(case))
        assert not np.array_equal(frames[1], frames[3])
    with Image.open(runs["out"] / "trajectory-kodim01-4.webp") as animation:
        assert animation.n_frames == 3
    with (runs["out"] / "trajectory-kodim01-4-history.csv").open() as file:
        entries = list(csv.DictReader(file))
    assert [(entry["preset"], entry["iteration"]) for entry in entries] == [(p, "3") for p in paper.RIVALS]


def test_without_matplotlib_only_the_plot_is_missing(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    result = run(folder, tmp_path, "trajectory")
    assert "-plot.png was left out, it needs matplotlib; pip install 'warpvec[paper]'" in result.stderr
    assert not list(tmp_path.glob("*-plot.png"))
    assert (tmp_path / "trajectory.md").exists()


def test_wrong_weights_are_refused_before_any_fit(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "w.txt").write_text("no weights")
    given = ("--lpips-weights", tmp_path / "w.txt")
    assert "must be a state dict" in " ".join(run(folder, tmp_path, "table2", *given, code=2).stderr.split())
    assert not (tmp_path / "table2.csv").exists()
