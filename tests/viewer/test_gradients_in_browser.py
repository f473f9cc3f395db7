"""The page with gradients, holes and straight lines: what it shows, edits and saves, in a real Chromium."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import torch
from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)

from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import ELLIPTIC, LINEAR, RADIAL
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.stops import Stops
from warpvec.geometry.structure import Structure
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

pytestmark = NEEDS_BROWSER

NS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
WIDTH, HEIGHT = 240, 160


def scene() -> Scene:
    """Return a square with a square hole and a linear gradient, a round one with a radial gradient, and a triangle."""
    outer, inner = [(10, 10), (110, 10), (110, 110), (10, 110)], [(35, 35), (35, 85), (85, 85), (85, 35)]
    triangle = [(60, 120), (160.25, 125), (110, 150.5)]
    loops = [corners(outer), corners(inner), circle(170, 60, 50), circle(170, 60, -20), corners(triangle)]
    is_line = torch.tensor([True] * 8 + [False] * 8 + [True] * 3)
    structure = Structure.of_loops([[4, 4], [4, 4], [3]], is_line)
    gradients = Gradients(
        torch.tensor([LINEAR, RADIAL, 0], dtype=torch.int32),
        torch.tensor([[20.5, 20, 100, 60], [170, 60, 45.5, 0], [0, 0, 0, 0]]),
        torch.tensor([[0, 0, 1.0], [0, 0.6, 0.4], [1, 0.8, 0]]),
    )
    color = torch.tensor([[1.0, 0, 0], [1, 1, 1], [1, 0.8, 0]])
    return Scene(
        straightened(torch.cat(loops), structure), structure, color, torch.tensor([1.0, 0.8, 1.0]),
        torch.full((3,), 0.6), torch.tensor([0, 0, 1]), gradients=gradients,
    )  # fmt: skip


def corners(points: list[tuple[float, float]]) -> torch.Tensor:
    return torch.tensor(points, dtype=torch.float32)[:, None].repeat(1, 3, 1)


def circle(x: float, y: float, r: float) -> torch.Tensor:
    """Return a circle, which runs the other way if ``r`` is negative."""
    angle = torch.arange(4) * torch.pi / 2 * (1 if r > 0 else -1)
    anchor = torch.stack([angle.cos(), angle.sin()], -1)
    tangent = 0.55 * anchor.roll(-1, 0)
    row = torch.stack([anchor, anchor + tangent, anchor.roll(-1, 0) + 0.55 * anchor], 1)
    return torch.tensor([x, y]) + abs(r) * row


DRAWING = write_svg(scene(), WIDTH, HEIGHT, title="Mixed", metadata={"seed": 7})

GRID = [(x, y) for x in range(5, WIDTH, 10) for y in range(5, HEIGHT, 10)]


def assert_shows(viewer: Viewer, svg: str) -> None:
    """Assert that the page shows what resvg draws for ``svg``, but for edges, where it may be anything in between."""
    image = draw(svg).astype(int)
    near = np.stack([np.roll(image, shift, (0, 1)) for shift in ((1, 0), (-1, 0), (0, 1), (0, -1))])
    is_flat = [np.abs(near[:, y, x] - image[y, x]).max() <= 6 for x, y in GRID]
    points = [point for point, flat in zip(GRID, is_flat, strict=True) if flat]
    assert len(points) > 0.8 * len(GRID)
    shown = np.array(viewer.colors([(x + 0.5, y + 0.5) for x, y in points]))
    assert np.abs(shown - image[[y for _, y in points], [x for x, _ in points]]).max() <= 6


def assert_same_scene(svg: str, expected: Scene) -> None:
    """Assert that ``svg`` is read exactly, as warpvec's own file, and is ``expected``."""
    loaded = read_svg(svg)
    assert loaded.precision is not None and not loaded.omitted
    want = read_svg(write_svg(expected, WIDTH, HEIGHT)).scene
    for name in ("segments", "color", "opacity", "background", "generation"):
        assert torch.equal(getattr(loaded.scene, name), getattr(want, name)), name
    for name in ("loop_first_segment", "path_first_loop", "is_line"):
        assert torch.equal(getattr(loaded.scene.structure, name), getattr(want.structure, name)), name
    gradients, others = loaded.scene.gradients, want.gradients
    assert gradients is not None and others is not None
    assert (gradients.stops is None) == (others.stops is None)
    values = {**others.to_dict(), **others.to_dict().pop("stops", {})}
    found = {**gradients.to_dict(), **gradients.to_dict().pop("stops", {})}
    for name in values.keys() - {"stops"}:
        assert torch.equal(found[name], values[name]), name


