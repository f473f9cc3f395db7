"""Measure tracers on flat art against the designers' originals, as designers judge.

    python bench/flat.py FOLDER [--sizes 64,128,256,512] [--methods flat,photo,vtracer,potrace,bicubic] [--jpeg]

FOLDER has originals as SVGs. Each is drawn by resvg, traced, and the file is compared with the original, not with the
picture: at the size of the picture, and at four times that size.
"""

from __future__ import annotations

import json
import math
import shlex
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from statistics import fmean, median

import click
import numpy as np
from flat_corners import corner_distances, seen_corners
from flat_counts import count
from flat_methods import OPTIONS, SkippedError, Traced, method_named
from flat_originals import SCALE, Original, Pixels, Svgo, find_originals, stretched
from flat_sheet import Sheet
from harness import comma_separated, comma_separated_counts, machine_facts, machine_line, markdown_table

from warpvec.image.metrics import psnr, ssim
from warpvec.svg.measure import draw

PSNR_MAX = 99.0
"""Equal pictures count as so many decibels in a mean."""


@dataclass
class Row:
    """A tracing, measured. Ratios are to the original; None means that the method has no file, or that svgo is missing.

    Attributes:
        name, method, size, kind: the original, the tracer, the picture's longest side, and "png" or "jpeg".
        psnr, ssim: of the file against the original at the size of the picture, over white.
        psnr_4x: the same in dB at four times the size.
        paths, segments, bytes, colors: over those of the original, bytes after svgo.
        path_count, byte_count: those of the file as written.
        has_gradients: whether the original has gradients; its colours then do not count as flat.
        corner: largest distance in pixels from a corner of the original to the nearest one of the file.
        corner_p90: the distance that nine tenths of the corners stay within.
        alpha: largest difference of alpha in levels, outside of edges; None for opaque pictures.
        seconds: time of the whole process, for packages in this process that of the call.
    """

    name: str
    method: str
    size: int
    kind: str
    seconds: float
    psnr_4x: float
    psnr: float | None = None
    ssim: float | None = None
    paths: float | None = None
    segments: float | None = None
    bytes: float | None = None
    colors: float | None = None
    path_count: int | None = None
    byte_count: int | None = None
    has_gradients: bool = False
    corner: float | None = None
    corner_p90: float | None = None
    alpha: int | None = None


COLUMNS = {
    "psnr": ("PSNR", ".2f"), "ssim": ("SSIM", ".4f"), "psnr_4x": ("PSNR 4x", ".2f"), "paths": ("paths", ".2f"),
    "segments": ("segments", ".2f"), "bytes": ("bytes", ".2f"), "colors": ("colours", ".2f"),
    "corner": ("corner px", ".2f"), "corner_p90": ("of 90 %", ".2f"), "alpha": ("alpha", "d"), "seconds": ("s", ".1f"),
}  # fmt: skip


# The measures


def measure(original: Original, method: str, size: int, kind: str, traced: Traced, svgo: Svgo) -> Row:
    """Return the row of a tracing."""
    if traced.svg is None:
        assert traced.scaled is not None
        found = min(psnr(traced.scaled, original.drawn(size, SCALE)), PSNR_MAX)
        return Row(original.name, method, size, kind, traced.seconds, found)
    quality = {scale: _compared(original, size, traced.svg, scale) for scale in (1, SCALE)}
    row = Row(original.name, method, size, kind, traced.seconds, quality[SCALE][0], *quality[1])
    _add_counts(row, original, traced.svg, svgo)
    distances = corner_distances(_seen(original, size), traced.svg, *original.extent(size))
    if len(distances):
        row.corner, row.corner_p90 = float(distances.max()), float(np.quantile(distances, 0.9))
    row.alpha = None if kind == "jpeg" else alpha_error(original, size, traced.svg)
    return row


def _compared(original: Original, size: int, svg: str, scale: int) -> tuple[float, float]:
    truth = original.drawn(size, scale)
    drawn = _drawn(svg, truth)
    return min(psnr(drawn, truth), PSNR_MAX), ssim(drawn, truth) if scale == 1 else math.nan


def _drawn(svg: str, like: Pixels, transparent: bool = False) -> Pixels:
    height, width = like.shape[:2]
    return draw(stretched(svg, width, height), width, height, transparent=transparent)


