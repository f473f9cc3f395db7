"""Dashed lines: each is found once, with equal dashes in their places, and other marks are not."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.arrays import Floats
from warpvec.flat.thin_lines.dashes import DashedLine, without_dashes
from warpvec.geometry.strokes import BUTT, ROUND
from warpvec.svg.measure import draw

SIDE = 160
WHITE, INK = np.full(3, 255.0), np.array([30.0, 60.0, 200.0])


def _without(elements: str) -> tuple[Floats, list[DashedLine]]:
    size = f'width="{SIDE}" height="{SIDE}"'
    ink = '<g fill="rgb(30,60,200)" stroke="rgb(30,60,200)">'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><rect {size} fill="#fff"/>{ink}{elements}</g></svg>'
    return without_dashes(draw(text, SIDE, SIDE).astype(np.float64), WHITE, np.array([INK, WHITE]))


def _lengths(line: DashedLine) -> Floats:
    return np.array([np.linalg.norm(np.subtract(*dash.ends())) for dash in line.dashes])


@pytest.mark.parametrize("width", [1.0, 1.5, 3.0])
@pytest.mark.parametrize(("dashes", "cap"), [("7 4", "butt"), ("5 7.5", "round")])
@pytest.mark.parametrize("end", ["150.2 20.3", "150.2 120.7"])
def test_dashes_of_a_straight_line_are_equal_and_in_their_places(width: float, dashes: str, cap: str, end: str) -> None:
    element = f'<path d="M10.2 20.3L{end}" stroke-width="{width}" stroke-dasharray="{dashes}" stroke-linecap="{cap}"/>'
    rest, (line,) = _without(element)
    whole, gap = map(float, dashes.split())
    ends = np.array([dash.ends() for dash in line.dashes])
    way = np.subtract(np.array(end.split(), float), (10.2, 20.3))
    way /= np.linalg.norm(way)
    begins = np.sort((ends - (10.2, 20.3)) @ way, axis=1)[:, 0]
    # Of thin dashes nobody can tell the ends.
    has_ends = width > 1.0 or cap == "butt"
    longer = 0.0 if has_ends else np.pi / 4.0
    assert np.sort(begins) == pytest.approx((whole + gap) * np.arange(len(begins)) - longer / 2.0, abs=0.25)
    assert np.ptp(np.diff(np.sort(begins))[:-1]) < 0.01
    assert len(line.dashes) >= np.hypot(*np.subtract(np.array(end.split(), float), (10.2, 20.3))) // (whole + gap)
    assert _lengths(line)[1:-1] == pytest.approx(whole + longer, abs=0.25)
    assert len({dash.width for dash in line.dashes}) == 1
    assert line.dashes[0].width == pytest.approx(width, abs=0.15)
    assert not has_ends or {dash.cap for dash in line.dashes} == {ROUND if cap == "round" else BUTT}
    assert np.abs(rest - WHITE).max() < 12.0


def test_dash_dot_lines_along_a_curve_keep_both_lengths() -> None:
    shape = '<path d="M10 80C60 10 100 150 150 60" fill="none" stroke-width="2" stroke-dasharray="9 3 2 3"/>'
    rest, (line,) = _without(shape)
    lengths = np.round(_lengths(line), 1)
    assert len(np.unique(np.abs(lengths[1:-1:1] - lengths[1]) < 1.0)) == 2
    assert lengths[1:-1].max() == pytest.approx(9.0, abs=0.3)
    assert np.abs(rest - WHITE).sum() < 0.1 * len(lengths) * 255 * 9


def test_dashes_go_on_through_shapes_and_other_lines() -> None:
    crossing = '<path d="M8 60H154" stroke-dasharray="6 4"/><path d="M60 20V140M90 20V140" stroke-width="3"/>'
    _, (line,) = _without(crossing)
    assert len(line.dashes) == 15
    assert line.is_hidden.any()


@pytest.mark.parametrize(
    "marks",
    [
        '<path d="M20 20v9M20 33v9M20 50v9M20 80v9M20 93v9" stroke-width="2"/>',  # uneven
        '<path d="M20 20v9M28 20v9M36 20v9M44 20v9M52 20v9M60 20v9" stroke-width="2"/>',  # side by side
        '<path d="M20 20v9M20 33v9M20 46v9" stroke-width="2"/>',  # too few
    ],
)
def test_other_bars_are_no_dashed_lines(marks: str) -> None:
    assert _without(marks)[1] == []