def test_stops_opacities_and_ellipses_are_shown_and_saved_as_they_are(open_page) -> None:
    plain = scene()
    assert plain.gradients is not None
    stops = Stops.two(plain.color)
    stops.count[:2] = torch.tensor([4, 3])
    stops.offset[0, 1:3], stops.offset[1, :2] = torch.tensor([0.25, 0.7]), torch.tensor([0.125, 0.5])
    stops.opacity[0, 1], stops.opacity[1, 2], stops.breadth[1] = 0.4, 0.625, 31.5
    stops.inner_color[0, :2] = torch.tensor([[0.2, 0.8, 0.4], [1.0, 1.0, 0.0]])
    paints = replace(plain.gradients, stops=stops)
    paints.kind[1], paints.geometry[1] = ELLIPTIC, torch.tensor([170, 60, 40.2, -25.5])
    drawing = write_svg(replace(plain, gradients=paints), WIDTH, HEIGHT)
    viewer = open_page(drawing)
    assert viewer.text("message") == ""
    assert_shows(viewer, drawing)
    saved = viewer.saved()
    assert saved[saved.index("<defs>") :] == drawing[drawing.index("<defs>") :]
    assert_same_scene(saved, replace(plain, gradients=paints))


def test_a_drawing_with_holes_lines_and_gradients_is_shown_and_saved_as_it_is(open_page) -> None:
    viewer = open_page(DRAWING)
    assert viewer.text("message") == ""
    assert_shows(viewer, DRAWING)
    saved = viewer.saved()
    body = saved[saved.index("<defs>") :]
    assert body == DRAWING[DRAWING.index("<defs>") :]
    assert_same_scene(saved, scene())


def test_holes_are_not_part_of_a_path(open_page) -> None:
    viewer = open_page(DRAWING)
    assert viewer.click(20, 60) == "1 of 3 paths selected: Pass 1"
    assert viewer.click(60, 60) == "Nothing selected"
    assert viewer.click(170, 60) == "Nothing selected"
    viewer.drag((5, 5), (115, 115))
    assert viewer.selected() == "1 of 3 paths selected: Pass 1"
    viewer.press("Delete")
    saved = viewer.saved()
    assert saved.count("<linearGradient") == 0 and saved.count("<radialGradient") == 1
    viewer.press("Control+z")
    assert_same_scene(viewer.saved(), scene())


def test_both_colours_of_a_gradient_are_changed_undone_and_saved_exactly(open_page) -> None:
    viewer = open_page(DRAWING)
    assert not viewer.page.locator("#end").is_visible()
    viewer.click(20, 60)
    assert (viewer.text("fill-text"), viewer.text("end-text")) == ("#ff0000", "#0000ff")
    viewer.slide("end", "#ffff00")
    viewer.click(135, 60)
    viewer.slide("fill", "#102030")
    assert (viewer.text("fill-text"), viewer.text("end-text")) == ("#102030", "#009966")
    expected = scene()
    expected.color[1] = torch.tensor([16, 32, 48]) / 255
    assert expected.gradients is not None
    expected.gradients.end_color[0] = torch.tensor([1.0, 1.0, 0.0])
    saved = viewer.saved()
    assert_same_scene(saved, expected)
    assert_shows(viewer, saved)
    viewer.press("Control+z", "Control+z")
    assert viewer.page.locator("#undo").is_disabled()
    assert_same_scene(viewer.saved(), scene())
    viewer.press("Control+Shift+z", "Control+Shift+z")
    assert viewer.saved() == saved
    # A flat path has one colour; together with a gradient it has the first.
    viewer.press("Escape")
    viewer.click(110, 140)
    assert not viewer.page.locator("#end").is_visible()
    viewer.press("Control+a")
    viewer.slide("fill", "#00ff00")
    viewer.slide("end", "#ff0000")
    assert re.findall(r'fill="(#[^"]*)"', viewer.saved())[1:] == ["#0f0"]
    assert re.findall(r'<stop[^>]*stop-color="([^"]*)"', viewer.saved()) == ["#0f0", "#f00"] * 2


