"""Paths of a document refined by the extension's script, with warpvec itself."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from commands import invoke
from inkscape_runs import document, png_link, run_script, why_no_scripts, without_images

from warpvec.svg.resvg import rasterize

pytest.importorskip("svgelements")
pytest.importorskip("pathops")
pytestmark = [pytest.mark.skipif(bool(why_no_scripts()), reason=why_no_scripts()), pytest.mark.slow]

SHAPES = """<linearGradient id="shade"><stop stop-color="#f22"/><stop offset="1" stop-color="#622"/></linearGradient>
<rect id="frame" x="10" y="10" width="48" height="44" style="fill:url(#shade)"/>
<path id="leaf" d="M20 20h20v20z" fill="#14a" transform="translate({shift} 0)"/>
<circle id="dot" r="{radius}" cx="44" cy="40" style="fill:#fc2"/>"""
"""Shapes in pixels of an image of 64 x 64."""

PLACE = "translate(12 -3) rotate(7) scale(.9 1.1)"


@pytest.fixture
def extension(tmp_path: Path) -> Path:
    """The folder of the installed extension."""
    invoke("inkscape", "install", "--folder", tmp_path)
    return tmp_path / "warpvec"


def picture(shapes: str, head: str = 'width="64" height="64"', side: int = 64) -> np.ndarray:
    """Return the picture of ``shapes`` over white."""
    return rasterize(document(shapes, head), side, side, sandboxed=False)


def placed(shapes: str) -> str:
    """Return a document with the true image, and above it ``shapes`` in a layer of other units."""
    link = png_link(picture(SHAPES.format(shift=0, radius=8)))
    image = f'<image id="img" x="5" width="64" height="64" xlink:href="{link}"/>'
    layer = f'<g opacity=".6" transform="translate(5 0) scale(.5)"><g id="layer" transform="scale(2)">{shapes}</g></g>'
    return document(f'<g transform="{PLACE}">{image}{layer}</g>', 'width="96" height="90" viewBox="0 0 96 90"')


def test_displaced_shapes_find_their_place(extension: Path, tmp_path: Path) -> None:
    path = tmp_path / "document.svg"
    path.write_text(placed(SHAPES.format(shift=1.6, radius=6.7)))
    refined, messages = run_script(extension, "warpvec_refine.py", path, "--id=layer", "--iterations=60")
    assert messages == ""
    wanted, before, after = (
        rasterize(without_images(text), 384, 360, sandboxed=False).astype(float)
        for text in (placed(SHAPES.format(shift=0, radius=8)), path.read_text(), refined)
    )
    assert np.square(after - wanted).mean() < 0.02 * np.square(before - wanted).mean()
    assert re.search(r'id="frame"[^>]*fill:url\(#refined-gradient\)', refined)
    assert re.findall(r'<(\w+) id="(frame|leaf|dot)"', refined) == [("path", name) for name in ("frame", "leaf", "dot")]


def test_only_the_selected_shape_changes(extension: Path, tmp_path: Path) -> None:
    path = tmp_path / "document.svg"
    path.write_text(placed(SHAPES.format(shift=1.6, radius=6.7)))
    refined, _ = run_script(extension, "warpvec_refine.py", path, "--id=dot", "--iterations=60")
    left = [
        re.search(f'<[a-z]+ id="{name}".*?>', text)[0]
        for name in ("frame", "leaf")
        for text in (path.read_text(), refined)
    ]
    assert left[0] == left[1]
    assert 'd="M20 20h20v20z"' in left[3]
    only_dot = placed(SHAPES.format(shift=1.6, radius=8))
    images = [rasterize(without_images(text), 384, 360, sandboxed=False).astype(float) for text in (only_dot, refined)]
    assert np.abs(images[0] - images[1]).max() < 64


def test_strokes_are_refused_and_perfect_paths_stay(extension: Path, tmp_path: Path) -> None:
    path = tmp_path / "document.svg"
    path.write_text(placed(f'<g stroke="red">{SHAPES.format(shift=0, radius=8)}</g>'))
    message = run_script(extension, "warpvec_refine.py", path, "--id=layer")[1]
    assert message == "Select paths with a fill and without a stroke, then try again.\n"
    path.write_text(placed(SHAPES.format(shift=0, radius=8)))
    refined, message = run_script(extension, "warpvec_refine.py", path, "--id=layer", "--iterations=2")
    assert message == "The paths stay as they are: warpvec found nothing better.\n"
    assert '<circle id="dot" r="8"' in refined
