"""Test that the tables of bench_goals agree with the files. No test asserts a time."""

from __future__ import annotations

from typing import Any

import bench_fit
import bench_goals
import pytest
from click.testing import CliRunner
from commands import invoke, write_photo

SHORT = ["--option=--iterations=12", "--option=--inflation-gap=2", "--option=--threads=1"]


def _run_here(arguments: list[object]) -> Any:
    """Run the command in this process, which is faster than `run_child`."""
    result = invoke(*arguments[2:])
    assert result.exit_code == 0, result.output
    return bench_fit.Run(1.0, 1.0, 1, result.stdout)


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The output of bench_goals on a noisy photo."""
    path = write_photo(tmp_path_factory.mktemp("photos"), "noise.png", 24, 40, seed=0)
    sizes = ["--max-bytes", "9k", "--target-psnr", "7", "--colors", "3", "--curves", "12", "--lod-curves", "32"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench_goals, "run_child", _run_here)
        result = CliRunner().invoke(bench_goals.main, [str(path), *sizes, *SHORT], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def _rows(output: str) -> dict[str, list[str]]:
    lines = [line.strip("| ").split(" | ") for line in output.splitlines() if line.startswith("| ")]
    return {cells[0].strip(): [cell.strip() for cell in cells[1:]] for cells in lines}


def test_goals_are_measured_on_their_files(output: str) -> None:
    rows = _rows(output)
    assert 4_500 < int(rows["--max-bytes 9k"][1].replace(",", "")) <= 9_000
    assert float(rows["--target-psnr 7"][0]) >= 7.0


def test_palettes_have_no_more_fills_than_asked(output: str) -> None:
    rows = _rows(output)
    assert int(rows["--colors 3 --opacity free"][-1]) <= 3 < int(rows["neither"][-1])
    assert 0 < int(rows["--colors 3 --opaque"][2]) <= 12


def test_levels_stand_beside_fits_of_their_own(output: str) -> None:
    rows = _rows(output)
    for count in ("16", "32"):
        prefix, own, difference = map(float, rows[count])
        assert difference == pytest.approx(prefix - own, abs=0.011)