def test_a_moved_path_keeps_its_lines_loops_and_gradient(open_page) -> None:
    viewer = open_page(DRAWING)
    viewer.press("Control+a", "Shift+ArrowRight", *["ArrowDown"] * 3)
    saved = viewer.saved()
    assert_same_scene(saved, scene().moved(10, 3))
    assert_shows(viewer, saved)
    viewer.press("Control+z")
    viewer.slide("scale", "50")
    viewer.press_button("scale-apply")
    assert_shows(viewer, viewer.saved())


def stretch(viewer: Viewer, start: tuple[float, float], stop: tuple[float, float]) -> None:
    """Drag a corner of the selection without keeping the proportions."""
    viewer.page.mouse.move(*viewer.at(*start))
    viewer.page.mouse.down()
    viewer.page.keyboard.down("Shift")
    viewer.page.mouse.move(*viewer.at(*stop), steps=4)
    viewer.page.mouse.up()
    viewer.page.keyboard.up("Shift")
    viewer.settle()


def test_a_gradient_follows_a_drag_and_stretches_with_its_path(open_page) -> None:
    viewer = open_page(DRAWING)
    viewer.click(135, 60)
    stretch(viewer, (220, 110), (236, 70))  # the circle and its gradient become ellipses
    saved = viewer.saved()
    assert "gradientTransform" in saved
    assert_shows(viewer, saved)
    viewer.press("Control+z")
    viewer.click(20, 60)
    stretch(viewer, (110, 110), (110, 60))
    assert_shows(viewer, viewer.saved())


FOREIGN = f"""<svg {NS} viewBox="0 0 240 160" width="240">
<defs><linearGradient id="stops"><stop offset="0" stop-color="#fff"/><stop offset="30%" style="stop-color:#e63"/>
<stop offset="1" stop-color="#024" stop-opacity=".5"/></linearGradient>
<linearGradient id="turned" xlink:href="#stops" gradientTransform="rotate(30)"/>
<radialGradient id="focal" href="#stops" cx="180" cy="45" r="38" fx="165" fy="35" gradientUnits="userSpaceOnUse"/>
<radialGradient id="oval" xlink:href="#stops" cx="30%"/>
<linearGradient id="point" xlink:href="#stops" x1=".5" x2=".5"/></defs>
<rect x="10" y="10" width="120" height="70" fill="url(#turned)"/>
<g transform="rotate(5)"><circle cx="180" cy="45" r="40" style="fill:url(#focal)"/></g>
<g transform="translate(20 90) scale(1.5 1)" fill="url(#oval)"><ellipse cx="40" cy="30" rx="38" ry="28"/></g>
<path d="M150 100h80v50h-80z" fill="url(#point)" fill-opacity=".7"/></svg>"""


def test_opacity_is_saved_in_the_stops_and_an_ellipse_about_its_centre(open_page) -> None:
    viewer = open_page(FOREIGN)
    saved = viewer.saved()
    assert not re.search(r'"url[^>]*-opacity', saved) and 'stop-opacity=".35"' in saved
    circles = re.findall(r'<radialGradient[^>]* cx="([^"]*)" cy="([^"]*)" r="[^"]*" gradientTransform="([^"]*)"', saved)
    assert circles
    for cx, cy, matrix in circles:
        a, b, c, d, e, f = map(float, re.findall(r"[-.\d]+", matrix))
        x, y = float(cx), float(cy)
        assert (a * x + c * y + e, b * x + d * y + f) == pytest.approx((x, y), abs=0.01)


def test_gradients_of_other_programs_are_shown_and_saved(open_page) -> None:
    viewer = open_page(FOREIGN)
    assert viewer.text("message") == ""
    assert_shows(viewer, FOREIGN)
    assert psnr(draw(viewer.saved()), draw(FOREIGN)) > 42
    viewer.click(190, 130)
    viewer.press("Delete")
    viewer.press("Control+z", "Control+a", "ArrowLeft", "ArrowRight")
    assert psnr(draw(viewer.saved()), draw(FOREIGN)) > 42


