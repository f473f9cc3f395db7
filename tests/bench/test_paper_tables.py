"""The tables of the paper beside ours: the numbers, and where they stand."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[2] / "bench"))
paper_tables, paper_values = map(import_module, ("paper_tables", "paper_values"))


# The paper's values, typed again from its tables


TABLE_ROWS = {
    ("TABLE_1", "bezier-splatting"): "24.19 & 0.621 & 0.519 & 25.61 & 0.664 & 0.485 & 26.91 & 0.708 & 0.448",
    ("TABLE_1", "paper"): "25.18 & 0.631 & 0.427 & 26.68 & 0.687 & 0.353 & 28.30 & 0.749 & 0.275",
    ("TABLE_2", "bezier-splatting"): "20.74 & 0.580 & 0.546 & 22.11 & 0.607 & 0.528 & 23.45 & 0.639 & 0.507",
    ("TABLE_2", "paper"): "21.37 & 0.564 & 0.548 & 22.64 & 0.598 & 0.503 & 23.99 & 0.640 & 0.450",
}
SWEEP_ROWS = {
    ("lr", 1000): "23.48 & 25.79 & 26.16 & 26.95 & 26.91 & 3.47",
    ("lr", 5000): "25.83 & 27.07 & 27.38 & 27.95 & 27.84 & 2.12",
    ("radius", 1000): "26.40 & 26.68 & 26.96 & 26.93 & 24.33 & 2.63",
    ("radius", 5000): "27.80 & 27.92 & 27.94 & 27.85 & 25.30 & 2.64",
    ("gap", 1000): "27.27 & 27.16 & 26.97 & 23.81 & 21.39 & 5.87",
    ("gap", 5000): "27.85 & 27.93 & 27.93 & 27.97 & 27.95 & 0.19",
}


@pytest.mark.parametrize(("table", "preset"), TABLE_ROWS)
def test_tables_1_and_2_of_the_paper(table: str, preset: str) -> None:
    values = getattr(paper_values, table)
    found = [number for curves in (256, 512, 1024) for number in values[preset, curves]]
    assert found == [float(text) for text in TABLE_ROWS[table, preset].split(" & ")]
    assert len(values) == 6


@pytest.mark.parametrize(("panel", "iterations"), SWEEP_ROWS)
def test_table_3_of_the_paper(panel: str, iterations: int) -> None:
    sweep = paper_values.TABLE_3[panel]
    expected = [float(text) for text in SWEEP_ROWS[panel, iterations].split(" & ")]
    assert [*sweep.psnr[iterations], sweep.spread[iterations]] == expected
    assert sweep.default in sweep.values


def test_figures_of_the_paper() -> None:
    assert paper_values.INTERIOR == {"off": 23.4553, "on": 28.0802}
    assert paper_values.HIERARCHY == {("flat", 1): 24.4731, ("flat", 50): 19.1911, ("hierarchical", 50): 24.6808}


def row_of(psnr: float, lpips: str = "") -> dict[str, str]:
    numbers = {"soft_psnr": psnr, "file_psnr": psnr - 2, "soft_ssim": 0.5, "file_ssim": 0.25, "seconds": 7}
    return {**{name: str(value) for name, value in numbers.items()}, "soft_lpips": lpips, "file_lpips": lpips}


def test_quality_table_has_the_papers_values_beside_ours() -> None:
    groups = {
        ("paper", 256): [row_of(20.0, "0.25"), row_of(21.0, "0.5")],
        ("default", 256): [row_of(22.0)],
        ("paper", 64): [row_of(22.0)],
    }
    lines = paper_tables.quality_table(groups, paper_values.TABLE_1).splitlines()
    assert lines[2] == (
        "| paper | 256 | 2 | 20.50 | 18.50 | 25.18 | 0.500 | 0.250 | 0.631 | 0.375 | 0.375 | 0.427 | 7.0 |"
    )
    missing = "weights not found: give --lpips-weights PATH"
    for line, name in zip(lines[3:], ("default | 256", "paper | 64"), strict=True):
        assert line == (f"| {name} | 1 | 22.00 | 20.00 | - | 0.500 | 0.250 | - | {missing} | {missing} | - | 7.0 |")


def test_sweep_table_has_the_papers_values_beside_ours() -> None:
    """Our order after 300 iterations is the paper's, after 900 the reverse of it."""
    sweep = paper_values.TABLE_3["gap"]
    results = {300: [[row_of(value)] for value in (25, 24, 23, 22, 21)], 900: [[row_of(-v)] for v in sweep.psnr[5000]]}
    text = paper_tables.sweep_table(sweep, results)
    assert "| inflation_gap | soft @300 | file @300 | paper @1000 | soft @900 | file @900 | paper @5000 |" in text
    assert "| 100* | 23.00 | 21.00 | 26.97 | -27.93 | -29.93 | 27.93 |" in text
    assert "| max - min | 4.00 | 4.00 | 5.87 | 0.12 | 0.12 | 0.19 |" in text
    assert text.endswith("the paper's order (soft): 10 of 19.")


@pytest.mark.parametrize(
    ("counts", "expected"),
    [((5000,), (5000,)), ((1000,), (1000,)), ((700,), (5000,)), ((200, 1000), (1000, 1000)), ((9, 90), (1000, 5000))],
)
def test_counts_of_iterations_stand_beside_the_papers(counts: tuple[int, ...], expected: tuple[int, ...]) -> None:
    references = paper_tables._references(counts, paper_values.TABLE_3["lr"])
    assert references == dict(zip(counts, expected, strict=True))
