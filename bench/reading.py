"""Measure how much of a picture's text its drawing keeps, as a program that reads text sees it.

    python bench/reading.py FOLDER DRAWINGS [--scale 2]

FOLDER has NAME_clean4x.png, the undamaged picture at four times its size, for each NAME.svg of DRAWINGS. Both are
read at ``--scale`` times the size of the picture, line by line where the clean one has text. Needs
`pip install rapidocr-onnxruntime`, whose wheel holds its weights.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterable
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from harness import markdown_table
from numpy.typing import NDArray
from PIL import Image

from warpvec.svg.measure import draw

Pixels = NDArray[np.uint8]

CLEAN_SCALE = 4
"""Size of the clean pictures, as a multiple of the size of the damaged ones."""

HEIGHTS = (10, 14)
"""Heights of text in pixels of the picture that part the rows of the table."""

MARGIN = 3
"""Pixels around a line of text that are read with it, at the size of the picture."""

BOX_SHARE = 0.8
"""Height of a font as a share of the height of the box around its line."""


class Line(NamedTuple):
    """A line of text: its characters, and the box [4] around it: left, top, right and bottom in pixels."""

    text: str
    box: tuple[float, float, float, float]


class Count(NamedTuple):
    """Characters of the clean pictures, and those of them that were read in the drawing too."""

    all: int
    read: int


def agreeing(clean: str, drawn: str) -> int:
    """Return how many characters of ``clean`` are in ``drawn`` in the same order; spaces do not count."""
    first, second = (text.replace(" ", "") for text in (clean, drawn))
    blocks = SequenceMatcher(None, first, second, autojunk=False).get_matching_blocks()
    return sum(block.size for block in blocks)


def lines_of(reader: Any, picture: Pixels) -> list[Line]:
    """Return the lines of text that ``reader`` finds in ``picture`` [h, w, 3]."""
    found, _ = reader(picture)
    lines = []
    for corners, text, _ in found or ():
        x, y = np.array(corners, np.float64).T
        lines.append(Line(text, (float(x.min()), float(y.min()), float(x.max()), float(y.max()))))
    return lines


def read_line(reader: Any, picture: Pixels, line: Line, margin: int) -> str:
    """Return the text of the part of ``picture`` [h, w, 3] where the clean picture has ``line``."""
    left, top, right, bottom = (round(side) for side in line.box)
    part = picture[max(0, top - margin) : bottom + margin, max(0, left - margin) : right + margin]
    found, _ = reader(part, use_det=False, use_cls=False)
    return str(found[0][0]) if found else ""


def counts(reader: Any, clean: Pixels, drawn: Pixels, scale: int) -> dict[str, Count]:
    """Return the characters of one picture by the height of their font."""
    result: dict[str, Count] = defaultdict(lambda: Count(0, 0))
    for line in lines_of(reader, clean):
        name = height_name(BOX_SHARE * (line.box[3] - line.box[1]) / scale)
        # Both are read in the same way.
        truth, text = (read_line(reader, picture, line, MARGIN * scale) for picture in (clean, drawn))
        before = result[name]
        result[name] = Count(before.all + len(truth.replace(" ", "")), before.read + agreeing(truth, text))
        if agreeing(truth, text) < len(truth.replace(" ", "")):
            click.echo(f"    {truth!r} was read as {text!r}")
    return result


def height_name(height: float) -> str:
    """Return the row of the table for text of a font of ``height`` pixels."""
    low, high = HEIGHTS
    return f"{high} px and more" if height >= high else f"{low} to {high} px" if height >= low else f"below {low} px"


def total(parts: Iterable[Count]) -> Count:
    """Return the sum of the ``parts``."""
    chosen = list(parts)
    return Count(sum(part.all for part in chosen), sum(part.read for part in chosen))


def _percent(count: Count) -> str:
    return f"{100.0 * count.read / count.all:.1f} % of {count.all}" if count.all else "-"


def _reader() -> Any:
    try:
        from rapidocr_onnxruntime import RapidOCR
    except ImportError:
        sys.exit("reading.py needs `pip install rapidocr-onnxruntime`")
    return RapidOCR(intra_op_num_threads=1, inter_op_num_threads=1)


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, path_type=Path))
@click.argument("drawings", type=click.Path(exists=True, path_type=Path))
@click.option("--scale", default=2, show_default=True, help="Size at which both are read, over that of the picture.")
def main(folder: Path, drawings: Path, scale: int) -> None:
    """Print the share of characters that agree, by picture and height."""
    reader, rows = _reader(), []
    names = [f"{HEIGHTS[1]} px and more", f"{HEIGHTS[0]} to {HEIGHTS[1]} px", f"below {HEIGHTS[0]} px"]
    every: list[dict[str, Count]] = []
    for path in sorted(drawings.glob("*.svg")):
        original = folder / f"{path.stem}_clean4x.png"
        if not original.exists():
            continue
        click.echo(path.stem)
        with Image.open(original) as image:
            size = image.width * scale // CLEAN_SCALE, image.height * scale // CLEAN_SCALE
            clean = np.asarray(image.convert("RGB").resize(size, Image.Resampling.BOX))
        found = counts(reader, clean, draw(path.read_text(encoding="utf-8"), *size), scale)
        every.append(found)
        rows.append([path.stem, *(_percent(found.get(name, Count(0, 0))) for name in names)])
    rows.append(["all", *(_percent(total(found.get(name, Count(0, 0)) for found in every)) for name in names)])
    click.echo(markdown_table(["picture", *names], rows))


if __name__ == "__main__":
    main()
