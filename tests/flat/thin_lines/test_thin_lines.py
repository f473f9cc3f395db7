"""Straight thin lines: each line of a hatch, a grid or a staff is one stroke, and what it crosses stays whole."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from warpvec.arrays import Floats, Floats32
from warpvec.flat.thin_lines.thin_lines import PlacedLines, ThinLines, find_thin_lines
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw

WIDTH, HEIGHT = 160, 120


def _picture(elements: str, paper: str = "#fff") -> Floats32:
    size = f'width="{WIDTH}" height="{HEIGHT}"'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><rect {size} fill="{paper}"/>{elements}</svg>'
    return (draw(text, WIDTH, HEIGHT) / 255.0).astype(np.float32)


def _hatch(angle: float, distance: float) -> Floats:
    """Return the ends [n, 2, 2] of lines of 60 px around the middle, at an ``angle`` in degrees."""
    along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    across = np.array([-along[1], along[0]])
    middles = np.array([WIDTH, HEIGHT]) / 2.0 + (distance * np.arange(-5, 6) + 0.3)[:, None] * across
    return np.stack([middles - 30.0 * along, middles + 30.0 * along], 1)


def _elements(ends: Floats, width: float, color: str) -> str:
    line = '<line x1="{:.3f}" y1="{:.3f}" x2="{:.3f}" y2="{:.3f}" stroke="{}" stroke-width="{}"/>'
    return "".join(line.format(*each.ravel(), color, width) for each in ends)


def _ends(found: ThinLines) -> Floats:
    """Return the ends [n, 2, 2] of all lines."""
    return found.lines.scene.segments[:, 0].double().numpy().reshape(-1, 2, 2)


def _off(found: Floats, given: Floats) -> Floats:
    """Return how far the ends of the nearest line found are from those of each line that was given [n]."""
    apart = np.abs(found[:, None] - given).max((2, 3))
    turned = np.abs(found[:, ::-1][:, None] - given).max((2, 3))
    return np.asarray(np.minimum(apart, turned).min(0))


@pytest.mark.parametrize("angle", [0.0, 20.0, 45.0, 70.0, 90.0])
@pytest.mark.parametrize("width", [0.5, 0.8, 1.2])
def test_each_line_of_a_hatch_is_found_once_at_its_place(angle: float, width: float) -> None:
    given = _hatch(angle, 3.0)
    # A mark shows the ink: that of lines thinner than a pixel can be told by nothing else.
    found = find_thin_lines(_picture(_elements(given, width, "#123") + '<rect width="9" height="9" fill="#123"/>'), 512)
    assert found is not None
    assert len(_ends(found)) == len(given)
    assert _off(_ends(found), given).max() < 0.6
    assert found.lines.scene.strokes is not None
    (common,) = set(found.lines.scene.strokes.width.tolist())
    assert common == pytest.approx(width, abs=0.06)
    assert (255.0 * found.lines.scene.color[0]).round().tolist() == [0x11, 0x22, 0x33]


def test_lines_that_meet_a_frame_at_an_acute_angle_end_on_it() -> None:
    """Near the frame, its ink seems to bend them."""
    slope = math.tan(math.radians(15.0))
    tops = 24.0 + 9.0 * np.arange(12) / math.cos(math.radians(15.0))
    ends = [[[x, 10.0], [min(x + 100.0 * slope, 140.0), min(110.0, 10.0 + (140.0 - x) / slope)]] for x in tops]
    frame = '<path d="M20 10h120v100h-120z" fill="none" stroke="#123" stroke-width="2"/>'
    given = np.array([end for end in ends if end[1][1] > 30.0])
    found = find_thin_lines(_picture(_elements(given, 1.2, "#123") + frame), 512)
    assert found is not None
    assert len(_ends(found)) == len(given)
    assert _off(_ends(found), given).max() < 4.0  # a pixel across the frame is four along a line


def test_diagonal_lines_do_not_stick_out_of_their_frame() -> None:
    """Where the ink of the frame stands beside a line that has ended, the line does not go on."""
    ends = [[[40.3 + k, 10.0], [140.0, 109.7 - k]] for k in range(0, 80, 9)]
    frame = '<path d="M20 10h120v100h-120z" fill="none" stroke="#123" stroke-width="2"/>'
    found = find_thin_lines(_picture(_elements(np.array(ends), 1.2, "#123") + frame), 512)
    assert found is not None
    least, most = _ends(found).min((0, 1)), _ends(found).max((0, 1))
    assert (least > [18.4, 8.4]).all() and (most < [141.6, 111.6]).all()


def test_an_axis_below_bars_is_one_line_and_a_frame_is_none() -> None:
    """Between the bars, an axis between two rows of pixels looks like pieces of a grey line of two pixels."""
    bars = "".join(f'<path d="M{x} 100V40l12 -6l1 66z" fill="#48b" stroke="#000"/>' for x in range(20, 130, 20))
    axes = np.array([[[10.0, 100.0], [150.0, 100.0]], [[10.0, 10.0], [10.0, 100.0]]])
    found = find_thin_lines(_picture(_elements(axes, 1.0, "#000") + bars), 512)
    assert found is not None
    assert _off(_ends(found), axes).max() < 0.6
    frame = '<path d="M10 10h140v100h-140z" fill="none" stroke="#000"/>'
    assert find_thin_lines(_picture(frame), 512) is None


def test_the_lines_of_a_grid_go_through_crossings() -> None:
    columns = np.array([[[20.3 + 8.0 * k, 12.0], [20.3 + 8.0 * k, 108.0]] for k in range(15)])
    rows = np.array([[[20.3, 12.0 + 8.0 * k], [132.3, 12.0 + 8.0 * k]] for k in range(13)])
    given = np.concatenate([columns, rows])
    found = find_thin_lines(_picture(_elements(given, 0.6, "#48a")), 512)
    assert found is not None
    assert len(_ends(found)) == len(given)
    assert _off(_ends(found), given).max() < 0.2
    assert np.abs(found.ground - 1.0).max() < 0.01


def test_a_shape_that_lines_cross_stays_whole() -> None:
    shape = '<circle cx="80" cy="60" r="20" fill="#c22"/>'
    lines = _elements(_hatch(0.0, 9.0), 0.7, "#333")
    found = find_thin_lines(_picture(lines + shape), 512)
    assert found is not None
    off = 255.0 * np.abs(found.ground - _picture(shape)).max(2)
    # Its edge, where a line ends below it, is known to a part of a pixel only.
    assert (off > 40.0).sum() <= 2 * 2 * 6
    assert off[45:75, 70:90].max() < 3.0


def test_arcs_edges_letters_and_frames_are_no_thin_lines() -> None:
    arcs = "".join(f'<circle cx="50" cy="60" r="{r}" fill="none" stroke="#000" stroke-width="0.8"/>' for r in (20, 40))
    blocks = "".join(
        f'<rect x="{100 + 14 * k}" y="20" width="9" height="60" fill="#68a" stroke="#024"/>' for k in (0, 1, 2)
    )
    assert find_thin_lines(_picture(arcs + blocks), 512) is None


def test_hatching_on_a_colored_paper_is_found() -> None:
    given = _hatch(45.0, 5.0)
    found = find_thin_lines(_picture(_elements(given, 0.7, "#fff"), "#1e4d8b"), 512)
    assert found is not None
    assert len(_ends(found)) == len(given)
    assert (255.0 * np.median(found.ground, (0, 1))).round().tolist() == [0x1E, 0x4D, 0x8B]


def _rect(x: int, y: int, width: int, height: int, color: str) -> str:
    return f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="{color}"/>'


def test_a_line_over_several_colors_is_one_stroke_whose_color_they_tell() -> None:
    given = np.array([[[10.0, 15.3 + 20.0 * k], [150.0, 15.3 + 20.0 * k]] for k in range(5)])
    bars = _rect(30, 8, 30, 104, "#47a") + _rect(90, 8, 40, 104, "#e93")
    found = find_thin_lines(_picture(bars + _elements(given, 0.8, "#999")), 512)
    assert found is not None
    above = found.above.scene
    assert above.strokes is not None
    assert _off(above.segments[:, 0].double().numpy().reshape(-1, 2, 2), given).max() < 0.2
    assert np.abs(255.0 * above.color.numpy() - 0x99).max() < 4.0
    assert above.strokes.width.tolist() == pytest.approx([0.8] * len(above), abs=0.03)
    assert 255.0 * np.abs(found.ground - _picture(bars)).max() < 4.0


def test_the_lines_of_a_table_with_striped_rows_have_one_look() -> None:
    stripes = "".join(_rect(16, 10 + 16 * k, 128, 16, "#e8eefc") for k in (1, 3, 5))
    rows = np.array([[[16.0, 10.5 + 16.0 * k], [144.0, 10.5 + 16.0 * k]] for k in range(7)])
    columns = np.array([[[16.5 + 32.0 * k, 10.0], [16.5 + 32.0 * k, 106.0]] for k in range(5)])
    found = find_thin_lines(_picture(stripes + _elements(np.concatenate([rows, columns]), 1.0, "#557")), 512)
    assert found is not None
    above = found.above.scene
    assert above.structure.loop_count == len(rows) + len(columns)
    assert above.strokes is not None
    assert set(above.strokes.width.tolist()) == {1.0}
    assert len({tuple(color) for color in above.color.tolist()}) == 1


def _block(left: float, top: float, right: float, bottom: float) -> Scene:
    ends = torch.tensor([[left, top], [right, top], [right, bottom], [left, bottom], [left, top]])
    corners = torch.stack([ends[:-1] + k * ends.diff(dim=0) / 3.0 for k in range(3)], 1).reshape(1, 12, 2)
    one = torch.ones(1)
    return Scene.uniform(corners, torch.zeros(1, 3), one, torch.ones(3), torch.zeros(1, dtype=torch.int64))


def test_lines_lie_right_above_the_lowest_shapes_that_show_them() -> None:
    below, above, lines = _block(2, 5, 20, 25), _block(24, 5, 38, 25), _block(0, 5, 40, 25)
    places = np.stack(np.meshgrid(np.arange(2.5, 20.0, 2.0), np.arange(5.5, 25.0, 2.0)), -1).reshape(-1, 2)
    found = PlacedLines(lines, places).within(below.joined(above), 30, 40)
    assert found.segments.tolist() == below.joined(lines).joined(above).segments.tolist()


def test_lines_on_the_paper_lie_above_a_shape_in_its_color_and_below_one_that_hides_them() -> None:
    block = '<rect x="80" y="40" width="9" height="40" fill="#c22"/>'
    found = find_thin_lines(_picture(_elements(_hatch(0.0, 5.0), 0.8, "#123") + block), 512)
    assert found is not None
    shapes = _block(0, 0, WIDTH, HEIGHT).joined(_block(80, 40, 89, 80))
    drawn = found.with_scene(shapes)
    count = len(found.lines.scene)
    assert drawn.segments[:4].tolist() == shapes.segments[:4].tolist()
    assert len(drawn) == 2 + count and drawn.segments[-4:].tolist() == shapes.segments[-4:].tolist()
