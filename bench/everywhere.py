"""Draw our files by other programs, and compare with resvg: do they look the same everywhere?

    python bench/everywhere.py [FILES] [--environment FOLDER] [--program NAME] [--for NAME]

Without FILES it draws those of `bench/everywhere_files.py`. The programs and their versions stand in
`bench/everywhere_programs.py`; they are installed into a folder of their own, by default a temporary one. Programs of
Debian are taken as they are installed. The table is in dB (PSNR over white): above 43 dB the difference is that of
anti-aliasing alone; "-" is a program that is missing or fails. Small drawings are drawn at twice their size.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np
from everywhere_files import FILES
from everywhere_programs import PROGRAMS, installed, picture_of
from harness import markdown_table
from numpy.typing import NDArray

from warpvec.purposes.table import PURPOSES
from warpvec.purposes.texts import text_for
from warpvec.svg.measure import draw
from warpvec.writers.png import drawing_size
from warpvec.writers.registry import encode

_SMALL = 400
"""Sides in pixels below which a drawing is drawn at twice its size."""


def decibels(name: str, text: str, folder: Path, environment: Path, wanted: str | None = None) -> float | None:
    """Return how near a program draws ``text`` to resvg's picture of ``wanted``; None if it draws nothing."""
    sides = drawing_size(text)
    scale = 2.0 if max(sides) < _SMALL else 1.0
    size = (round(scale * sides[0]), round(scale * sides[1]))
    file = folder / f"drawing{PROGRAMS[name].suffix}"
    file.write_bytes(encode(text, file))
    drawn = picture_of(name, file, size, scale, environment)
    return None if drawn is None else _psnr(drawn, draw(wanted or text, *size))


def _psnr(drawn: NDArray[np.uint8], wanted: NDArray[np.uint8]) -> float:
    error = np.square((drawn.astype(float) - wanted) / 255.0).mean()
    return float(min(99.0, -10.0 * np.log10(error + 1e-12)))


@click.command()
@click.argument("files", nargs=-1, type=click.Path(exists=True, path_type=Path))
@click.option("--environment", type=click.Path(path_type=Path), help="Use this folder, as it is.")
@click.option("--program", "names", multiple=True, type=click.Choice(list(PROGRAMS)), help="Only this program.")
@click.option("--for", "purpose", type=click.Choice([*PURPOSES, "best"]), default="web", help="Make the files fit.")
def main(files: tuple[Path, ...], environment: Path | None, names: tuple[str, ...], purpose: str) -> None:
    """Draw FILES by other programs, and print the table."""
    names = names or tuple(PROGRAMS)
    texts = {file.stem: file.read_text() for file in files} or {name: make() for name, make in FILES.items()}
    with tempfile.TemporaryDirectory() as folder:
        if environment is None:
            environment = Path(folder) / "environment"
            environment.mkdir()
            installed(environment, list(names))
        rows, made = [], dict[tuple[str, str], str]()
        for name in names:
            chosen = PROGRAMS[name].purpose if purpose == "best" else purpose
            for title, text in texts.items():
                if (chosen, title) not in made:
                    made[chosen, title] = text_for(text, PURPOSES[chosen]).text
            found = (decibels(name, made[chosen, title], Path(folder), environment, texts[title]) for title in texts)
            rows.append([name, *("-" if each is None else f"{each:.1f}" for each in found)])
            click.echo(" ".join(rows[-1]), err=True)
    click.echo(markdown_table(["program", *texts], rows))


if __name__ == "__main__":
    main()