@pytest.mark.parametrize(
    ("gradient", "color"),
    [
        ('<linearGradient id="g"><stop offset="0" stop-color="#e63"/></linearGradient>', (0xEE, 0x66, 0x33)),
        ('<pattern id="g"><path d="M0 0h9v9z"/></pattern>', (0x80, 0x80, 0x80)),
        ('<linearGradient id="g" href="#h"/><linearGradient id="h" href="#g"/>', (0x80, 0x80, 0x80)),
        ('<linearGradient id="g" href="http://e.org/#h"/>', (0x80, 0x80, 0x80)),
    ],
)
def test_what_is_no_gradient_is_one_colour(open_page, gradient: str, color: tuple[int, ...]) -> None:
    viewer = open_page(
        f'<svg {NS} width="40" height="20">{gradient}<rect width="40" height="20" fill="url(#g)"/></svg>'
    )
    assert viewer.color(20, 10) == color
    assert ("gradients" in viewer.text("message")) == (color == (0x80, 0x80, 0x80))


def test_gradients_take_no_name_of_a_layer(open_page) -> None:
    viewer = open_page(DRAWING.replace("layer-1-generation-0", "g1").replace("url(#g1)", "url(#g2)"))
    saved = viewer.saved()
    identifiers = re.findall(r' id="([^"]*)"', saved)
    assert len(identifiers) == len(set(identifiers)) and "g1" in identifiers


STOPS = f"""<svg {NS} viewBox="0 0 240 160" width="240" height="160"><defs>
<linearGradient id="g1" gradientUnits="userSpaceOnUse" x1="20" y1="0" x2="220" y2="0">
<stop offset="0" stop-color="#f00"/>
<stop offset=".25" stop-color="#0f0" stop-opacity=".5"/><stop offset="1" stop-color="#00f"/></linearGradient></defs>
<rect id="background" width="240" height="160" fill="#fff"/><g id="layer-1">
<path fill="url(#g1)" d="M20 20h200v120h-200z"/></g></svg>"""


def stops_of(viewer: Viewer) -> list[str]:
    return re.findall(r"<stop [^>]*/>", viewer.saved())


def set_stop(viewer: Viewer, field: str, index: int, value: str) -> None:
    """Set a field of a stop as somebody does who types it and goes on."""
    place = viewer.page.locator(f'[data-stop="{field} {index}"]')
    place.fill(value)
    place.dispatch_event("change")
    place.blur()
    viewer.settle()


def test_middle_stops_are_edited_added_and_deleted(open_page) -> None:
    viewer = open_page(STOPS)
    before = ['<stop offset="0" stop-color="#f00"/>', '<stop offset=".25" stop-color="#0f0" stop-opacity=".5"/>',
              '<stop offset="1" stop-color="#00f"/>']  # fmt: skip
    assert stops_of(viewer) == before
    viewer.click(100, 100)
    set_stop(viewer, "offset", 1, "60")
    set_stop(viewer, "opacity", 1, "0.8")
    set_stop(viewer, "color", 1, "#ffcc00")
    assert stops_of(viewer)[1] == '<stop offset=".6" stop-color="#fc0" stop-opacity=".8"/>'
    assert_shows(viewer, viewer.saved())
    viewer.press_button("stop-add")  # in the middle of the widest gap: nothing looks different
    assert stops_of(viewer)[1] == '<stop offset=".3" stop-color="#ff6600" stop-opacity=".9"/>'.replace("ff6600", "f60")
    set_stop(viewer, "offset", 1, "90")
    assert 'offset=".6"' in stops_of(viewer)[1]  # not beyond the next one
    viewer.page.locator("#stops button").nth(2).click()
    viewer.settle()
    assert len(stops_of(viewer)) == 3 and "#fc0" not in "".join(stops_of(viewer))
    for _ in range(6):
        viewer.press_button("undo")
    assert stops_of(viewer) == before


def test_a_gradient_keeps_two_stops(open_page) -> None:
    viewer = open_page(STOPS)
    viewer.click(100, 100)
    viewer.page.locator("#stops button").first.click()
    viewer.settle()
    assert viewer.page.locator("#stops button").count() == viewer.page.locator("#stops button:disabled").count() == 2
    assert len(stops_of(viewer)) == 2


STROKED = f"""<svg {NS} viewBox="0 0 240 160" width="240" height="160"><defs>
<linearGradient id="g1" gradientUnits="userSpaceOnUse" x1="20" y1="0" x2="220" y2="0">
<stop offset="0" stop-color="#f00"/>
<stop offset=".25" stop-color="#0f0" stop-opacity=".5"/><stop offset="1" stop-color="#00f"/></linearGradient>
<radialGradient id="g2" gradientUnits="userSpaceOnUse" cx="9" cy="120" r="90" gradientTransform="matrix(1 0 0 .5 0 60)">
<stop offset="0" stop-color="#fc0"/><stop offset="1" stop-color="#063"/></radialGradient></defs>
<rect id="background" width="240" height="160" fill="#fff"/><g id="layer-1">
<path fill="none" stroke="url(#g1)" stroke-width="24" stroke-linecap="round" d="M30 40h180"/>
<path fill="none" stroke="url(#g2)" stroke-width="20" d="M30 120c60-60 120 60 180 0"/></g></svg>"""