def _add_counts(row: Row, original: Original, svg: str, svgo: Svgo) -> None:
    ours, theirs = count(svg), original.counts
    row.path_count, row.byte_count = ours.shapes, len(svg.encode())
    row.paths, row.segments = ours.shapes / theirs.shapes, ours.segments / theirs.segments
    row.colors = (ours.colors + ours.stops) / (theirs.colors + theirs.stops)
    row.has_gradients = theirs.has_gradients
    byte_counts = svgo.byte_count(svg), svgo.byte_count(original.text)
    if all(byte_counts):
        row.bytes = byte_counts[0] / byte_counts[1]  # type: ignore[operator]


@cache
def _seen(original: Original, size: int) -> np.ndarray:
    return seen_corners(original.text, *original.extent(size))


def alpha_error(original: Original, size: int, svg: str) -> int | None:
    """Return the largest difference of alpha where the original's is the same in a pixel and its eight neighbours."""
    truth = original.drawn(size, transparent=True)[..., 3].astype(int)
    if (truth == 255).all():
        return None
    padded = np.pad(truth, 1, constant_values=-1)  # the border of the canvas is an edge
    around = np.lib.stride_tricks.sliding_window_view(padded, (3, 3)).reshape(*truth.shape, 9)
    is_even = around.max(2) == around.min(2)
    drawn = _drawn(svg, truth[..., None], transparent=True)[..., 3].astype(int)
    return int(np.abs(drawn - truth)[is_even].max())


# The runs


@dataclass(frozen=True)
class Plan:
    """What is traced, and how."""

    originals: list[Original]
    methods: list[str]
    options: dict[str, list[str]]
    sizes: list[int]
    kinds: list[str]
    svgo: Svgo
    keep: Path | None

    def rows(self, sheet: Sheet | None, folder: Path) -> Iterator[Row]:
        """Yield a row for each tracing; what cannot be traced is said once, on the error stream."""
        said: set[str] = set()
        cases = [(size, kind, original) for size in self.sizes for kind in self.kinds for original in self.originals]
        for size, kind, original in cases:
            picture = original.save(folder, size, kind == "jpeg")
            for method in self.methods:
                try:
                    yield self._row(method, original, size, kind, picture, sheet)
                except SkippedError as skipped:
                    if str(skipped) not in said:
                        click.echo(str(skipped), err=True)
                    said.add(str(skipped))

    def _row(self, method: str, original: Original, size: int, kind: str, picture: Path, sheet: Sheet | None) -> Row:
        out = (self.keep or picture.parent) / f"{original.name}-{size}-{kind}-{method}.svg"
        traced = method_named(method, self.options)(original, picture, out)
        row = measure(original, method, size, kind, traced, self.svgo)
        if sheet is not None and traced.svg is not None and method == self.methods[0] and size == self.sizes[-1]:
            title = (
                f"{original.name} {kind} {size} px: {row.psnr:.2f} dB, 4x {row.psnr_4x:.2f} dB, {row.path_count} paths"
            )
            sheet.add(original, size, traced.svg, title)
        return row


# The tables


def details_table(rows: Sequence[Row]) -> str:
    """Return a table with a row for every tracing."""
    lines = [[row.name, row.method, row.size, row.kind, *_cells(row)] for row in rows]
    return markdown_table(("picture", "method", "px", "of", *(title for title, _ in COLUMNS.values())), lines)


def _cells(row: Row) -> list[str]:
    return [_text(getattr(row, name), form) for name, (_, form) in COLUMNS.items()]


