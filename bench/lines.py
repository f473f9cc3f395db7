"""Measure `warpvec run --mode lines` on icons of strokes and on letters of Hershey's, beside AutoTrace's centre lines.

    python bench/lines.py [--icons FOLDER] [--count 50] [--fonts DIR/futural.jhf,DIR/scripts.jhf] [--keep OUT]

Each original is drawn by resvg at 512 px over white; the centre lines of the tracings are compared with its own.
AutoTrace is the package pyautotrace; it is skipped where that is missing.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from statistics import fmean

import click
import numpy as np
from flat_methods import SkippedError
from flat_originals import Original
from harness import comma_separated, machine_facts, machine_line, markdown_table
from line_measures import compare, trail_of
from line_originals import letters, spread
from PIL import Image

import warpvec
from warpvec.errors import InputError

SIZE = 512
CHARACTERS = "ABGKQRSagkt8"


@dataclass
class Row:
    """A tracing: as in `line_measures.Found`, with the number of its lines and the seconds of the run."""

    group: str
    name: str
    method: str
    off: float
    once: float
    missed: float
    lines: int
    seconds: float


def trace_by_us(picture: Path, out: Path) -> None:
    """Write our file."""
    try:
        warpvec.vectorize(picture, mode="lines").save(out)
    except InputError as error:
        raise SkippedError(f"warpvec: {error}") from None


def trace_by_autotrace(picture: Path, out: Path) -> None:
    """Write AutoTrace's file of centre lines, with its defaults."""
    try:
        autotrace = import_module("autotrace")
    except ImportError:
        raise SkippedError("autotrace: skipped, the package pyautotrace is not installed") from None
    pixels = np.asarray(Image.open(picture).convert("RGB"))
    white = autotrace.Color(255, 255, 255)
    options = autotrace.TraceOptions(centerline=True, background_color=white, color_count=2)
    vector = autotrace.Bitmap(pixels).trace(options=options)
    out.write_bytes(vector.encode(autotrace.VectorFormat.SVG))


METHODS: dict[str, Callable[[Path, Path], None]] = {"warpvec": trace_by_us, "autotrace": trace_by_autotrace}


def measure(group: str, original: Original, method: str, folder: Path) -> Row:
    """Trace a drawing, and return its row."""
    picture, out = folder / f"{original.name}.png", folder / f"{original.name}-{method}.svg"
    Image.fromarray(original.drawn(SIZE)).save(picture)
    start = time.perf_counter()
    METHODS[method](picture, out)
    seconds = time.perf_counter() - start
    extent = original.extent(SIZE)
    svg = out.read_text()
    found = compare(trail_of(svg, *extent), trail_of(original.text, *extent))
    return Row(group, original.name, method, *found, svg.count("<path"), seconds)


def summary_table(rows: list[Row]) -> str:
    """Return a table with a row for each group and method."""
    lines = []
    for group, method in dict.fromkeys((row.group, row.method) for row in rows):
        some = [row for row in rows if (row.group, row.method) == (group, method)]
        values = [fmean(getattr(row, name) for row in some) for name in ("off", "once", "missed", "seconds")]
        lines.append([group, method, len(some), f"{values[0]:.3f}", f"{max(row.off for row in some):.2f}",
                      f"{100 * values[1]:.1f} %", f"{100 * values[2]:.1f} %", f"{values[3]:.1f}"])  # fmt: skip
    header = ("of", "method", "n", "off, px", "worst", "found once", "missed", "s")
    return markdown_table(header, lines)


@click.command()
@click.option("--icons", type=click.Path(exists=True, file_okay=False, path_type=Path), help="Folder of SVGs.")
@click.option("--count", default=50, show_default=True, help="Number of icons, spread over their names.")
@click.option("--fonts", callback=comma_separated, default="", help="Files of Hershey's, in the format jhf.")
@click.option("--characters", default=CHARACTERS, show_default=True, help="Letters of each font.")
@click.option("--methods", callback=comma_separated, default=",".join(METHODS), show_default=True)
@click.option("--keep", type=click.Path(file_okay=False, path_type=Path), help="Keep pictures and SVGs in this folder.")
def main(
    icons: Path | None, count: int, fonts: list[str], characters: str, methods: list[str], keep: Path | None
) -> None:
    """Measure tracings of drawings of lines."""
    groups = {} if icons is None else {icons.parent.name: spread(icons, count)}
    groups |= {Path(font).stem: letters(Path(font), characters) for font in fonts if font}
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for group, original, method in ((g, o, m) for g, some in groups.items() for o in some for m in methods):
            try:
                rows.append(measure(group, original, method, folder))
            except SkippedError as skipped:
                click.echo(f"{original.name}: {skipped}", err=True)
    details = [[r.group, r.name, r.method, f"{r.off:.3f}", f"{100 * r.once:.1f} %", f"{100 * r.missed:.1f} %", r.lines]
               for r in rows]  # fmt: skip
    click.echo(markdown_table(("of", "drawing", "method", "off, px", "found once", "missed", "lines"), details) + "\n")
    click.echo(summary_table(rows) + "\n")
    facts = machine_facts()
    click.echo(json.dumps({"facts": facts, "rows": [asdict(row) for row in rows]}))
    click.echo(machine_line(facts))


if __name__ == "__main__":
    main()
