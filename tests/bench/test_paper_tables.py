"""Test the tables that compare our values with the paper's."""

from __future__ import annotations

import paper_tables
import paper_values
import pytest


def row_of(psnr: float, lpips: str = "") -> dict[str, str]:
    numbers = {"soft_psnr": psnr, "file_psnr": psnr - 2, "soft_ssim": 0.5, "file_ssim": 0.25, "seconds": 7}
    return {**{name: str(value) for name, value in numbers.items()}, "soft_lpips": lpips, "file_lpips": lpips}


def test_the_quality_table_shows_the_papers_values() -> None:
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


def test_a_sweep_table_shows_the_papers_values() -> None:
    """Our order is the paper's after 300 iterations, and its reverse after 900."""
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
def test_numbers_of_iterations_map_to_the_papers(counts: tuple[int, ...], expected: tuple[int, ...]) -> None:
    references = paper_tables._references(counts, paper_values.TABLE_3["lr"])
    assert references == dict(zip(counts, expected, strict=True))
