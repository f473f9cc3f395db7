"""Draw our files by other programs, and compare with resvg: do they look the same everywhere?

    python bench/everywhere.py [FILES] [--environment FOLDER] [--program NAME]

Each program of `PROGRAMS` is installed in a version of its own into a virtual environment, by default a temporary one.
A new version is one line to change. Programs of Debian are taken as they are installed. The table is in dB (PSNR over
white): above 43 dB the difference is that of anti-aliasing alone; "-" is a program that is missing or fails.
"""

# ruff: noqa: E501
# The programs' own code stands in few long lines.

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from harness import markdown_table
from PIL import Image

from warpvec.purposes.table import PURPOSES
from warpvec.purposes.texts import text_for
from warpvec.svg.measure import draw
from warpvec.writers.png import drawing_size

_SECONDS = 120
"""Longest time for a drawing."""


@dataclass(frozen=True)
class Program:
    """A program that draws SVGs.

    Attributes:
        requirement: what pip installs, with its version; None for a program of the system.
        code: Python that draws ``svg`` as ``png`` of ``w`` x ``h`` pixels; or the words of a command, as such text.
    """

    requirement: str | None
    code: str


_MUPDF = "import fitz; d = fitz.open({data}, filetype='{kind}'); p = d[0]; m = fitz.Matrix(w / p.rect.width, h / p.rect.height)\n"
_PIXMAP = "p.get_pixmap(matrix=m).save(png)"

PROGRAMS = {
    "rsvg-convert": Program(None, "rsvg-convert -w {w} -h {h} -b white {svg} -o {png}"),
    "inkscape": Program(None, "inkscape {svg} -w {w} -h {h} -b white -o {png}"),
    "cairosvg": Program(
        "cairosvg==2.9.1",
        "import cairosvg; cairosvg.svg2png(url=svg, write_to=png, output_width=w, output_height=h, background_color='white')",
    ),
    "pymupdf": Program(
        "pymupdf==2.0", _MUPDF.format(data="stream=open(svg, 'rb').read()", kind="svg") + _PIXMAP
    ),
    "svglib": Program(
        "svglib==2.3.2 reportlab pymupdf==2.0",
        "from svglib.svglib import svg2rlg; from reportlab.graphics import renderPDF\n"
        "b = renderPDF.drawToString(svg2rlg(svg))\n" + _MUPDF.format(data="stream=b", kind="pdf") + _PIXMAP,
    ),
    "weasyprint": Program(
        "weasyprint==70.0 pymupdf==2.0",
        "import weasyprint\n"
        "html = f'<style>@page{{size:{w}px {h}px;margin:0}}body{{margin:0}}img{{display:block;width:{w}px;height:{h}px}}</style><img src=\"file://{svg}\">'\n"
        "b = weasyprint.HTML(string=html).write_pdf()\n" + _MUPDF.format(data="stream=b", kind="pdf") + _PIXMAP,
    ),
    "pygame": Program(
        "pygame-ce==2.5.8",
        "import pygame; s = pygame.image.load_sized_svg(svg, (w, h)); t = pygame.Surface((w, h)); t.fill('white'); "
        "t.blit(s, (0, 0)); pygame.image.save(t, png)",
    ),
    "typst": Program(
        "typst==0.15.2 pymupdf==2.0",
        "import typst, shutil, tempfile, os; d = tempfile.mkdtemp(); shutil.copy(svg, d + '/a.svg')\n"
        "open(d + '/a.typ', 'w').write(f'#set page(width: {w}pt, height: {h}pt, margin: 0pt)\\n#image(\"a.svg\", width: {w}pt)')\n"
        "b = typst.compile(d + '/a.typ')\n" + _MUPDF.format(data="stream=b", kind="pdf") + _PIXMAP,
    ),
    "skia": Program(
        "skia-python==144.0.post1",
        "import skia; t = skia.Surface(w, h); c = t.getCanvas(); c.clear(skia.ColorWHITE)\n"
        "d = skia.SVGDOM.MakeFromStream(skia.MemoryStream(open(svg, 'rb').read())); z = d.containerSize(); "
        "c.scale(w / z.width(), h / z.height()); d.render(c); t.makeImageSnapshot().save(png, skia.kPNG)",
    ),
    "qt": Program(
        "PySide6-Essentials==6.12.0",
        "import os; os.environ['QT_QPA_PLATFORM'] = 'offscreen'\n"
        "from PySide6.QtGui import QGuiApplication, QImage, QPainter; from PySide6.QtSvg import QSvgRenderer\n"
        "a = QGuiApplication([]); i = QImage(w, h, QImage.Format_ARGB32); i.fill('white'); p = QPainter(i); "
        "QSvgRenderer(svg).render(p); p.end(); i.save(png)",
    ),
}  # fmt: skip


