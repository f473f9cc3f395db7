"""The tables of `paper.py` as Markdown, the paper's values beside ours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from statistics import fmean
from typing import NamedTuple

from fits import Row
from harness import markdown_table
from lpips_metric import NOT_FOUND
from paper_values import Quantitative, Sweep

PSNR = ".2f"
_METRICS = {"psnr": PSNR, "ssim": ".3f", "lpips": ".3f"}


class Line(NamedTuple):
    """A fit in a table: what tells it from the others, its results, and the PSNR that the paper has for it."""

    labels: tuple[object, ...]
    row: Row
    paper: float | None = None


def fits_table(header: Sequence[str], lines: Iterable[Line]) -> str:
    """A line for each fit under ``header``, the names of the labels."""
    columns = (*header, "soft PSNR", "file PSNR", "paper", "iterations", "fit s")
    return markdown_table(columns, [[*line.labels, *_cells(line)] for line in lines])


def _cells(line: Line) -> list[str]:
    soft, file = (format(float(line.row[f"{image}_psnr"]), PSNR) for image in ("soft", "file"))
    return [soft, file, _paper(line.paper, PSNR), line.row["iterations"], f"{float(line.row['seconds']):.1f}"]


def _paper(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


# Tables 1 and 2


def quality_table(groups: Mapping[tuple[str, int], Sequence[Row]], paper: Quantitative) -> str:
    """Means over the images for each (preset, curves); a mean of PSNRs is one of decibels, as the paper gives it."""
    names = [f"{metric.upper()} {source}" for metric in _METRICS for source in ("soft", "file", "paper")]
    header = ("preset", "curves", "images", *names, "fit s")
    return markdown_table(header, [_quality_line(group, rows, paper) for group, rows in groups.items()])


def _quality_line(group: tuple[str, int], rows: Sequence[Row], paper: Quantitative) -> list[object]:
    cells: list[object] = [*group, len(rows)]
    for metric, form in _METRICS.items():
        cells += [_mean(rows, f"{image}_{metric}", form) for image in ("soft", "file")]
        cells.append(_paper(getattr(paper[group], metric) if group in paper else None, form))
    return [*cells, _mean(rows, "seconds", ".1f")]


def _mean(rows: Sequence[Row], name: str, form: str) -> str:
    """The mean of a column; only LPIPS may be missing."""
    return format(fmean(float(row[name]) for row in rows), form) if all(row[name] for row in rows) else NOT_FOUND


# Table 3


def sweep_table(sweep: Sweep, results: Mapping[int, Sequence[Sequence[Row]]]) -> str:
    """A panel: for each number of iterations, the rows of the photos for every value, in the order of the sweep.

    Beside them stands what the paper has for that number, or for the one of its two that it corresponds to.
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
    """Number of iterations -> that of the paper: its own, else the fewest to its fewest, the most to its most."""
    known = sorted(sweep.psnr)
    return {
        count: count if count in known else known[0 if k < len(counts) - 1 else -1] for k, count in enumerate(counts)
    }


def _mean_psnrs(groups: Sequence[Sequence[Row]]) -> list[list[float]]:
    """Mean PSNR of the soft images for every value, and of the files."""
    return [[fmean(float(row[f"{image}_psnr"]) for row in rows) for rows in groups] for image in ("soft", "file")]


def _agreement(ours: Sequence[Sequence[float]], papers: Sequence[Sequence[float]]) -> str:
    """How many pairs of values stand in the paper's order, of those that differ in the paper."""
    agreed = [
        (a - b) * (paper_a - paper_b) > 0
        for column, paper in zip(ours, papers, strict=True)
        for (a, paper_a), (b, paper_b) in combinations(zip(column, paper, strict=True), 2)
        if paper_a != paper_b
    ]
    return f"Pairs of values in the paper's order (soft): {sum(agreed)} of {len(agreed)}."
