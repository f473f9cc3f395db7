"""Compare the text of drawings with the clean pictures, line by line, where the damaged picture has each line.

    python bench/text_place.py FOLDER DRAWINGS

FOLDER has NAME.png and NAME_clean4x.png, the undamaged picture at four times its size, for each NAME.svg of DRAWINGS.
A browser puts text on whole pixels, so that a line of a screenshot may lie 1.5 px from where the larger one has it.
Then sharp letters cost more than blurred ones, however true they are. The last columns say what the picture as a whole
has: the clean one itself with its text moved to where the damaged picture has it, the enlargement and the drawing.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
from harness import markdown_table
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from warpvec.svg.measure import draw

Pixels = NDArray[np.float64]
Box = tuple[slice, slice]

SCALE = 4
"""Size of the clean pictures, as a multiple of the size of the damaged ones."""

CONTRAST = 60.0
"""Least difference of levels within five pixels at an edge of a letter."""

GAP = (9, 41)
"""Rows and columns of the clean picture that join letters to a line."""

HEIGHT_MAX = 104
WIDTH_MIN = 40
"""Largest height and least width of a line in pixels of the clean picture."""

REACH = (8, 4)
"""Rows and columns of the clean picture that a line may be away, at most."""


class Line(NamedTuple):
    """A line of text: its box in the clean picture, and the box in which the damaged one has it."""

    box: Box
    found: Box


def lines_of(clean: Pixels, enlarged: Pixels) -> list[Line]:
    """Return the lines of text of the ``clean`` picture [h, w, 3], found again in the ``enlarged`` one of its size."""
    gray = clean.mean(2)
    is_edge = ndimage.maximum_filter(gray, 5) - ndimage.minimum_filter(gray, 5) > CONTRAST
    labels, _ = ndimage.label(ndimage.binary_dilation(is_edge, np.ones(GAP)))
    lines = []
    for rows, columns in ndimage.find_objects(labels):
        if rows.stop - rows.start <= HEIGHT_MAX and columns.stop - columns.start >= WIDTH_MIN:
            lines.append(Line((rows, columns), _nearest((rows, columns), clean, enlarged)))
    return lines


def _nearest(box: Box, clean: Pixels, enlarged: Pixels) -> Box:
    """Return the box of ``enlarged`` that is most like ``clean`` in ``box``, no farther away than `REACH`."""
    found: list[tuple[float, Box]] = []
    for down in range(-REACH[0], REACH[0] + 1):
        for right in range(-REACH[1], REACH[1] + 1):
            rows, columns = (
                slice(side.start + shift, side.stop + shift) for side, shift in zip(box, (down, right), strict=True)
            )
            inside = rows.stop <= len(clean) and columns.stop <= clean.shape[1]
            if rows.start >= 0 and columns.start >= 0 and inside:
                found.append((_error(enlarged[rows, columns], clean[box]), (rows, columns)))
    return min(found, key=lambda each: each[0])[1]


def _error(first: Pixels, second: Pixels) -> float:
    return float(((first - second) ** 2).mean())


def _decibels(error: float) -> str:
    return f"{10.0 * np.log10(255.0**2 / max(error, 1e-6)):.2f}"


def text_error(picture: Pixels, clean: Pixels, lines: list[Line]) -> float:
    """Return the mean square error of the ``lines`` of ``picture`` [h, w, 3] where the damaged picture has them."""
    sizes = [clean[line.box].size for line in lines]
    return float(np.average([_error(picture[line.found], clean[line.box]) for line in lines], weights=sizes))


def moved(clean: Pixels, lines: list[Line]) -> Pixels:
    """Return the ``clean`` picture [h, w, 3] with its ``lines`` where the damaged picture has them."""
    result = clean.copy()
    for line in lines:
        result[line.found] = clean[line.box]
    return result


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.argument("drawings", type=click.Path(exists=True, path_type=Path))
def main(folder: Path, drawings: Path) -> None:
    """Print the PSNR of the text, and of the whole picture, of each drawing."""
    rows = []
    for path in sorted(drawings.glob("*.svg")):
        names = folder / f"{path.stem}_clean4x.png", folder / f"{path.stem}.png"
        if not all(name.exists() for name in names):
            continue
        with Image.open(names[0]) as large, Image.open(names[1]) as small:
            size = large.size
            clean = np.asarray(large.convert("RGB"), np.float64)
            enlarged = np.asarray(small.convert("RGB").resize(size, Image.Resampling.BICUBIC), np.float64)
        drawn = draw(path.read_text(encoding="utf-8"), *size).astype(np.float64)
        lines = lines_of(clean, enlarged)
        if not lines:
            continue
        text = [_decibels(text_error(picture, clean, lines)) for picture in (enlarged, drawn)]
        whole = [_decibels(_error(picture, clean)) for picture in (moved(clean, lines), enlarged, drawn)]
        rows.append([path.stem, str(len(lines)), *text, *whole])
    titles = ["picture", "lines", "text: bicubic", "text: drawing", "whole: true text, moved", "bicubic", "drawing"]
    click.echo(markdown_table(titles, rows))


if __name__ == "__main__":
    main()