def picture_of(program: Program, svg: Path, size: tuple[int, int], environment: Path) -> np.ndarray | None:
    """Return what a program draws [h, w, 3]; None if it is missing or fails."""
    with tempfile.TemporaryDirectory() as folder:
        png = Path(folder) / "drawn.png"
        values = {"svg": str(svg), "png": str(png), "w": size[0], "h": size[1]}
        if program.requirement is None:
            words = program.code.format(**values).split()
            if shutil.which(words[0]) is None:
                return None
        else:
            head = "".join(f"{name} = {value!r}\n" for name, value in values.items())
            words = [str(environment / "bin" / "python"), "-c", head + program.code]
        try:
            subprocess.run(words, check=True, capture_output=True, timeout=_SECONDS)
            with Image.open(png) as image:
                image = image.convert("RGBA")
                white = Image.new("RGBA", image.size, "white")
                drawn = Image.alpha_composite(white, image).convert("RGB").resize(size)
            return np.asarray(drawn)
        except (subprocess.SubprocessError, OSError):
            return None


def decibels(drawn: np.ndarray | None, wanted: np.ndarray) -> str:
    """Return the PSNR of two pictures as a cell of the table."""
    if drawn is None:
        return "-"
    error = np.square((drawn.astype(float) - wanted) / 255.0).mean()
    return "equal" if error == 0.0 else f"{-10.0 * np.log10(error):.1f}"


def installed(environment: Path, programs: dict[str, Program]) -> None:
    """Install the packages of ``programs`` into a virtual environment that is made if it is not there."""
    if not (environment / "bin" / "python").exists():
        subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
    wanted = sorted({word for each in programs.values() if each.requirement for word in each.requirement.split()})
    subprocess.run([str(environment / "bin" / "pip"), "install", "-q", *wanted], check=True)


@click.command()
@click.argument("files", nargs=-1, type=click.Path(exists=True, path_type=Path))
@click.option("--environment", type=click.Path(path_type=Path), help="Use this virtual environment as it is.")
@click.option("--program", "names", multiple=True, type=click.Choice(list(PROGRAMS)), help="Only this program.")
@click.option("--for", "purpose", default="web", type=click.Choice(list(PURPOSES)), help="Make the files fit first.")
def main(files: tuple[Path, ...], environment: Path | None, names: tuple[str, ...], purpose: str) -> None:
    """Draw FILES by other programs, and print the table."""
    programs = {name: PROGRAMS[name] for name in names or PROGRAMS}
    with tempfile.TemporaryDirectory() as folder:
        if environment is None:
            environment = Path(folder) / "environment"
            installed(environment, programs)
        rows = []
        for program_name, program in programs.items():
            row = [program_name]
            for file in files:
                text = file.read_text()
                width, height = map(round, drawing_size(text))
                made = Path(folder) / file.name
                made.write_text(text_for(text, PURPOSES[purpose]).text)
                row.append(decibels(picture_of(program, made, (width, height), environment), draw(text, width, height)))
            rows.append(row)
    click.echo(markdown_table(["program", *(file.stem for file in files)], rows))


if __name__ == "__main__":
    main()
