"""Format the tables of `paper.py` as Markdown, with the paper's values beside ours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from statistics import fmean
from typing import NamedTuple

from fits import Row
from harness import markdown_table
from looks import NAMES, NEEDS, TITLES
from paper_values import Quantitative, Sweep

PSNR = ".2f"
_FORMS = {
    "psnr": PSNR,
    "ssim": ".3f",
    "ssim_gaussian": ".3f",
    "lpips_vgg": ".3f",
    "lpips_vgg_released": ".3f",
    "lpips_alex": ".3f",
    "ssimulacra2": ".1f",
}
_PAPER = {"psnr": "psnr", "ssim_gaussian": "ssim", "lpips_vgg_released": "lpips"}
"""The measures that the paper prints: which they are follows from the evaluation that its authors released."""


class Line(NamedTuple):
    """A fit in a table: its labels, its results, and the PSNR that the paper gives for it."""

    labels: tuple[object, ...]
    row: Row
    paper: float | None = None


def fits_table(header: Sequence[str], lines: Iterable[Line]) -> str:
    """Return a table with a line for each fit; ``header`` names the labels."""
    columns = (*header, "soft PSNR", "file PSNR", "paper", "iterations", "fit s")
    return markdown_table(columns, [[*line.labels, *_cells(line)] for line in lines])


def _cells(line: Line) -> list[str]:
    soft, file = (format(float(line.row[f"{image}_psnr"]), PSNR) for image in ("soft", "file"))
    return [soft, file, _paper(line.paper, PSNR), line.row["iterations"], f"{float(line.row['seconds']):.1f}"]


def _paper(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


# Tables 1 and 2


def quality_table(groups: Mapping[tuple[str, int], Sequence[Row]], paper: Quantitative) -> str:
    """Return the means over the images for each (preset, curves); PSNRs are averaged in decibels, as in the paper."""
    names = []
    for metric in _FORMS:
        title = TITLES.get(metric, metric.upper())
        names += [f"{title} soft", f"{title} file", *([f"{title} paper"] if metric in _PAPER else [])]
    header = ("preset", "curves", "paths left", "images", *names, "fit s")
    table = markdown_table(header, [_quality_line(group, rows, paper) for group, rows in groups.items()])
    missing = {NEEDS[name] for rows in groups.values() for row in rows for name in NAMES if not row[f"file_{name}"]}
    return "\n".join([table, *(f"\nMissing: {command}" for command in sorted(missing))])


def _quality_line(group: tuple[str, int], rows: Sequence[Row], paper: Quantitative) -> list[object]:
    cells: list[object] = [*group, _mean(rows, "paths", ".0f"), len(rows)]
    for metric, form in _FORMS.items():
        cells += [_mean(rows, f"{image}_{metric}", form) for image in ("soft", "file")]
        if metric in _PAPER:
            cells.append(_paper(getattr(paper[group], _PAPER[metric]) if group in paper else None, form))
    return [*cells, _mean(rows, "seconds", ".1f")]


def _mean(rows: Sequence[Row], name: str, form: str) -> str:
    """Return the mean of a column, or a dash if a value is missing."""
    return format(fmean(float(row[name]) for row in rows), form) if all(row[name] for row in rows) else "-"


# Table 3


def sweep_table(sweep: Sweep, results: Mapping[int, Sequence[Sequence[Row]]]) -> str:
    """Return the table of a panel of Table 3.

    Args:
        sweep: the panel in the paper.
        results: number of iterations -> the rows of the photos for every value, in the order of the sweep. Each number
            is compared with the same number in the paper, or with the one of the paper's two that it stands for.
    """
    header, columns, spreads = [sweep.setting], [], []
    for iterations, reference in _references(sorted(results), sweep).items():
        header += [f"soft @{iterations}", f"file @{iterations}", f"paper @{reference}"]
        ours = _mean_psnrs(results[iterations])
        columns += [*ours, sweep.psnr[reference]]
        spreads += [*(max(column) - min(column) for column in ours), sweep.spread[reference]]
    values = [f"{value:g}*" if value == sweep.default else f"{value:g}" for value in sweep.values]
    rows = zip([*values, "max - min"], [*zip(*columns, strict=True), spreads], strict=True)
    table = markdown_table(header, [[value, *(format(psnr, PSNR) for psnr in row)] for value, row in rows])
    return f"{sweep.title} (*: the paper's)\n\n{table}\n\n{_agreement(columns[0::3], columns[2::3])}"


def _references(counts: Sequence[int], sweep: Sweep) -> dict[int, int]:
    """Map each number of iterations to one of the paper: the same if it has it, else the smaller or the larger."""
    known = sorted(sweep.psnr)
    return {
        count: count if count in known else known[0 if k < len(counts) - 1 else -1] for k, count in enumerate(counts)
    }


def _mean_psnrs(groups: Sequence[Sequence[Row]]) -> list[list[float]]:
    """Return the mean PSNRs of the soft images and of the files, each for every value."""
    return [[fmean(float(row[f"{image}_psnr"]) for row in rows) for rows in groups] for image in ("soft", "file")]


def _agreement(ours: Sequence[Sequence[float]], papers: Sequence[Sequence[float]]) -> str:
    """Count the pairs of values that are in the paper's order, among those that differ in the paper."""
    agreed = [
        (a - b) * (paper_a - paper_b) > 0
        for column, paper in zip(ours, papers, strict=True)
        for (a, paper_a), (b, paper_b) in combinations(zip(column, paper, strict=True), 2)
        if paper_a != paper_b
    ]
    return f"Pairs of values in the paper's order (soft): {sum(agreed)} of {len(agreed)}."
