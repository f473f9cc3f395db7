"""Check drawings without overlaps: cut the SVGs of a folder, and compare areas, drawn and exact.

    python bench/cutout.py FOLDER [--size 512]

"sum" is the exact area of all parts, and "covered" what the stacked drawing covers, from a drawing by resvg of sixteen
times as many pixels; "once" is the number of segments of the lines of `--cut-once`, where an edge of two parts is one;
"twice" and "gap" are the shares of that area that the parts, each drawn alone, cover twice and not at all; "spur" is
the farthest place of a part from where a disk as wide as the widest spur fits into it, in millimetres at 96 pixels to
an inch.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import reduce
from itertools import pairwise
from pathlib import Path

import click
import numpy as np
import shapely
import torch
from flat_corners import scene_of
from flat_originals import Original
from harness import machine_facts, machine_line, markdown_table

from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.cut_lines import cut_lines
from warpvec.flat.cutting.cutout import cut_out
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw
from warpvec.svg.units import MM_PER_PIXEL
from warpvec.svg.write import write_svg

SCALE = 4
CURVE_POINTS = 16
"""Points of a curve by which its area is known."""
NUMERIC = 1e-3
"""Distance in pixels by which two areas may differ by rounding."""
PRECISION = 3
ROUNDING = 0.2
"""Sums of coverage within so much of the right value count as right: resvg rounds the coverage of each part."""


def areas(scene: Scene) -> np.ndarray:
    """Return the area of each path in square pixels, by Green's theorem."""
    segments = scene.segments.double().numpy()
    ends = segments[scene.structure.segment_next.long().numpy(), :1]
    x, y = np.moveaxis(np.concatenate([segments, ends], 1), 2, 0)
    weights = np.array([[-10, 6, 3, 1], [-6, 0, 3, 3], [-3, -3, 0, 6], [-1, -3, -6, 10]]) / 20
    parts = np.einsum("ni,ij,nj->n", x, weights, y)
    return np.abs(np.bincount(scene.structure.segment_path.numpy(), parts, len(scene)))


def outlines(scene: Scene) -> Iterator[shapely.Geometry]:
    """Yield the area of each path, by points along its curves."""
    cubics, structure = whole_curves(scene).double().numpy(), scene.structure
    t = np.linspace(0.0, 1.0, CURVE_POINTS + 1)[:-1]
    weights = np.stack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3], 1)
    points = np.einsum("tk,nkc->ntc", weights, cubics)
    loops = list(pairwise(structure.loop_first_segment.tolist()))
    for first, last in pairwise(structure.path_first_loop.tolist()):
        rings = (shapely.Polygon(points[start:stop].reshape(-1, 2)) for start, stop in loops[first:last])
        yield reduce(shapely.symmetric_difference, map(shapely.make_valid, rings))


def longest_spur(scene: Scene) -> float:
    """Return the largest distance in millimetres of a place of a path from where a spur's widest disk fits into it."""
    radius, found = CUTTING.sliver_width / 2, 0.0
    for area in outlines(scene):
        wide = area.buffer(-radius).buffer(radius)
        if not wide.is_empty:
            narrow = area.difference(wide.buffer(NUMERIC))
            found = max(found, shapely.distance(shapely.points(shapely.get_coordinates(narrow)), wide).max(initial=0.0))
    return found * MM_PER_PIXEL


def coverage(scene: Scene, width: int, height: int) -> np.ndarray:
    """Return the share of each pixel that ``scene`` covers, at ``SCALE`` times the size."""
    text = write_svg(scene, width, height, precision=PRECISION)
    return draw(text, SCALE * width, SCALE * height, transparent=True)[..., 3] / 255.0


def measure(original: Original, size: int) -> list[str]:
    """Return the cells of a row."""
    width, height = original.extent(size)
    stacked = scene_of(original.text, width, height)
    start = time.process_time()
    cut = cut_out(stacked, width, height)
    seconds = time.process_time() - start
    whole = coverage(stacked, width, height)
    alone = (coverage(cut.scene.select(torch.tensor([k])), width, height) for k in range(len(cut.scene)))
    total = np.sum(list(alone), axis=0)
    twice = np.maximum(total - 1 - ROUNDING, 0).sum() / whole.sum()
    gap = np.maximum(whole - total - ROUNDING, 0).sum() / whole.sum()
    covered = whole.sum() / SCALE**2
    segments = [scene.structure.segment_count for scene in (stacked, cut.scene)]
    once = sum(len(line.parts) for line in cut_lines(stacked, width, height))
    counts = [len(stacked), len(cut.scene), *segments, once, cut.hidden_count, cut.sliver_count, cut.blended_count]
    sums = [f"{areas(cut.scene).sum():.1f}", f"{covered:.1f}", f"{1e2 * twice:.4f} %", f"{1e2 * gap:.4f} %"]
    return [original.name, *map(str, counts), *sums, f"{longest_spur(cut.scene):.3f}", f"{seconds:.2f}"]


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--size", default=512, show_default=True, help="Longest side of the drawings in pixels.")
def main(folder: Path, size: int) -> None:
    """Cut the SVGs of FOLDER."""
    header = ("drawing", "paths", "cut", "segments", "cut", "once", "hidden", "slivers", "blended", "sum px",
              "covered px", "twice", "gap", "spur mm", "CPU s")  # fmt: skip
    rows = [measure(Original(path.stem, path.read_text()), size) for path in sorted(folder.glob("*.svg"))]
    click.echo(markdown_table(header, rows))
    click.echo(machine_line(machine_facts()))


if __name__ == "__main__":
    main()
