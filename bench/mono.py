"""Measure tracings of black and white art against potrace at its defaults, on scans of drawings of our own making.

    python bench/mono.py [--names letters,signature] [--kinds scan,aliased,smooth] [--sheet OUT.png]

The scans are blurred, noisy JPEGs of 600 pixels; "aliased" pictures have two levels only, "smooth" ones are the
drawings as resvg draws them. IoU is that of the ink at four times the size, of the file against the drawing.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import click
import numpy as np
from flat_counts import count
from flat_methods import SkippedError, trace_by_potrace
from flat_originals import Pixels, stretched
from harness import comma_separated, machine_facts, machine_line, markdown_table
from mono_originals import DRAWINGS, SIDE, drawing, scanned
from PIL import Image

from warpvec.flat.mono import mono_tracing
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg

SCALE = 4
"""Times the size at which ink is compared."""

KINDS = ("scan", "aliased", "smooth")
PRECISION = 2


@dataclass
class Row:
    """A tracing: IoU with the drawing, and counts."""

    name: str
    kind: str
    method: str
    iou: float
    segments: int
    bytes: int
    seconds: float


def ink(svg: str, scale: int) -> np.ndarray:
    """Return the share of ink [h, w] in the pixels of ``svg``, drawn at ``scale`` times its size."""
    side = scale * SIDE
    return 1.0 - draw(stretched(svg, side, side), side, side).mean(2) / 255.0


def iou(one: np.ndarray, two: np.ndarray) -> float:
    """Return the ink that two drawings share over the ink of either."""
    return float(np.minimum(one, two).sum() / np.maximum(one, two).sum())


def picture(svg: str, kind: str, seed: int) -> Pixels:
    """Return the picture [h, w] of a ``kind`` of a drawing."""
    coverage = ink(svg, 1)
    if kind == "scan":
        return scanned(coverage, seed)
    levels = coverage < 0.5 if kind == "aliased" else 1.0 - coverage
    return (255 * levels).round().astype(np.uint8)


def trace_by_us(pixels: Pixels, folder: Path) -> tuple[str, float]:
    """Return our file, and the seconds of the call."""
    del folder
    start = time.perf_counter()
    scene = mono_tracing(np.repeat(pixels[..., None], 3, 2)).scene
    return write_svg(scene, SIDE, SIDE, precision=PRECISION), time.perf_counter() - start


def trace_by_them(pixels: Pixels, folder: Path) -> tuple[str, float]:
    """Return potrace's file, and the seconds of its process."""
    bitmap, out = folder / "picture.pgm", folder / "potrace.svg"
    Image.fromarray(pixels).save(bitmap)
    start = time.perf_counter()
    trace_by_potrace(bitmap, out)
    return out.read_text(), time.perf_counter() - start


METHODS: dict[str, Callable[[Pixels, Path], tuple[str, float]]] = {"warpvec": trace_by_us, "potrace": trace_by_them}


def measure(name: str, kind: str, method: str, folder: Path) -> tuple[Row, str]:
    """Trace a drawing; return the row and the file."""
    original = drawing(name)
    pixels = picture(original, kind, list(DRAWINGS).index(name))
    svg, seconds = METHODS[method](pixels, folder)
    found = iou(ink(svg, SCALE), ink(original, SCALE))
    return Row(name, kind, method, found, count(svg).segments, len(svg.encode()), seconds), svg


@click.command()
@click.option("--names", callback=comma_separated, default=",".join(DRAWINGS), show_default=True)
@click.option("--kinds", callback=comma_separated, default=",".join(KINDS), show_default=True)
@click.option("--keep", type=click.Path(file_okay=False, path_type=Path), help="Keep pictures and SVGs in this folder.")
def main(names: list[str], kinds: list[str], keep: Path | None) -> None:
    """Measure tracings of black and white drawings, beside potrace."""
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        for name, kind, method in ((n, k, m) for k in kinds for n in names for m in METHODS):
            try:
                row, svg = measure(name, kind, method, Path(temporary))
            except SkippedError as skipped:
                click.echo(str(skipped), err=True)
                continue
            rows.append(row)
            if keep is not None:
                _keep(keep, row, svg)
    lines = [[r.name, r.kind, r.method, f"{r.iou:.4f}", r.segments, r.bytes, f"{r.seconds:.2f}"] for r in rows]
    click.echo(markdown_table(("drawing", "of", "method", "IoU", "segments", "bytes", "s"), lines) + "\n")
    facts = machine_facts()
    click.echo(json.dumps({"facts": facts, "rows": [asdict(row) for row in rows]}))
    click.echo(machine_line(facts))


def _keep(folder: Path, row: Row, svg: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{row.name}-{row.kind}-{row.method}.svg").write_text(svg)
    pixels = picture(drawing(row.name), row.kind, list(DRAWINGS).index(row.name))
    Image.fromarray(pixels).save(folder / f"{row.name}-{row.kind}.png")


if __name__ == "__main__":
    main()
