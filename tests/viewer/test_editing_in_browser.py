"""Editing on the page in a real Chromium: nodes, turning, places, colours, levels, touch, and fitting again."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)
from squares import HEIGHT, SQUARES, WIDTH, changed, drawing, square

from warpvec.svg.measure import draw, file_facts

pytestmark = NEEDS_BROWSER

NS = 'xmlns="http://www.w3.org/2000/svg"'


def art(body: str, width: int = WIDTH, height: int = HEIGHT) -> str:
    """Return a file with a white background and one level."""
    background = f'<rect id="background" width="{width}" height="{height}" fill="#fff"/>'
    return f'<svg {NS} width="{width}" height="{height}">{background}<g id="layer-1">{body}</g></svg>'


def assert_draws_as(svg: str, expected: str, levels: int = 2) -> None:
    difference = np.abs(draw(svg).astype(int) - draw(expected))
    assert difference.max() <= levels, f"{(difference.max(2) > levels).sum()} pixels differ"


def points_of(viewer: Viewer, kind: str) -> list[tuple[float, float]]:
    """Return the points of a kind that the node tool shows, in user units."""
    viewer.settle()
    words = [text.split() for text in viewer.page.locator("#surface").get_attribute("data-points").split(",")]
    return [(float(word[2]), float(word[3])) for word in words if word[0] == kind]


def data_of(svg: str) -> list[str]:
    return re.findall(r'<path[^>]* d="([^"]*)"', svg)


TRIANGLE = '<path fill="#00f" d="M40 40L140 40L40 120z"/>'
OTHER = '<path fill="#f00" d="M180 20h33.333v40z"/>'


@pytest.fixture
def triangle(open_page) -> Viewer:
    """A triangle, which is selected, and another path, with the node tool."""
    viewer = open_page(art(TRIANGLE + OTHER))
    viewer.click(60, 60)
    viewer.press("n")
    return viewer


def test_a_dragged_node_moves_its_lines_and_nothing_else(triangle: Viewer) -> None:
    assert points_of(triangle, "node") == [(40, 40), (140, 40), (40, 120)]
    assert points_of(triangle, "before") == points_of(triangle, "after") == []
    triangle.drag((140, 40), (160, 90))
    saved = triangle.saved()
    assert_draws_as(saved, art('<path fill="#00f" d="M40 40L160 90L40 120z"/>' + OTHER))
    assert data_of(saved)[1] == data_of(OTHER)[0]
    assert "c" not in data_of(saved)[0]
    triangle.press("Control+z")
    assert data_of(triangle.saved()) == data_of(TRIANGLE + OTHER)


def test_keys_step_through_nodes_and_move_them(triangle: Viewer) -> None:
    triangle.press("]", "]", "Shift+ArrowRight", "ArrowUp")
    assert triangle.text("message") == "Node 2 of 3, corner, at 140, 40"
    triangle.page.wait_for_function("() => document.getElementById('message').textContent.endsWith('at 150, 39')")
    assert triangle.text("node-text") == "Node 2 of 3, corner, at 150, 39"
    triangle.slide("node-y", "100")
    assert_draws_as(triangle.saved(), art('<path fill="#00f" d="M40 40L150 100L40 120z"/>' + OTHER))
    triangle.press_button("undo")
    triangle.press_button("undo")
    assert data_of(triangle.saved()) == data_of(TRIANGLE + OTHER)


def test_several_nodes_move_together(triangle: Viewer) -> None:
    triangle.drag((30, 30), (60, 130))
    assert triangle.text("node-text") == "2 of 3 nodes"
    triangle.drag((40, 40), (20, 40))
    assert_draws_as(triangle.saved(), art('<path fill="#00f" d="M20 40L140 40L20 120z"/>' + OTHER))


def test_an_added_node_changes_nothing_until_it_moves(triangle: Viewer) -> None:
    triangle.page.mouse.dblclick(*triangle.at(90, 40))
    assert len(points_of(triangle, "node")) == 4
    assert_draws_as(triangle.saved(), art(TRIANGLE + OTHER))
    triangle.press("ArrowUp", *["Shift+ArrowUp"] * 2)
    assert_draws_as(triangle.saved(), art('<path fill="#00f" d="M40 40L90 19L140 40L40 120z"/>' + OTHER))
    triangle.press("Delete")
    assert_draws_as(triangle.saved(), art(TRIANGLE + OTHER))


def test_a_curve_keeps_its_ends_where_a_node_is_removed(open_page) -> None:
    # The two halves of one curve, which removing the node between them restores.
    whole, halves = "M20 80c40 -60 120 -60 160 0z", "M20 80c20 -30 50 -45 80 -45s60 15 80 45z"
    viewer = open_page(art(f'<path fill="#070" d="{halves}"/>'))
    viewer.click(100, 60)
    viewer.press("n")
    viewer.page.mouse.click(*viewer.at(100, 35))
    assert viewer.text("node-text").startswith("Node 2 of 3, smooth")
    viewer.press("Delete")
    assert_draws_as(viewer.saved(), art(f'<path fill="#070" d="{whole}"/>'), levels=12)
    viewer.press("Control+z", "Control+a", "Delete")
    assert file_facts(viewer.saved())["paths"] == 0


def test_handles_of_smooth_nodes_stay_in_line_and_those_of_corners_do_not(open_page) -> None:
    viewer = open_page(art('<path fill="#070" d="M20 80c20 -30 50 -45 80 -45s60 15 80 45z"/>'))
    viewer.click(100, 60)
    viewer.press("n", "]", "]", "]")
    assert viewer.text("node-text").startswith("Node 2 of 3, smooth, at 100, 35")
    assert points_of(viewer, "before")[0] == (70, 35)
    viewer.drag((130, 35), (100, 65))
    (before, after) = (points_of(viewer, kind)[i] for kind, i in (("before", 0), ("after", 1)))
    assert before == pytest.approx((100, 5), abs=0.5)
    assert after == pytest.approx((100, 65), abs=0.5)
    viewer.page.mouse.click(*viewer.at(100, 35))
    viewer.press("s")
    assert "corner" in viewer.text("node-text")
    viewer.drag(after, (150, 35))
    assert points_of(viewer, "before")[0] == pytest.approx(before, abs=0.01)
    # Smooth again: the handles lie in line through the node.
    viewer.page.mouse.click(*viewer.at(100, 35))
    viewer.press("s")
    (before, after) = (points_of(viewer, kind)[i] for kind, i in (("before", 0), ("after", 1)))
    first, second = np.subtract(before, (100, 35)), np.subtract(after, (100, 35))
    assert abs(first[0] * second[1] - first[1] * second[0]) < 0.01 * np.linalg.norm(first) * np.linalg.norm(second)


def test_a_line_becomes_a_curve_and_a_corner_round(triangle: Viewer) -> None:
    triangle.page.mouse.click(*triangle.at(140, 40))
    triangle.press_button("node-smooth")
    assert len(points_of(triangle, "before")) == len(points_of(triangle, "after")) == 2
    (path, _) = data_of(triangle.saved())
    assert "c" in path
    triangle.press("Control+z")
    triangle.page.mouse.click(*triangle.at(40, 120))
    triangle.press_button("node-line")
    assert len(points_of(triangle, "before")) == len(points_of(triangle, "after")) == 1
    triangle.press_button("node-line")
    assert data_of(triangle.saved())[0] == "M40 40h100l-100 80z"


def test_ends_of_a_gradient_are_moved_on_the_picture(open_page) -> None:
    viewer = open_page(art('<path fill="#00f" d="M20 20h200v120h-200z"/>'))
    viewer.click(100, 80)
    viewer.page.locator("#kind").select_option("linear")
    viewer.slide("end", "#ff0000")
    viewer.press("n")
    assert points_of(viewer, "gradient") == [(20, 80), (220, 80)]
    viewer.drag((220, 80), (20, 140))
    viewer.drag((20, 80), (20, 20))
    stops = '<stop stop-color="#00f"/><stop offset="1" stop-color="#f00"/>'
    ends = 'gradientUnits="userSpaceOnUse" x1="20" y1="20" x2="20" y2="140"'
    gradient = f'<linearGradient id="a" {ends}>{stops}</linearGradient>'
    assert_draws_as(viewer.saved(), art(gradient + '<path fill="url(#a)" d="M20 20h200v120h-200z"/>'), levels=4)
    viewer.page.locator("#kind").select_option("flat")
    assert 'fill="#00f" d=' in viewer.saved()


TURNED = changed(white=None).replace(
    "</g></svg>", f'<g transform="rotate(45 210 130)">{square(*SQUARES["white"])}</g></g></svg>'
)


def turn_by_handle(viewer: Viewer) -> None:
    left, top = viewer.at(210, 120)
    viewer.page.mouse.move(left, top - 26)
    viewer.page.mouse.down()
    viewer.page.keyboard.down("Shift")
    viewer.page.mouse.move(*viewer.at(240, 98), steps=6)
    viewer.page.mouse.up()
    viewer.page.keyboard.up("Shift")


def turn_by_number(viewer: Viewer) -> None:
    viewer.slide("turn", "45")
    viewer.press_button("turn-apply")


@pytest.mark.parametrize("turn", [turn_by_handle, turn_by_number])
def test_a_selection_is_turned(open_page, turn: Callable[[Viewer], None]) -> None:
    viewer = open_page(drawing())
    viewer.click(210, 130)
    turn(viewer)
    assert_draws_as(viewer.saved(), TURNED, levels=12)
    viewer.press("Control+z")
    assert_draws_as(viewer.saved(), drawing(), levels=0)


def test_keys_turn_by_five_degrees_in_one_command(open_page) -> None:
    viewer = open_page(drawing())
    viewer.click(210, 130)
    viewer.press(*[")"] * 10, "(")
    assert_draws_as(viewer.saved(), TURNED, levels=12)
    viewer.press("Control+z")
    assert viewer.page.locator("#undo").is_disabled()


def test_a_place_and_a_size_are_typed(open_page) -> None:
    viewer = open_page(drawing())
    viewer.click(210, 130)
    assert [viewer.page.input_value(f"#box-{name}") for name in ("x", "y", "width", "height")] == [
        "200",
        "120",
        "20",
        "20",
    ]
    for name, value in (("x", "180"), ("y", "90"), ("width", "40"), ("height", "40")):
        viewer.slide(f"box-{name}", value)
    assert_draws_as(viewer.saved(), changed(white=(180, 90, 40, "#fff", "1", 1)))


GRADIENT = (
    '<linearGradient id="a" gradientUnits="userSpaceOnUse" x2="240"><stop stop-color="#c00"/>'
    '<stop offset="1" stop-color="#fff"/></linearGradient>'
)


def colourful(color: str) -> str:
    """Return a drawing that uses ``color`` in fills, a gradient, a stroke and the background."""
    body = (
        f'{GRADIENT.replace("#c00", color)}<path fill="{color}" d="M10 10h30v30z"/>'
        '<path fill="#0a0" d="M60 10h30v30z"/>'
        f'<path fill="{color}" fill-opacity=".5" d="M110 10h30v30z"/><path fill="url(#a)" d="M10 60h220v30h-220z"/>'
        f'<path fill="none" stroke="{color}" stroke-width="4" d="M10 120h200"/>'
    )
    return art(body).replace('fill="#fff"/><g', f'fill="{color}"/><g')


def test_a_colour_is_replaced_wherever_it_is_used(open_page) -> None:
    viewer = open_page(colourful("#c00"))
    swatches = viewer.page.locator("#palette input")
    assert swatches.first.get_attribute("aria-label") == "#cc0000, 5 uses"
    assert swatches.count() == 3
    swatches.first.check()
    for color in ("#123456", "#0066ff"):
        viewer.slide("replace", color)
    saved = viewer.saved()
    assert_draws_as(saved, colourful("#06f"))
    viewer.press("Control+z")
    assert_draws_as(viewer.saved(), colourful("#c00"), levels=0)
    # A colour that is already there stays apart while it is dragged over.
    viewer.page.locator("#palette input[value='#cc0000']").check()
    viewer.slide("replace", "#00aa00")
    viewer.slide("replace", "#0066ff")
    assert_draws_as(viewer.saved(), colourful("#06f"))
    viewer.press_button("select-color")
    assert viewer.selected() == "4 of 5 paths selected"


def test_near_colours_change_as_much(open_page) -> None:
    def sheet(*colors: str) -> str:
        return art("".join(f'<path fill="{color}" d="M{10 + 50 * i} 10h30v30z"/>' for i, color in enumerate(colors)))

    viewer = open_page(sheet("#c81020", "#be1428", "#6e1020", "#fff0c8"))
    viewer.click(35, 15)
    viewer.slide("near", "12")
    assert viewer.text("replace-text") == "2 uses"
    viewer.slide("replace-hex", "#20c810")
    assert_draws_as(viewer.saved(), sheet("#20c810", "#16cc18", "#6e1020", "#fff0c8"), levels=0)
    viewer.press_button("undo")
    assert_draws_as(viewer.saved(), sheet("#c81020", "#be1428", "#6e1020", "#fff0c8"), levels=0)


def test_paths_alike_are_selected(open_page) -> None:
    viewer = open_page(colourful("#c00"))
    viewer.click(35, 15)
    viewer.press("k")
    assert viewer.selected() == "2 of 5 paths selected"
    viewer.press_button("same-layer")
    assert viewer.selected() == "5 of 5 paths selected"


def groups_of(svg: str) -> list[int]:
    return [group.count("<path") for group in re.findall(r"<g .*?</g>", svg, re.S)]


def test_levels_are_made_moved_and_merged(open_page) -> None:
    viewer = open_page(drawing())
    viewer.click(130, 30)
    viewer.click(70, 70, "Shift")
    viewer.press("Control+g")
    saved = viewer.saved()
    assert groups_of(saved) == [1, 1, 2]
    identifiers = re.findall(r'<g id="([^"]*)"', saved)
    assert len(set(identifiers)) == 3
    assert viewer.page.locator("#layers tbody tr").count() == 3
    viewer.slide("layer-name", 'Eyes & "lids"')
    assert viewer.page.locator("#layers tbody tr").nth(2).inner_text().split("\t")[2] == 'Eyes & "lids"'
    assert 'inkscape:label="3 Eyes &amp; &quot;lids&quot;"' in viewer.saved()
    viewer.press_button("undo")
    assert "Eyes" not in viewer.saved()
    viewer.press_button("layer-down")
    assert groups_of(viewer.saved()) == [1, 2, 1]
    viewer.press("Control+Shift+g")
    assert groups_of(viewer.saved()) == [3, 1]
    viewer.press(*["Control+z"] * 3)
    assert_draws_as(viewer.saved(), drawing(), levels=0)
    assert viewer.page.locator("#layers tbody tr").count() == 2
    viewer.press(*["Control+Shift+z"] * 3)
    assert groups_of(viewer.saved()) == [3, 1]


def test_edited_paths_are_named_when_fitting_again(open_page) -> None:
    viewer = open_page(drawing())
    assert not viewer.page.locator("#fit-again").is_visible()
    viewer.page.evaluate("() => { window.desk = { fitAgain: (...given) => (window.asked = given) }; }")
    viewer.click(130, 30)
    viewer.press("ArrowLeft")
    viewer.click(210, 130)
    viewer.press("ArrowLeft", "Control+z", "Escape")
    assert viewer.text("edited-count") == "1 edited"
    viewer.press_button("fit-again")
    text, locked = viewer.page.evaluate("() => window.asked")
    assert locked == [1]
    assert_draws_as(text, changed(green=(119, 20, 60, "#0a0", "1", 0)))
    # The path stays marked as edited in the drawing that the fit returns.
    viewer.page.evaluate("(text) => { warpvecView.finishDrawing({ svg: text }); }", text)
    viewer.press_button("fit-again")
    assert viewer.page.evaluate("() => window.asked[1]") == [1]
    viewer.page.locator("#keep-edited").uncheck()
    viewer.press_button("fit-again")
    assert viewer.page.evaluate("() => window.asked[1]") == []


def test_two_fingers_zoom_and_one_edits(open_page) -> None:
    viewer = open_page(drawing())
    x, y = viewer.at(130, 30)
    touch = viewer.page.context.new_cdp_session(viewer.page)

    def fingers(kind: str, *points: tuple[float, float]) -> None:
        touch.send(
            "Input.dispatchTouchEvent",
            {"type": kind, "touchPoints": [{"x": px, "y": py, "id": i} for i, (px, py) in enumerate(points)]},
        )
        viewer.settle()

    fingers("touchStart", (x, y))
    fingers("touchEnd")
    assert viewer.selected() == "1 of 4 paths selected: Pass 1"
    viewer.press_button("adding")
    fingers("touchStart", viewer.at(210, 130))
    fingers("touchEnd")
    assert viewer.selected() == "2 of 4 paths selected"
    before = viewer.at(0, 0), viewer.at(100, 0)
    fingers("touchStart", (500, 400))
    fingers("touchStart", (500, 400), (600, 400))
    fingers("touchMove", (450, 400), (650, 400))
    fingers("touchEnd")
    after = viewer.at(0, 0), viewer.at(100, 0)
    assert after[1][0] - after[0][0] == pytest.approx(2 * (before[1][0] - before[0][0]), rel=0.02)
    assert viewer.selected() == "2 of 4 paths selected"
    assert viewer.page.locator("#undo").is_disabled()
