"""Draw lines of several colours: each is one stroke of its colour. Lines that cross it lie above."""

from __future__ import annotations

import numpy as np
import pytest
from line_pictures import picture

import warpvec
from warpvec.flat.lines.line import DrawnLine
from warpvec.flat.lines.pens import find_pens, with_pens_of
from warpvec.flat.strokes.line_fitting import Rows

METRO = """<g stroke-width="5"><path stroke="#e2001a" d="M10 30H70L118 78"/><path stroke="#0065ae" d="M30 10V118"/>
<path stroke="#ffd200" d="M10 100C60 100 60 50 118 50"/><path stroke="#8fd3f4" d="M60 118L100 10"/></g>"""
CHEMISTRY = """<g stroke-width="2"><path stroke="#000" d="M20 20L60 40M60 46L20 26M60 40V90"/>
<path stroke="#f00" d="M60 90L100 110"/><circle stroke="#f00" cx="108" cy="100" r="8"/>
<path stroke="#00f" d="M60 40L110 20"/></g>"""
PASTEL = """<g stroke-width="4"><path stroke="#f7c6d0" d="M10 20C60 0 60 60 118 30"/>
<path stroke="#c6e2f7" d="M10 60H118"/><path stroke="#d6f0c6" d="M10 90L118 110"/></g>"""


# Their colours are less than 0.08 apart in OKLab.
NEAR_PASTEL = """<g stroke-width="3"><path stroke="#ffc9de" d="M10 20C60 0 60 60 118 30"/>
<path stroke="#e2d1f9" d="M10 50L118 60"/><path stroke="#d3f5d0" d="M10 80H118"/>
<path stroke="#fff0b8" d="M10 100L118 110"/></g>"""


@pytest.mark.parametrize(("shapes", "count"), [(METRO, 4), (CHEMISTRY, 6), (PASTEL, 3), (NEAR_PASTEL, 4)])
def test_lines_keep_their_colours_and_are_one_stroke_each(shapes: str, count: int) -> None:
    scene = warpvec.vectorize(picture(shapes), mode="lines").scene
    assert len(scene) <= 1.3 * count
    wanted = {word for word in shapes.replace('"', " ").split() if word.startswith("#")}
    wanted = {"#" + "".join(2 * c for c in word[1:]) if len(word) == 4 else word for word in wanted}
    found = (255.0 * scene.color).round().int().tolist()
    levels = {tuple(int(word[k : k + 2], 16) for k in (1, 3, 5)) for word in wanted}
    assert all(min(max(abs(a - b) for a, b in zip(own, each, strict=True)) for each in levels) <= 6 for own in found)
    assert len({tuple(each) for each in found}) == len(levels)


def test_the_nearest_colours_share_a_pen_if_there_are_fewer() -> None:
    scene = warpvec.vectorize(picture(METRO), mode="lines", pens=3).scene
    found = {tuple(each) for each in (255.0 * scene.color).round().int().tolist()}
    assert len(scene) == 4 and len(found) == 3
    # The light blue line is drawn by the blue or the yellow pen, which are longer; red stays.
    assert any(red > 200 and green < 30 for red, green, _ in found)


def test_a_thin_frame_stays_closed_where_a_line_of_another_pen_touches_it() -> None:
    shapes = '<path stroke="#345" d="M20 30H100V90H20Z"/><path stroke="#c33" d="M60 90V118M60 30V10"/>'
    scene = warpvec.vectorize(picture(f'<g stroke-width="2">{shapes}</g>'), mode="lines").scene
    assert len(scene) == 3


def test_pens_come_in_painting_order() -> None:
    pens = find_pens(
        picture('<g stroke-width="6"><path stroke="#00c" d="M10 64H118"/><path stroke="#c00" d="M64 10V118"/></g>')
    )
    assert [int(pen.color.argmax()) for pen in pens] == [2, 0]
    assert pens[0].coverage[64, 10:118].min() > 0.9  # below the other one, too


def test_black_lines_of_any_width_have_no_pens() -> None:
    assert not find_pens(picture('<path d="M10 20H118" stroke-width="4"/><path d="M10 60L118 70" stroke-width=".6"/>'))
    assert not find_pens(np.random.default_rng(1).random((64, 64, 3), np.float32))


def test_dots_and_dashes_have_the_colours_of_the_pens_that_drew_the_lines() -> None:
    rows = Rows(np.zeros((2, 3, 2)), np.array([True, True]), True)

    def drawn(*colors: tuple[float, float, float]) -> list[DrawnLine]:
        return [DrawnLine(rows, 2.0, color=color) for color in colors]

    gray, red, pink, blue = (0.27, 0.27, 0.27), (0.8, 0.1, 0.1), (0.79, 0.12, 0.1), (0.1, 0.2, 0.9)
    assert [line.color for line in with_pens_of(drawn((0.0, 0.0, 0.0)), drawn(gray))] == [(0.0, 0.0, 0.0)]
    assert [line.color for line in with_pens_of(drawn(red), drawn(pink, blue))] == [red, blue]
    assert [line.color for line in with_pens_of([], drawn(gray))] == [gray]
