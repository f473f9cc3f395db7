"""Shapes in other words: what the server makes of a stroke, an outline and a form, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from app_server import Server, server_fixture  # noqa: F401  (fixture)

from warpvec.app.reshaping import SHAPES_MAX, reshape
from warpvec.flat.simplification.outline_samples import control_points
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, RECT, ROUND_RECT
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

CANVAS = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 120 90" width="120" height="90">'
    '<rect id="background" width="120" height="90" fill="#fff"/><g id="layer-1">{}</g></svg>'
)
STROKE = CANVAS.format(
    '<path fill="none" stroke="#000" stroke-width="10" stroke-linecap="round" stroke-linejoin="round" '
    'd="M20 25c30 0 50 40 80 40"/>'
)


def filled(data: str) -> str:
    return CANVAS.format(f'<path fill="#000" d="{data}"/>')


def scene_of(answer: dict[str, object]) -> Scene:
    return read_svg(str(answer["svg"])).scene


def form_of(answer: dict[str, object]) -> tuple[int, list[float]]:
    forms = scene_of(answer).forms
    assert isinstance(forms, Forms) and len(forms.kind) == 1
    return int(forms.kind[0]), forms.parameters[0].tolist()


def test_a_stroke_becomes_its_outline_and_the_outline_a_stroke() -> None:
    (outline,) = reshape([STROKE], "outline")
    assert scene_of(outline).strokes is None
    assert psnr(draw(str(outline["svg"])), draw(STROKE)) > 40
    (back,) = reshape([str(outline["svg"])], "stroke")
    strokes = scene_of(back).strokes
    assert strokes is not None and strokes.width.tolist() == pytest.approx([10], abs=0.05)
    assert 'stroke-linecap="round"' in str(back["svg"])
    assert psnr(draw(str(back["svg"])), draw(STROKE)) > 40


def test_what_is_no_stroke_is_refused() -> None:
    blob = filled("M20 20c20-20 60-10 80 10s-10 40-40 35-60-25-40-45z")
    assert "no stroke" in str(reshape([blob], "stroke")[0]["refused"])
    assert "already" in str(reshape([STROKE], "stroke")[0]["refused"])
    assert "already" in str(reshape([blob], "outline")[0]["refused"])


ROUND = "M20 45c0-16.6 13.4-30 30-30s30 13.4 30 30-13.4 30-30 30-30-13.4-30-30z"
LEVEL = "M20 20h60v41h-60z"
ROUNDED = "M30 20h40c5.5 0 10 4.5 10 10v21c0 5.5-4.5 10-10 10h-40c-5.5 0-10-4.5-10-10v-21c0-5.5 4.5-10 10-10z"


@pytest.mark.parametrize(
    ("data", "to", "kind", "parameters"),
    [
        (ROUND, "circle", CIRCLE, [50, 45, 30]),
        (ROUND, "ellipse", ELLIPSE, [50, 45, 30, 30]),
        (LEVEL, "rect", RECT, [50, 40.5, 60, 41, 0, 0]),
        (ROUNDED, "rect", ROUND_RECT, [50, 40.5, 60, 41, 0, 10]),
        ("M60 10l40 30l-18 24l-40-30z", "rect", RECT, [71, 37, 50, 30]),
    ],
)
def test_the_nearest_form_is_found(data: str, to: str, kind: int, parameters: list[float]) -> None:
    (answer,) = reshape([filled(data)], to)
    found, numbers = form_of(answer)
    assert found == kind
    assert numbers[: len(parameters)] == pytest.approx(parameters, abs=0.15)
    assert float(str(answer["distance"])) < 0.15


def test_the_distance_says_how_far_a_form_is_off() -> None:
    egg = filled("M20 45c0-20 13-35 30-35s30 15 30 35-13 25-30 25-30-5-30-25z")
    (answer,) = reshape([egg], "circle")
    x, y, radius = form_of(answer)[1][:3]
    t = np.linspace(0, 1, 200)[:, None, None]
    a, b, c, d = control_points(read_svg(egg).scene).transpose(1, 0, 2)
    points = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
    gaps = np.abs(np.hypot(points[..., 0] - x, points[..., 1] - y) - radius)
    assert float(str(answer["distance"])) == pytest.approx(gaps.max(), abs=0.05)


def test_an_open_stroke_becomes_a_closed_form_with_its_look() -> None:
    arc = STROKE.replace("M20 25c30 0 50 40 80 40", "M20 45c0-16.6 13.4-30 30-30s30 13.4 30 30")
    (answer,) = reshape([arc], "circle")
    assert form_of(answer)[1][:3] == pytest.approx([50, 45, 30], abs=0.1)
    strokes = scene_of(answer).strokes
    assert strokes is not None and strokes.width.tolist() == [10]


def test_shapes_without_such_a_form_are_refused() -> None:
    assert reshape([filled(LEVEL)], "circle")[0] == {"refused": "This shape is too unlike a circle."}
    ring = filled(ROUND + "M30 45c0 11 9 20 20 20s20-9 20-20-9-20-20-20-20 9-20 20z")
    assert "more than one outline" in str(reshape([ring], "circle")[0]["refused"])


def test_the_server_answers_and_names_what_is_wrong(server: Server) -> None:
    answer = server.post("reshape?to=circle", {"shapes": [filled(ROUND), filled(LEVEL)]})
    assert answer.status_code == 200
    assert ["refused" in shape for shape in answer.json()["shapes"]] == [False, True]
    for to, body, words in [
        ("star", {"shapes": []}, "must be one of outline"),
        ("circle", {"shapes": "no"}, "must be a list"),
        ("circle", {"shapes": ["<svg"]}, "SVG"),
        ("circle", {"shapes": [filled(ROUND)] * (SHAPES_MAX + 1)}, "at most"),
    ]:
        answer = server.post(f"reshape?to={to}", body)
        assert answer.status_code == 422 and words in answer.text, to


def test_an_area_is_cut_out_of_a_shape() -> None:
    square, half, away = (filled(f"M{left} 20h40v40h-40z") for left in (20, 40, 80))
    left, same, gone = reshape([square, half, square, away, square, filled("M0 0h120v90h-120z")], "cut")
    assert np.array_equal(draw(str(left["svg"])), draw(filled("M20 20h20v40h-20z")))
    assert (same, gone) == ({"same": True}, {"gone": True})
    (line,) = reshape([STROKE, filled("M0 0h60v90h-60z")], "cut")
    rest = draw(str(line["svg"]))
    assert rest[:, :60].min() == 255
    assert np.array_equal(rest[:, 64:] < 128, draw(STROKE)[:, 64:] < 128)
