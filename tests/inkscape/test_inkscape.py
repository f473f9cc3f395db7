"""The extension in Inkscape itself, on a virtual screen."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from commands import invoke
from flat_drawings import BLUE, RED, drawing, picture
from inkscape_runs import document, png_link, run_inkscape, why_no_screen, without_images
from PIL import Image
from scenes import circle

from warpvec.svg.resvg import rasterize

pytestmark = [pytest.mark.skipif(bool(why_no_screen()), reason=why_no_screen()), pytest.mark.slow]

PLACE = "translate(12 4) rotate(7) scale(.9 1.1)"
IMAGE = f'<g transform="{PLACE}"><image id="img" x="5" y="1mm" width="60" height="60" {{}}/></g>'

PIXELS_A_UNIT = 8


@pytest.fixture
def logo(tmp_path: Path) -> Path:
    """The file of a picture of two discs."""
    scene = drawing((RED, [circle(27.3, 30.1, 18.0)]), (BLUE, [circle(40.2, 38.6, 12.0)]))
    path = tmp_path / "logo.png"
    Image.fromarray((255.0 * picture(scene)).byte().numpy()).save(path)
    return path


@pytest.fixture
def profile(tmp_path: Path) -> Path:
    """The folder of a new user of Inkscape, who has installed the extension."""
    assert invoke("inkscape", "install", "--folder", tmp_path / "profile" / "extensions").exit_code == 0
    return tmp_path / "profile"


def drawn(text: str) -> np.ndarray:
    """Return the picture of an SVG over white, in levels."""
    size = 120 * PIXELS_A_UNIT, 90 * PIXELS_A_UNIT
    return rasterize(text, *size, sandboxed=False).astype(float)


def shift_between(image: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return by how many pixels (x, y) ``image`` must move to match ``other``, to first order."""
    down, right, _ = np.gradient(other)
    slopes = np.stack([right.ravel(), down.ravel()], 1)
    return np.linalg.lstsq(slopes, (image - other).ravel(), rcond=None)[0]


@pytest.mark.parametrize("is_linked", [False, True])
def test_a_trace_is_where_the_image_was_and_can_be_undone(
    logo: Path, profile: Path, tmp_path: Path, is_linked: bool
) -> None:
    pixels = np.asarray(Image.open(logo))
    link = "logo.png" if is_linked else png_link(pixels)
    path, traced, undone = (tmp_path / f"{name}.svg" for name in ("document", "traced", "undone"))
    path.write_text(document(IMAGE.format(f'xlink:href="{link}"')))
    run_inkscape(path, "select-by-id:img;org.warpvec.trace.noprefs", traced, profile)
    run_inkscape(path, "select-by-id:img;org.warpvec.trace.noprefs;undo", undone, profile)

    assert invoke("run", logo, tmp_path / "direct.svg", "--trim").exit_code == 0
    body = (tmp_path / "direct.svg").read_text().partition("<rect")[2].rpartition("</svg>")[0]
    nested = f'<svg x="5" y="1mm" width="60" height="60" viewBox="0 0 64 64" overflow="visible"><rect{body}</svg>'
    names = '<svg xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
    expected = drawn(document(f'<g transform="{PLACE}">{nested}</g>').replace("<svg ", names, 1))
    found = drawn(without_images(traced.read_text()))
    assert np.abs(shift_between(found, expected)).max() < 0.1
    assert np.abs(found - expected).max() < 16
    assert np.ptp(expected) > 200
    assert _shapes(undone) == _shapes(path)
    assert len(_shapes(traced)) > len(_shapes(path))


def _shapes(path: Path) -> list[tuple[str, str | None]]:
    """Return the kind and the place of each drawn element."""
    drawn_kinds = ("g", "image", "path", "rect")
    elements = ((element.tag.rpartition("}")[2], element) for element in ElementTree.parse(path).iter())
    return [(kind, element.get("id") if kind == "image" else None) for kind, element in elements if kind in drawn_kinds]
