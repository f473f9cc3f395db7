"""The place of a picture's pixels in a document, compared with where resvg draws images."""

from __future__ import annotations

import numpy as np
import pytest
from inkscape_runs import document, png_link
from warpvec_placement import (  # type: ignore[import-not-found] # a script, found through inkscape_runs
    IDENTITY,
    Box,
    Size,
    compose,
    image_box,
    invert,
    is_identity,
    matrix_text,
    place_pixels,
)
from warpvec_refusal import Refusal  # type: ignore[import-not-found]

from warpvec.svg.resvg import rasterize

PIXELS = Size(30, 20)
VIEWPORT = Size(120, 90)

ALIGNS = ["xMinYMid", "xMidYMax", "xMaxYMin"]
ASPECTS = [
    None,
    "",
    "none",
    "none slice",
    "defer xMinYMax slice",
    "nonsense",
    *ALIGNS,
    "xMaxYMid slice",
    "xMidYMin slice",
]
BOXES = [
    {"x": "3", "y": "2.5", "width": "40", "height": "60"},
    {"x": "5mm", "y": "-.1in", "width": "25%", "height": "4pc"},
    {"y": "10%", "width": "2cm"},
    {"x": "+1e1", "height": "30pt"},
    {},
]


def _coverage(content: str) -> np.ndarray:
    return rasterize(document(content), 480, 360, transparent=True, sandboxed=False)[..., 3] / 255.0


def _attributes(values: dict[str, str]) -> str:
    return " ".join(f'{name}="{value}"' for name, value in values.items())


def _drawn_by_us(box: dict[str, str], aspect: str | None) -> str:
    frame = image_box(*(box.get(name) for name in ("x", "y", "width", "height")), PIXELS, VIEWPORT)
    matrix, is_cut = place_pixels(frame, PIXELS, aspect)
    edges = _attributes({name: str(value) for name, value in frame._asdict().items()})
    clip = f'<clipPath id="c"><rect {edges}/></clipPath>' if is_cut else ""
    group = '<g clip-path="url(#c)">' if is_cut else "<g>"
    return f'{clip}{group}<rect width="30" height="20" transform="{matrix_text(matrix)}"/></g>'


@pytest.mark.parametrize("box", BOXES, ids=str)
def test_pixels_are_where_resvg_draws_the_image(box: dict[str, str]) -> None:
    link = png_link(np.zeros((20, 30, 3), np.uint8))
    for aspect in ASPECTS:
        stated = {**box, **({} if aspect is None else {"preserveAspectRatio": aspect}), "xlink:href": link}
        expected = _coverage(f"<image {_attributes(stated)}/>")
        difference = np.abs(_coverage(_drawn_by_us(box, aspect)) - expected)
        assert expected.sum() > 50
        # With 4 pixels a unit, an edge is off by less than 0.08 units. resvg clips a "slice" twice, which shows.
        assert difference.max() < 0.3, aspect


def test_matrices_are_composed_and_undone_as_svg_nests_groups() -> None:
    outer, inner = (0.9, 0.3, -0.2, 0.8, 12.0, 3.0), (1.5, 0.0, 0.4, 0.7, -2.0, 8.0)
    nested = f'<g transform="{matrix_text(outer)}"><g transform="{matrix_text(inner)}">{{}}</g></g>'
    shape = '<rect width="20" height="30"/>'
    together = f'<g transform="{matrix_text(compose(outer, inner))}">{shape}</g>'
    assert np.abs(_coverage(nested.format(shape)) - _coverage(together)).max() < 0.01
    undone = f'<g transform="{matrix_text(invert(compose(outer, inner)))}">{shape}</g>'
    assert np.abs(_coverage(nested.format(undone)) - _coverage(shape)).max() < 0.01
    assert is_identity(compose(invert(outer), outer))
    assert not is_identity(inner)
    assert is_identity(IDENTITY)


@pytest.mark.parametrize("size", ["0", "-5", "3em", "wide", "4 5"])
def test_an_image_without_a_size_is_refused(size: str) -> None:
    with pytest.raises(Refusal, match="then try again"):
        image_box(None, None, size, "10", PIXELS, VIEWPORT)


def test_an_image_that_is_squeezed_to_a_line_is_refused() -> None:
    matrix, _ = place_pixels(Box(0, 0, 10, 20), PIXELS, "none")
    with pytest.raises(Refusal, match="squeezed to nothing"):
        invert(compose((1.0, 1.0, 1.0, 1.0, 0.0, 0.0), matrix))
