"""Necks between two areas of a part, too narrow to be cut, go to the neighbours."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.flat.cutting.arrangement import arranged
from warpvec.flat.cutting.cutout import cut_out
from warpvec.svg.read import read_svg

SIDE = 64


@pytest.mark.parametrize(("gap", "is_kept"), [(0.1, False), (0.5, True)])
def test_two_areas_with_a_narrow_neck_become_two_outlines(gap: float, is_kept: bool) -> None:
    # The blue shape shows on the left and on the right of the red one, and as a strip of the width ``gap`` below it.
    svg = f"""<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}">
        <path d="M4,4H60V40H4Z" fill="#00f"/><path d="M4,40H60V60H4Z" fill="#0c0"/>
        <path d="M20,-2H44V{40 - gap}H20Z" fill="#f00"/></svg>"""
    cut = cut_out(read_svg(svg).scene, SIDE, SIDE).scene
    blue = cut.select((cut.color[:, 2] > 0.5).nonzero().flatten())
    assert blue.structure.loop_count == (1 if is_kept else 2)
    first, second = (float(value) for value in np.sort(blue.segments[:, 0, 0].unique().numpy())[[1, -2]])
    assert (first, second) == pytest.approx((20.0, 44.0), abs=0.2)


@pytest.mark.parametrize("turns", range(4))
def test_a_neck_has_a_line_across_each_end_wherever_the_outline_is_counted_from(turns: int) -> None:
    # The shape below shows on both sides of the upper one, and as a strip 0.1 px wide around its far end. In one of the
    # turns the first vertex of the outline lies within the strip.
    below = np.array([[19, 32], [20, 4], [60, 4], [60, 60], [20, 60]], float)
    above = np.array([[19.457, 22], [19.1, 32], [19.457, 42], [70, 42], [70, 22]], float)
    for _ in range(turns):
        below, above = (np.stack([SIDE - each[:, 1], each[:, 0]], 1) for each in (below, above))
    paths = "".join(
        f'<path d="M{"L".join(f"{x:.3f},{y:.3f}" for x, y in each)}Z" fill="{color}"/>'
        for each, color in ((below, "#00f"), (above, "#f00"))
    )
    scene = read_svg(f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}">{paths}</svg>').scene
    border = 4
    assert len(arranged(scene, SIDE, SIDE).cubics) == len(below) + len(above) + border + 2
