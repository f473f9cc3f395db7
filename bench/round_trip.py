"""Measure what is lost when SVGs of other programs are read and written again, without a fit.

Each file is read, written as a drawing of ``--written`` pixels, and drawn by resvg over white beside its original. The
tables say how far the two agree in decibels, and what the reader named as not shown. A file below the bar without a
remark is a fault of the reader.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from harness import comma_separated_counts, machine_facts, machine_line, markdown_table
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw, file_facts
from warpvec.svg.read import LoadedSvg, read_svg
from warpvec.svg.write import write_svg

BAR = 45.0
"""Decibels at every size at which a file counts as read."""

_SAME = 99.0
"""Decibels that are stated where not one level of a pixel differs."""

Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Trip:
    """One file.

    Attributes:
        name: its name.
        decibels: at each size, at most ``_SAME``; empty if the file is refused.
        paths, segments: of the scene.
        original_segments: those in the original's path data, without its other shapes.
        remarks: what the reader left out, or why it refused the file.
        is_closer: whether its small drawing is closer to the original's large one than the original's small one is.
            resvg approximates strokes by the size that it draws them at, and its edges depend on their notation.
    """

    name: str
    decibels: list[float]
    paths: int
    segments: int
    original_segments: int
    remarks: list[str]
    is_closer: bool

    @property
    def passes(self) -> bool:
        """Whether every size came back well enough."""
        return bool(self.decibels) and min(self.decibels) >= BAR


def travel(path: Path, sizes: Sequence[int], written: int, precision: int) -> Trip:
    """Read a file, write it again, and compare both."""
    source = path.read_bytes()
    try:
        drawing = read_svg(source)
        facts = file_facts(source)
        text = write_at(drawing, written, precision)
        drawn = {size: draw_both(source, text, drawing, size) for size in sizes}
        decibels = [_decibels(*drawn[size]) for size in sizes]
        is_closer = closer(drawn[min(sizes)], drawn[max(sizes)][0])
    except (InputError, ValueError) as error:
        return Trip(path.stem, [], 0, 0, 0, [f"refused: {error}"], False)
    scene = drawing.scene
    segments = scene.structure.segment_count
    return Trip(path.stem, decibels, len(scene), segments, facts["segments"], list(drawing.omitted), is_closer)


def write_at(drawing: LoadedSvg, side: int, precision: int) -> str:
    """Return a drawing as a file with a view box of ``side`` units, that states the size of the original.

    resvg then rounds the sides of both to the same pixels.
    """
    scale = side / max(drawing.width, drawing.height)
    across, down = scale * drawing.width, scale * drawing.height
    width, height = (max(math.ceil(length - 1e-6), 1) for length in (across, down))
    text = write_svg(drawing.scene.scaled(scale, scale), width, height, precision=precision)
    whole = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    stated = f'width="{drawing.width!r}" height="{drawing.height!r}" viewBox="0 0 {across!r} {down!r}"'
    return text.replace(whole, stated, 1)


def draw_both(source: bytes, text: str, drawing: LoadedSvg, size: int) -> tuple[Image, Image]:
    """Draw two files with ``size`` pixels on the longer side."""
    scale = size / max(drawing.width, drawing.height)
    sides = [max(round(scale * length), 1) for length in (drawing.width, drawing.height)]
    return draw(source, *sides), draw(text, *sides)


def closer(small: tuple[Image, Image], large: Image) -> bool:
    """Return whether the second of two drawings is at least as close as the first to a large one that is shrunk."""
    height, width = small[0].shape[:2]
    factor = round(large.shape[1] / width)
    if large.shape != (factor * height, factor * width, 3):
        return False
    shrunk = large.reshape(height, factor, width, factor, 3).mean((1, 3)) / 255.0
    return _decibels(small[1], shrunk) >= _decibels(small[0], shrunk)


def _decibels(one: Image, two: NDArray[Any]) -> float:
    return _SAME if np.array_equal(one, two) else min(psnr(one, two), _SAME)


def summary(trips: Sequence[Trip]) -> list[str]:
    """Return the share of files that pass, and the causes at those that do not."""
    failed = [trip for trip in trips if not trip.passes]
    share = f"{len(trips) - len(failed)} of {len(trips)} files have at least {BAR:.0f} dB at every size"
    kinds = Counter(
        remark.partition(": ")[0].lstrip("0123456789 ")
        for trip in failed
        if not trip.is_closer
        for remark in trip.remarks
    )
    causes = [f"- {kind}: in {count} of the others" for kind, count in kinds.most_common()]
    edges = [trip.name for trip in failed if trip.is_closer]
    silent = [trip.name for trip in failed if not trip.remarks and not trip.is_closer]
    lists = {"closer to the large original than the small original is": edges, "without a remark": silent}
    return [share, *causes, *(f"- {what}: {len(names)}: {', '.join(names)}" for what, names in lists.items() if names)]


def table(trips: Sequence[Trip], sizes: Sequence[int]) -> str:
    """Return one row a file, the worst first."""
    rows = [
        [
            trip.name,
            *([f"{value:.1f}" for value in trip.decibels] or ["-"] * len(sizes)),
            trip.paths,
            trip.segments,
            trip.original_segments,
            "yes" if trip.is_closer else "",
            "; ".join(trip.remarks),
        ]
        for trip in sorted(trips, key=lambda trip: min(trip.decibels, default=0.0))
    ]
    return markdown_table(
        ["file", *(f"dB at {size}" for size in sizes), "paths", "segments", "of its own", "closer", "remarks"], rows
    )


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--sizes", default="512,2048", show_default=True, callback=comma_separated_counts, help="Longer sides.")
@click.option("--written", type=click.IntRange(min=1), default=2048, show_default=True, help="Longer side of the file.")
@click.option("--precision", type=click.IntRange(0, 6), default=3, show_default=True, help="Decimals of the file.")
def main(folder: Path, sizes: list[int], written: int, precision: int) -> None:
    """Compare each SVG in FOLDER with what is left of it after it is read and written."""
    facts = machine_facts()
    files = sorted(folder.glob("*.svg"))
    if not files:
        raise click.UsageError(f"{folder} has no SVG")
    trips = [travel(path, sizes, written, precision) for path in files]
    click.echo(table(trips, sizes) + "\n")
    click.echo("\n".join(summary(trips)) + "\n")
    click.echo(machine_line(facts))
    click.echo(json.dumps({"bench": "round_trip", **facts, "trips": [asdict(trip) for trip in trips]}))


if __name__ == "__main__":
    main()
