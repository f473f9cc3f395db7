"""Lines of pictures become strokes with the designer's width, caps and joins; blobs, bars and letters do not."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from stroke_pictures import CONFIG, SIDE, drawn, lines_of, picture_of, stroke

from warpvec.fit.target import Target
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.strokes import candidates, recognition
from warpvec.flat.strokes.line_fitting import Rows
from warpvec.flat.strokes.stroke import Stroke
from warpvec.geometry.forms.registry import CIRCLE, ROUND_RECT
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import BUTT, MITER, ROUND
from warpvec.rendering.operator import render


def test_a_path_of_very_many_segments_is_not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = drawn(stroke("M20 30H110", 9), replace(CONFIG, strokes="off"))
    assert len(candidates.stroke_candidates(scene, 1)) == 1
    monkeypatch.setattr(candidates, "STROKES", replace(STROKES, segments_max=len(scene.segments) - 1))
    assert not candidates.stroke_candidates(scene, 1)


def test_a_hook_is_one_line_with_its_width_and_ends() -> None:
    scene = drawn(stroke("M20 100V50C20 20 70 20 70 50S110 80 110 40", 9))
    assert scene.strokes is not None and lines_of(scene) == len(scene) == 1
    assert float(scene.strokes.width) == pytest.approx(9.0, abs=0.05)
    assert (int(scene.strokes.cap), int(scene.strokes.join)) == (ROUND, ROUND)
    ends = scene.segments[[0, -1], 0]
    want = torch.tensor([[20.0, 100.0], [110.0, 40.0]])
    assert min((ends - want).abs().max(), (ends.flip(0) - want).abs().max()) < 0.15
    assert len(scene.segments) <= 6


def test_lines_that_meet_are_one_path_of_few_lines() -> None:
    scene = drawn(stroke("M16 40H112M64 40V112M30 80L98 94", 8))
    assert scene.strokes is not None and lines_of(scene) <= 4 and len(scene) == 1
    assert float(scene.strokes.width) == pytest.approx(8.0, abs=0.1)
    assert scene.structure.lines.all()


def test_rings_are_stroked_circles_and_rectangles() -> None:
    ring = '<circle cx="36" cy="40" r="22" fill="none" stroke="#123" stroke-width="7"/>'
    frame = '<rect x="20" y="82" width="84" height="32" rx="9" fill="none" stroke="#123" stroke-width="7"/>'
    scene = drawn(ring + frame)
    assert scene.forms is not None and sorted(scene.forms.kind.tolist()) == [CIRCLE, ROUND_RECT]
    assert scene.strokes is not None and scene.strokes.width.tolist() == pytest.approx([7.0, 7.0], abs=0.1)
    circle = scene.forms.parameters[scene.forms.kind == CIRCLE][0, :3]
    assert circle.tolist() == pytest.approx([36.0, 40.0, 22.0], abs=0.05)


def test_bars_and_sharp_corners_have_butt_caps_and_miters() -> None:
    scene = drawn(ARROW, replace(CONFIG, strokes="all"))
    assert scene.strokes is not None and lines_of(scene) == 1
    assert (int(scene.strokes.cap), int(scene.strokes.join)) == (BUTT, MITER)
    assert len(scene.segments) == 3


def test_wide_bars_stay_outlines_unless_a_round_pen_shows() -> None:
    assert drawn(ARROW).strokes is None
    ring = '<circle cx="64" cy="90" r="20" fill="none" stroke="#123" stroke-width="8"/>'
    assert drawn('<rect x="20" y="10" width="88" height="8" fill="#123"/>' + ring).strokes is None
    scene = drawn(stroke("M20 14H108", 8) + ring)
    assert scene.strokes is not None and lines_of(scene) == 2


ARROW = stroke("M20 104L64 24L108 104", 8, 'stroke-miterlimit="9"')

SHAPES = {
    "a blob": '<path d="M30 40C60 10 110 30 100 70S40 120 26 90S16 54 30 40z"/>',
    "a disc": '<circle cx="60" cy="64" r="40"/>',
    "a bar": '<rect x="20" y="50" width="60" height="30"/>',
    "a triangle": '<path d="M20 100L64 20l44 80z"/>',
    "a crescent": '<path d="M84 20a48 48 0 1 0 0 88a60 60 0 0 1 0-88z"/>',
    "a letter of thick and thin": '<path d="M20 110L56 18h14l36 92h-24L52 40l-26 70z"/>',
    "a ring that is thicker on one side": '<path d="M64 14a50 50 0 1 0 .1 0zM64 30a34 34 0 1 1-.1 0z"/>'
    '<circle cx="58" cy="62" r="34" fill="#fff"/>',
}


@pytest.mark.parametrize("name", SHAPES)
def test_other_shapes_are_no_strokes(name: str) -> None:
    assert drawn(SHAPES[name]).strokes is None


def test_a_candidate_that_is_no_stroke_spoils_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    found = recognition.stroke_candidates
    bar = Rows(np.array([[[40.0, 100.0]] * 3, [[80.0, 100.0]] * 3]), np.array([True, True]), True)

    def with_blob(scene: Scene, count: int, outline_width: float) -> dict[int, Stroke]:
        strokes = found(scene, count, outline_width)
        (blob,) = {*scene.generation.tolist()} - {own % count for own in strokes}
        return {**strokes, blob + count: Stroke([0], [bar], 12.0, ROUND, ROUND, [None])}

    monkeypatch.setattr(recognition, "stroke_candidates", with_blob)
    scene = drawn(SHAPES["a blob"].replace("<path", '<path fill="#bbb"') + stroke("M20 60C50 50 70 90 108 70", 6))
    assert scene.strokes is not None and sorted(scene.strokes.width.tolist()) == pytest.approx([0.0, 6.0], abs=0.1)


def test_a_part_that_is_no_stroke_spoils_no_other_of_its_color() -> None:
    blob = SHAPES["a blob"].replace("<path", '<path fill="#123" transform="scale(.5)"')
    scene = drawn(blob + stroke("M20 90C50 80 70 120 108 100", 6))
    assert scene.strokes is not None and sorted(scene.strokes.width.tolist()) == pytest.approx([0.0, 6.0], abs=0.1)


def test_strokes_can_be_turned_off() -> None:
    for changed in ({"strokes": "off"}, {"cutout": True}):
        assert drawn(stroke("M16 40H112", 8), replace(CONFIG, **changed)).strokes is None  # type: ignore[arg-type]


def test_a_line_reaches_a_little_beyond_a_crossing() -> None:
    scene = drawn(stroke("M16 90H112M64 20V95", 10))
    assert lines_of(scene) == 2
    assert float(scene.segments[..., 1].max()) == pytest.approx(95.0, abs=0.2)


def test_small_round_corners_stay_round() -> None:
    scene = drawn(stroke("M24 20V101a3 3 0 0 0 3 3H110", 12))
    assert lines_of(scene) == 1 and scene.structure.lines.tolist() == [True, False, True, True]


def test_a_line_gets_nodes_until_no_difference_shows() -> None:
    corners = "M16 10a2 2 0 0 1-2 2H6.828a2 2 0 0 0-1.414.586l-2.202 2.202A.71.71 0 0 1 2 14.286V4a2 2 0 0 1 2-2h10a2 2"
    shapes = f'<g transform="scale(6)">{stroke(corners + " 0 0 1 2 2z", 2)}</g>'
    scene = drawn(shapes)
    assert scene.strokes is not None and lines_of(scene) == len(scene) == 1
    image = render(scene, height=SIDE, width=SIDE).numpy()
    assert np.square(image - picture_of(shapes)).sum() < 10.0


def test_a_ring_that_a_line_touches_is_a_circle() -> None:
    scene = drawn(
        '<circle cx="40" cy="40" r="24" fill="none" stroke="#123" stroke-width="8"/>' + stroke("M40 64V118", 8)
    )
    assert lines_of(scene) == 2 and scene.forms is not None
    assert scene.forms.parameters[scene.forms.kind == CIRCLE][0, :3].tolist() == pytest.approx([40, 40, 24], abs=0.1)


def test_dots_beside_a_stroke_of_their_colour_are_circles() -> None:
    frame = '<rect x="20" y="20" width="88" height="80" rx="9" fill="none" stroke="#123" stroke-width="7"/>'
    dots = "".join(f'<circle cx="{x}" cy="60" r="6" fill="#123"/>' for x in (44, 64, 84))
    scene = drawn(frame + dots)
    assert scene.forms is not None and sorted(scene.forms.kind.tolist()) == [CIRCLE] * 3 + [ROUND_RECT]


def test_no_strokes_are_fitted_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, polish = [], recognition.polish

    def noted(target: Target, start: Scene, *arguments: Any, **options: Any) -> Any:
        begun.append((options["gain_min"], start.segments.numpy().tobytes()))
        return polish(target, start, *arguments, **options)

    monkeypatch.setattr(recognition, "polish", noted)
    never = replace(STROKES, hopeless=math.inf, detail_share=0.0, close_share=0.0)
    monkeypatch.setattr(recognition, "STROKES", never)  # so that all attempts are made
    drawn('<circle cx="64" cy="64" r="40" fill="none" stroke="black" stroke-width="8"/>')
    assert len(begun) == len(set(begun)) > 1