def _text(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def summary_table(rows: Sequence[Row]) -> str:
    """Return a table with means of qualities and medians of ratios for each method, size and kind of picture."""
    header = ("method", "px", "of", "n", "PSNR", "worst", "SSIM", "PSNR 4x", "paths", "segments", "bytes",
              "colours, flat", "corner px", "alpha", "s", "s, most")  # fmt: skip
    groups: dict[tuple[str, int, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.method, row.size, row.kind), []).append(row)
    return markdown_table(header, [[*key, len(group), *_summary(group)] for key, group in groups.items()])


def _summary(rows: list[Row]) -> list[str]:
    def of(name: str, combine: object, form: str = ".2f", chosen: list[Row] = rows) -> str:
        values = [value for row in chosen if (value := getattr(row, name)) is not None]
        return format(combine(values), form) if values else "-"  # type: ignore[operator]

    flat = [row for row in rows if not row.has_gradients]
    return [
        of("psnr", fmean), of("psnr", min), of("ssim", fmean, ".4f"), of("psnr_4x", fmean), of("paths", median),
        of("segments", median), of("bytes", median), of("colors", median, ".2f", flat), of("corner", median),
        of("alpha", max, "d"), of("seconds", fmean, ".1f"), of("seconds", max, ".1f"),
    ]  # fmt: skip


def jpeg_table(rows: Sequence[Row]) -> str:
    """Return the paths from each JPEG over those from the PNG of the same picture."""
    paths = {(row.method, row.size, row.name, row.kind): row.path_count for row in rows if row.path_count}
    ratios: dict[tuple[str, int], list[float]] = {}
    for (method, size, name, kind), of_jpeg in paths.items():
        of_png = paths.get((method, size, name, "png"))
        if kind == "jpeg" and of_png:
            ratios.setdefault((method, size), []).append(of_jpeg / of_png)
    lines = [[method, size, len(found), f"{median(found):.2f}", f"{max(found):.2f}"] for (method, size), found in
             ratios.items()]  # fmt: skip
    return markdown_table(("paths of JPEG over PNG", "px", "n", "median", "most"), lines)


def _parse_runs(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> dict[str, list[str]]:
    del ctx, param
    if not all("=" in value for value in values):
        raise click.BadParameter("must be NAME=OPTIONS, as in 'photo=--curves 64'")
    return OPTIONS | {value.partition("=")[0]: shlex.split(value.partition("=")[2]) for value in values}


def _check_methods(methods: list[str], options: dict[str, list[str]]) -> None:
    for method in methods:
        try:
            method_named(method, options)
        except KeyError:
            known = ", ".join([*options, "vtracer", "potrace", "bicubic"])
            raise click.UsageError(f"--methods must be of {known}, got {method!r}; --run defines others") from None


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--sizes", callback=comma_separated_counts, default="64,128,256,512", show_default=True)
@click.option("--methods", callback=comma_separated, default="flat,photo,vtracer,potrace,bicubic", show_default=True)
@click.option("--run", "options", callback=_parse_runs, multiple=True, help="NAME=OPTIONS: a method of `warpvec run`.")
@click.option("--names", default="", help="Only these originals, as in a,b.")
@click.option("--jpeg", is_flag=True, help="Also trace JPEGs of quality 80.")
@click.option("--svgo", default="svgo", show_default=True, help="Command that runs svgo.")
@click.option("--sheet", type=click.Path(dir_okay=False, path_type=Path), help="Contact sheet of the first method.")
@click.option("--cell", default=512, show_default=True, help="Largest side of a picture of the sheet in pixels.")
@click.option("--keep", type=click.Path(file_okay=False, path_type=Path), help="Keep the SVGs in this folder.")
@click.option("--details/--no-details", default=True, help="Print a row for each tracing.")
def main(
    folder: Path,
    sizes: list[int],
    methods: list[str],
    options: dict[str, list[str]],
    names: str,
    jpeg: bool,
    svgo: str,
    sheet: Path | None,
    cell: int,
    keep: Path | None,
    details: bool,
) -> None:
    """Measure tracings of the originals in FOLDER."""
    _check_methods(methods, options)
    kinds = ["png", "jpeg"] if jpeg else ["png"]
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
    originals = find_originals(folder, [name for name in names.split(",") if name])
    plan = Plan(originals, methods, options, sizes, kinds, Svgo(svgo), keep)
    drawn = None if sheet is None else Sheet(cell)
    with tempfile.TemporaryDirectory() as temporary:
        rows = list(plan.rows(drawn, Path(temporary)))
    if plan.svgo.reason:
        click.echo(plan.svgo.reason, err=True)
    if drawn is not None and sheet is not None:
        drawn.save(sheet)
    _print(rows, details, jpeg)


def _print(rows: list[Row], details: bool, jpeg: bool) -> None:
    facts = machine_facts()
    tables = [*([details_table(rows)] if details else []), summary_table(rows), *([jpeg_table(rows)] if jpeg else [])]
    click.echo("\n\n".join(tables) + "\n")
    records = [{name: _rounded(value) for name, value in asdict(row).items()} for row in rows]
    click.echo(json.dumps({"facts": facts, "rows": records}))
    click.echo(machine_line(facts))


def _rounded(value: object) -> object:
    return round(value, 4) if isinstance(value, float) else value


if __name__ == "__main__":
    main()