def strokes_of(svg: str) -> tuple[str, str]:
    """Return both gradients of ``STROKED``, or of a file that the page has made of it."""
    lines = svg.replace("\n", "").split("<defs>")[1].split("</defs>")[0]
    first, second = re.findall(r"<(?:linear|radial)Gradient.*?</(?:linear|radial)Gradient>", lines)
    return first, second


def test_gradients_of_strokes_are_shown_and_saved_as_they_are(open_page) -> None:
    viewer = open_page(STROKED)
    assert viewer.text("message") == ""
    assert_shows(viewer, STROKED)
    saved = viewer.saved()
    assert strokes_of(saved) == strokes_of(STROKED)
    assert [line for line in saved.splitlines() if "stroke=" in line] == [
        line.replace("</g></svg>", "") for line in STROKED.splitlines() if "stroke=" in line
    ]


def test_the_gradient_of_a_stroke_moves_with_it(open_page) -> None:
    viewer = open_page(STROKED)
    viewer.click(100, 40)
    viewer.press("Shift+ArrowRight")
    saved = viewer.saved()
    assert 'x1="30" y1="0" x2="230" y2="0"' in strokes_of(saved)[0]
    assert_shows(viewer, saved)
    viewer.press("Control+z")
    assert strokes_of(viewer.saved()) == strokes_of(STROKED)


def test_the_gradient_of_a_stroke_is_dragged_by_its_ends(open_page) -> None:
    viewer = open_page(STROKED)
    viewer.click(100, 40)
    viewer.press("n")
    viewer.drag((220, 0), (170, 20))
    saved = viewer.saved()
    found = re.search(r'x1="20" y1="0" x2="([\d.]+)" y2="([\d.]+)"', strokes_of(saved)[0])
    assert found and [float(text) for text in found.groups()] == pytest.approx([170, 20], abs=0.5)
    assert_shows(viewer, saved)


def test_stops_kind_and_colours_of_the_gradient_of_a_stroke_are_changed(open_page) -> None:
    viewer = open_page(STROKED)
    viewer.click(100, 40)
    assert viewer.page.locator("#kind").input_value() == "linear"
    assert (viewer.text("fill-text"), viewer.text("end-text")) == ("#ff0000", "#0000ff")
    set_stop(viewer, "color", 1, "#ffcc00")
    set_stop(viewer, "opacity", 1, "0.8")
    viewer.slide("end", "#102030")
    stops = '<stop offset="0" stop-color="#f00"/><stop offset=".25" stop-color="#fc0" stop-opacity=".8"/>'
    assert f'{stops}<stop offset="1" stop-color="#102030"/>' in strokes_of(viewer.saved())[0]
    assert_shows(viewer, viewer.saved())
    viewer.choose("kind", "Radial gradient")
    assert ' gradientUnits="userSpaceOnUse" cx="120" cy="40" r="102">' in viewer.saved()
    assert_shows(viewer, viewer.saved())
    viewer.choose("kind", "One colour")
    assert 'stroke="#f00" stroke-width="24"' in viewer.saved()
    viewer.choose("kind", "Linear gradient")
    assert 'x1="18" y1="40" x2="222" y2="40"' in viewer.saved()
    for _ in range(6):
        viewer.press_button("undo")
    assert strokes_of(viewer.saved()) == strokes_of(STROKED)


def test_a_colour_of_the_gradient_of_a_stroke_is_replaced(open_page) -> None:
    viewer = open_page(STROKED)
    viewer.page.locator('[name=swatch][value="#ffcc00"]').check(force=True)
    viewer.settle()
    viewer.slide("replace", "#ff00ff")
    first, second = strokes_of(viewer.saved())
    assert first == strokes_of(STROKED)[0]
    # A gradient that has changed has another name, so that both can be on one web page.
    assert 'id="g2"' not in second
    assert re.sub(' id="[^"]*"', ' id="g2"', second) == strokes_of(STROKED)[1].replace("#fc0", "#f0f")
