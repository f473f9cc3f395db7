"""Drawings with a size in real units, and files for print."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time
import zlib
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from children import limit
from PIL import Image
from short_fits import vectorize_briefly
from svg_files import skip_without_cairo

import warpvec
from warpvec.errors import InputError
from warpvec.image.metrics import psnr
from warpvec.sandbox import run
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.writers.registry import encode
from warpvec.writers.round_corners import with_round_paths

PHOTO = np.random.default_rng(3).integers(0, 256, (32, 48, 3), dtype=np.uint8)
POINTS_PER_MM = 72 / 25.4


@pytest.mark.parametrize(
    ("size", "sides"),
    [
        ("90mm", ("90mm", "60mm")), (" 1.5 IN ", ("1.5in", "1in")), ("1cm", ("1cm", "0.6667cm")),
        ("36pt", ("36pt", "24pt")), ("300px", ("300", "200")), ("12px", ("12", "8")), ("250%", ("120", "80")),
    ],
)  # fmt: skip
def test_the_size_is_that_of_the_root_and_the_view_box_stays(size: str, sides: tuple[str, str]) -> None:
    text = vectorize_briefly(PHOTO, size=size).svg()
    assert f'width="{sides[0]}" height="{sides[1]}" viewBox="0 0 48 32"' in text


def test_a_sized_drawing_is_measured_and_read_back_as_one_of_its_pixels() -> None:
    plain, sized = vectorize_briefly(PHOTO), vectorize_briefly(PHOTO, size="90mm")
    assert sized.metrics["psnr"] == pytest.approx(plain.metrics["psnr"], abs=1e-3)
    loaded = read_svg(sized.svg())
    assert (loaded.width, loaded.height, loaded.sides) == (48, 32, ("90mm", "60mm"))
    assert warpvec.refine(PHOTO, sized.svg(), iterations=0).svg() == sized.svg()
    assert 'width="12" height="8"' in warpvec.refine(PHOTO, sized.svg(), iterations=0, size="25%").svg()


def test_a_size_without_a_unit_is_refused_with_the_two_that_may_be_meant() -> None:
    with pytest.raises(InputError, match="size must have a unit.* got '90'; give 90mm or 90px"):
        vectorize_briefly(PHOTO, size="90")


@pytest.mark.parametrize("size", ["", "0mm", "-3cm", "3 feet", "1e3mm", "9999999999px", "99999999mm", 90, "mm", "5%%"])
def test_a_size_that_is_none_is_refused_in_one_line(size: object) -> None:
    with pytest.raises(InputError, match="size must be a width above 0 in mm, cm, in, pt, px or %"):
        vectorize_briefly(PHOTO, size=size)


def test_print_files_have_the_size_in_points(tmp_path: Path) -> None:
    skip_without_cairo()
    result = vectorize_briefly(PHOTO, size="90mm")
    result.save(tmp_path / "out.pdf")
    result.save(tmp_path / "out.EPS")
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", (tmp_path / "out.pdf").read_bytes())
    assert box is not None
    np.testing.assert_allclose(
        [float(side) for side in box.groups()], [90 * POINTS_PER_MM, 60 * POINTS_PER_MM], atol=0.01
    )
    assert (tmp_path / "out.EPS").read_bytes().startswith(b"%!PS-Adobe-3.0 EPSF")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.EPS", "out.pdf"]


def test_a_missing_extra_is_named_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cairosvg", None)
    with pytest.raises(InputError, match=r"unless CairoSVG is installed, which writes .pdf.*warpvec\[print\]"):
        encode("<svg/>", tmp_path / "out.pdf")
    assert encode("<svg/>", tmp_path / "out.svg") == b"<svg/>"


def test_no_folder_for_temporary_files_is_not_taken_for_a_missing_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python's search for a library writes a temporary file."""
    (tmp_path / "cairosvg.py").write_text("raise FileNotFoundError(2, 'No usable temporary directory found')")
    monkeypatch.delitem(sys.modules, "cairosvg", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(InputError, match="where no folder for temporary files can be written.*; set TMPDIR"):
        encode("<svg/>", tmp_path / "out.pdf")


SHAPES = """<svg xmlns="http://www.w3.org/2000/svg" width="240" height="160" viewBox="0 0 240 160">
<rect fill="#fff" width="240" height="160"/>
<ellipse fill="#27c" cx="120" cy="40" rx="30" ry="18" transform="rotate(30 120 40)"/>
<rect fill="#b3b" x="20" y="70" width="90" height="80" rx="40" transform="rotate(-10 65 110)"/>
<rect fill="none" stroke="#182" stroke-width="6" x="140" y="90" width="80" height="50" rx="20" ry="12"/>
<g fill="none" stroke="#c22" stroke-width="5" stroke-linecap="round" stroke-linejoin="bevel">
<path d="M20 20l30 30 10-35"/></g></svg>"""


def test_strokes_and_forms_are_drawn_by_cairo_as_by_resvg() -> None:
    skip_without_cairo()
    import cairosvg  # type: ignore[import-untyped]

    found = cairosvg.svg2png(bytestring=with_round_paths(SHAPES).encode(), scale=4)
    drawn = np.asarray(Image.open(BytesIO(found)).convert("RGB")).astype(int)
    assert np.abs(drawn - draw(SHAPES, 960, 640)).max() < 100  # an edge that is 0.1 px off at four times the size


def test_strokes_stay_strokes_in_pdf() -> None:
    skip_without_cairo()
    data = encode(SHAPES, "out.pdf")
    pages = [zlib.decompress(part) for part in re.findall(rb"FlateDecode.*?stream\r?\n(.*?)\r?\nendstream", data, re.S)]
    text = b"".join(pages)
    assert len(re.findall(rb"\bS\b", text)) == 2
    assert b"3.75 w" in text and b"1 J" in text and b"2 j" in text  # 5 px in points, round ends, cut-off corners


LAYERS = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
 width="120" height="80" viewBox="0 0 120 80"><rect id="background" width="120" height="80" fill="#eed"/>
<g id="red" inkscape:groupmode="layer" inkscape:label="1 red &#228;"><path fill="#d22" d="M10 10h60v50h-60z"/></g>
<g id="blue" inkscape:groupmode="layer" inkscape:label="2 blue"><path fill="#22d" fill-opacity=".5"
 d="M40 30h70v40h-70z"
/></g></svg>"""


def test_layers_are_those_of_the_pdf_and_look_the_same_together() -> None:
    skip_without_cairo()
    pikepdf = pytest.importorskip("pikepdf")
    data = encode(LAYERS, "out.pdf")
    pdf = pikepdf.open(BytesIO(data))
    layers = pdf.Root.OCProperties.OCGs
    assert [str(layer.Name) for layer in layers] == ["Background", "1 red \u00e4", "2 blue"]
    assert pdf.pages[0].Contents.read_bytes().count(b"/OC") == len(layers)
    assert [float(side) for side in pdf.pages[0].mediabox] == [0, 0, 90, 60]
    assert encode(LAYERS, "out.pdf") == data
    assert b"OCProperties" not in encode(SHAPES, "out.pdf")


@pytest.mark.skipif(shutil.which("pdftocairo") is None, reason="poppler-utils is not installed")
def test_poppler_draws_layers_as_resvg_does(tmp_path: Path) -> None:
    skip_without_cairo()
    (tmp_path / "a.pdf").write_bytes(encode(LAYERS, "a.pdf"))
    command = ["pdftocairo", "-png", "-r", "96", "-singlefile", tmp_path / "a.pdf", tmp_path / "a"]
    subprocess.run(command, check=True)
    drawn = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"))
    assert psnr(drawn, draw(LAYERS)) > 45.0


USES = "".join(f'<g id="a{i}">{10 * f"""<use xlink:href="#a{i - 1}"/>"""}</g>' for i in range(1, 10))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('<g id="a"><use xlink:href="#a"/></g>', "recursion"),
        ('<rect width="9" height="9" fill="rgb(1,2)"/>', "not enough values"),
        ('<rect width="9" height="9" opacity="x"/>', "could not convert"),
        (f'<rect id="a0" width="1" height="1"/>{USES}<use xlink:href="#a9"/>', "not done in 1 s"),
    ],
)
def test_drawings_that_cairo_cannot_write_in_time_are_refused(
    content: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    skip_without_cairo()
    monkeypatch.setattr(run, "MAX_SECONDS", 1.0 if "1 s" in words else limit(15.0))
    head = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="9" height="9">'
    with pytest.raises(InputError, match=f"must be one that CairoSVG can write as .pdf.*({words})"):
        encode(f"{head}{content}</svg>", "out.pdf")


PLACED = 'gradientUnits="userSpaceOnUse"'


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("pdftocairo") is None, reason="poppler-utils is not installed")
def test_poppler_makes_an_svg_of_translucent_gradients(tmp_path: Path) -> None:
    skip_without_cairo()
    stops = '<stop offset="0" stop-color="#d44"/><stop offset="1" stop-color="#26c" stop-opacity=".1"/>'
    text = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="160" height="80" viewBox="0 0 160 80"><defs>'
        f'<linearGradient id="g1" {PLACED} x1="20" y1="10" x2="75.5" y2="60">{stops}</linearGradient>'
        f'<radialGradient id="g2" {PLACED} cx="120" cy="40" r="30">{stops}</radialGradient></defs>'
        '<rect width="160" height="80" fill="#eed"/><rect fill="url(#g1)" x="10" y="10" width="60" height="60"/>'
        '<circle fill="url(#g2)" cx="120" cy="40" r="30"/></svg>'
    )
    (tmp_path / "a.pdf").write_bytes(encode(text, "a.pdf"))
    subprocess.run(["pdftocairo", "-svg", tmp_path / "a.pdf", tmp_path / "a.svg"], check=True)
    again = (tmp_path / "a.svg").read_text().replace('width="120pt" height="60pt"', 'width="160" height="80"')
    assert psnr(draw(again), draw(text)) > 35  # 15 where its units are not points


@pytest.mark.parametrize("method", ["svg2pdf", "svg2eps"])
def test_a_file_for_print_does_not_say_when_it_was_written(method: str) -> None:
    skip_without_cairo()
    from warpvec.writers.cairo_work import work

    (data,) = work(b'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><path d="M0 0H9V9z"/></svg>', method)
    dates = re.findall(rb"CreationDate[^\n]*", data)
    assert dates and not any(time.strftime("%Y").encode() in date for date in dates)
