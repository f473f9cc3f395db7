"""Measure what lies hidden in drawings of flat art: take each shape away, and see what appears.

    python bench/hidden.py FOLDER [--drawings FOLDER] [--size 512] [--names a,b] [--sheet OUT.png]

FOLDER has the designers' SVGs. Each is traced, or its tracing is NAME.svg of ``--drawings``. A path of the tracing and
one of the original are the same shape if they show in nearly the same pixels. Both are taken away, and the pixels where
the original's showed are compared: there lies what the designer drew below, and what the tracing supposes. The column
"one colour" is the difference that a guess has which knows the answer, but only has the colours around the shape: the
best of them, everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from statistics import fmean

import click
import numpy as np
import torch
from flat_corners import scene_of
from flat_originals import Original, Pixels, find_originals
from harness import comma_separated, machine_facts, machine_line, markdown_table
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

import warpvec
from warpvec.flat.simplification.outline_samples import top_paths
from warpvec.geometry.scene import Scene, over_white
from warpvec.rendering.draw import draw_exactly

AGREEMENT = 0.8
"""Share of the pixels in which one of two paths shows, in which both must, to be the same shape."""

AREA_MIN = 64
"""Pixels in which a shape must show: below smaller ones hardly anything is hidden."""

RING = (2, 4)
"""Distances in pixels from a shape between which the colours around it are looked at, beyond its soft edge."""

COLOR_STEP = 4
"""Levels that count as one colour around a shape."""

COLORS_MAX = 12
"""Most colours around a shape, the frequent ones."""


def shapes(ours: Scene, theirs: Scene, height: int, width: int) -> Iterator[tuple[int, int, NDArray[np.bool_]]]:
    """Yield each pair of paths that are the same shape, and the pixels [h, w] in which the original's shows."""
    top, true = (top_paths(scene, height, width, None) for scene in (ours, theirs))
    for path in range(len(theirs)):
        where = true == path
        found = top[where]
        if (found >= 0).sum() < AREA_MIN:
            continue
        own = int(np.bincount(found[found >= 0]).argmax())
        both, either = (where & (top == own)).sum(), (where | (top == own)).sum()
        if both >= AGREEMENT * either:
            yield own, path, where


def best_color_around(image: Pixels, true: Pixels, where: NDArray[np.bool_]) -> float:
    """Return the least mean difference in levels from ``true`` [h, w, 3] of one colour of the ring around a shape.

    Args:
        image: the picture [h, w, 3].
        true: what appears without the shape.
        where: the pixels [h, w] in which the shape shows.
    """
    ring = ndimage.binary_dilation(where, iterations=RING[1]) & ~ndimage.binary_dilation(where, iterations=RING[0])
    colors, counts = np.unique(image[ring] // COLOR_STEP, axis=0, return_counts=True)
    often = colors[np.argsort(-counts)][:COLORS_MAX].astype(int) * COLOR_STEP + COLOR_STEP // 2
    return min((float(np.abs(true[where] - color).mean()) for color in often), default=255.0)


def drawn_without(scene: Scene, path: int, height: int, width: int) -> Pixels:
    """Return the drawing [h, w, 3], over white, without one of its paths."""
    rest = torch.arange(len(scene)) != path
    pixels = draw_exactly(over_white(scene.select(rest)), height, width, None)
    return np.round(255.0 * pixels.clip(0.0, 1.0)).astype(np.uint8)


def measure(original: Original, drawings: Path | None, size: int, sheet: list[Pixels]) -> list[tuple[float, float]]:
    """Return the mean difference in levels of what appears below each shape, and that of the best colour around it.

    Add the worst pair to the ``sheet``.
    """
    width, height = original.extent(size)
    if drawings is None:
        text = warpvec.vectorize(original.drawn(size, transparent=True), mode="flat", gradients=None).svg()
    else:
        text = (drawings / f"{original.name}.svg").read_text()
    ours, theirs = (scene_of(each, width, height) for each in (text, original.text))
    image = original.drawn(size)
    found, worst = list[tuple[float, float]](), None
    for own, path, where in shapes(ours, theirs, height, width):
        a, b = drawn_without(ours, own, height, width), drawn_without(theirs, path, height, width)
        difference = float(np.abs(a.astype(int) - b)[where].mean())
        found.append((difference, best_color_around(image, b, where)))
        if difference == max(found)[0]:
            worst = np.concatenate([a, b], 1)
    if worst is not None:
        sheet.append(worst)
    return found


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--drawings", type=click.Path(exists=True, file_okay=False, path_type=Path), help="Tracings, by name.")
@click.option("--size", default=512, show_default=True, help="Longest side of the pictures in pixels.")
@click.option("--names", callback=comma_separated, default="", help="Only these drawings.")
@click.option("--sheet", type=click.Path(dir_okay=False, path_type=Path), help="Save the worst of each: ours, theirs.")
def main(folder: Path, drawings: Path | None, size: int, names: list[str], sheet: Path | None) -> None:
    """Compare what appears below the shapes of tracings of the SVGs in FOLDER with what their designers drew there."""
    rows, means, pictures = [], list[tuple[float, float]](), list[Pixels]()
    for original in find_originals(folder, [name for name in names if name]):
        found = measure(original, drawings, size, pictures)
        if found:
            means.append((fmean(ours for ours, _ in found), fmean(one for _, one in found)))
            rows.append([original.name, len(found), *(f"{mean:.2f}" for mean in means[-1]), f"{max(found)[0]:.1f}"])
    if not rows:
        raise click.ClickException("no drawing has a shape that its tracing has too")
    rows.append(["mean", "", *(f"{fmean(column):.2f}" for column in zip(*means, strict=True)), ""])
    click.echo(markdown_table(("drawing", "shapes", "levels", "one colour", "worst"), rows))
    click.echo(machine_line(machine_facts()))
    if sheet is not None:
        side = max(picture.shape[1] for picture in pictures)
        padded = [np.pad(each, ((0, 8), (0, side - each.shape[1]), (0, 0)), constant_values=255) for each in pictures]
        Image.fromarray(np.concatenate(padded)).save(sheet)


if __name__ == "__main__":
    main()
