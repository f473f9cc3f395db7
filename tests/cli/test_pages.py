"""Pages of files, widths in the world, and SVGs that are given as pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from commands import assert_refused, invoke
from PIL import Image, TiffImagePlugin

import warpvec
from warpvec.svg.document import parse_svg

SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30"><rect width="40" height="15" fill="#c02030"/></svg>'
)


def picture(color: str) -> Image.Image:
    pixels = np.full((24, 32, 3), 255, np.uint8)
    pixels[6:18, 8:24] = Image.new("RGB", (1, 1), color).getpixel((0, 0))
    return Image.fromarray(pixels)


def geotiff(path: Path, meters: float) -> None:
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags[33550], tags[34735] = (meters / 32, meters / 32, 0.0), (1, 1, 0, 1, 3076, 0, 1, 9001)
    tags.tagtype.update({33550: 12, 34735: 3})
    picture("red").save(path, "TIFF", tiffinfo=tags)


def test_a_page_is_drawn_and_the_summary_says_which(tmp_path: Path) -> None:
    source = tmp_path / "scan.tif"
    picture("red").save(source, "TIFF", save_all=True, append_images=[picture("blue")])
    for page, color in (("1", "#ff0000"), ("2", "#0000ff")):
        done = invoke("run", source, tmp_path / "out.svg", "--page", page)
        assert color in (tmp_path / "out.svg").read_text().lower()
        assert f"not kept: all but page {page} of 2" in done.stdout
    assert_refused(invoke("run", source, tmp_path / "out.svg", "--page", "3"), "--page must be at most 2", "got 3")
    assert "#0000ff" in warpvec.vectorize(source, page=2).svg().lower()
    refined = invoke("refine", source, tmp_path / "b.svg", "--from", tmp_path / "out.svg", "--page", "2")
    assert "page 2 of 2" in refined.stdout


@pytest.mark.parametrize(
    ("meters", "width", "words"), [(90.0, "90000mm", "90 m"), (5120.0, "32", "512mm draws it 1 : 10,000")]
)
def test_a_geotiff_gives_the_width_unless_that_is_too_large(
    tmp_path: Path, meters: float, width: str, words: str
) -> None:
    source, out = tmp_path / "map.tif", tmp_path / "map.svg"
    geotiff(source, meters)
    assert words in invoke("run", source).stdout
    assert parse_svg(out.read_text()).root["width"] == width
    invoke("run", source, out, "--size", "100%")
    assert parse_svg(out.read_text()).root["width"] in ("32", "32px")


def test_an_svg_is_drawn_only_if_asked(tmp_path: Path) -> None:
    source, out = tmp_path / "drawing.svg", tmp_path / "traced.svg"
    source.write_text(SVG)
    for arguments in ((source,), (source, out)):
        assert_refused(invoke("run", *arguments), "drawing already: see refine", "--from-svg")
    invoke("run", source, out, "--from-svg")
    text = out.read_text()
    assert 'width="40" height="30"' in text
    assert "#c02030" in text
    assert source.read_text() == SVG
    assert_refused(invoke("run", source, out, "--from-svg", "--page", "1"), "--from-svg")
