"""Strokes and forms in the page of ``warpvec app`` in a real Chromium: changed into one another, saved, and undone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage, desk_fixture, desk_server_fixture  # noqa: F401  (fixtures)

from warpvec.image.metrics import psnr
from warpvec.image.write import png_bytes
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

pytestmark = NEEDS_BROWSER

SHAPES = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 160" width="240" height="160">
<rect id="background" width="240" height="160" fill="#fff"/><g id="layer-1">
<path fill="none" stroke="#c22" stroke-width="12" stroke-linecap="round" d="M20 30c40 0 60 40 110 40"/>
<path fill="#27c" fill-opacity=".5" d="M150 60c0-16.6 13.4-30 30-30s30 13.4 30 30-13.4 30-30 30-30-13.4-30-30z"/>
<circle fill="#182" cx="60" cy="115" r="25"/></g></svg>"""


@pytest.fixture(name="shapes")
def shapes_fixture(desk: DeskPage, tmp_path: Path) -> Iterator[DeskPage]:
    """Open a page that shows ``SHAPES`` as the drawing of a picture of them."""
    picture = tmp_path / "shapes.png"
    picture.write_bytes(png_bytes(draw(SHAPES)))
    desk.drop(picture)
    desk.wait_for_status("done")
    desk.page.locator("#sides label").nth(1).click()  # Edit
    desk.page.evaluate("(svg) => { warpvecView.finishDrawing({ svg, label: 'Given' }); }", SHAPES)
    return desk


def say(desk: DeskPage, words: str) -> None:
    """Wait until the page says some words."""
    script = "(words) => document.getElementById('message').textContent.includes(words)"
    desk.page.wait_for_function(script, arg=words)


def saved(desk: DeskPage) -> str:
    """Save with Ctrl+S and return the text of the file."""
    with desk.page.expect_download(timeout=20_000) as download:
        desk.page.keyboard.press("Control+s")
    path = desk.folder / "saved.svg"
    download.value.save_as(path)
    return path.read_text()


def elements(desk: DeskPage) -> list[str]:
    """Return the lines of the shapes in the file that the page saves."""
    return [line for line in saved(desk).splitlines() if re.match("<(path|circle|ellipse|rect fill)", line)]


def test_a_radius_is_dragged_and_saved(shapes: DeskPage) -> None:
    before = elements(shapes)
    shapes.click(60, 115)
    shapes.page.keyboard.press("n")
    scale, x, y = shapes.page.evaluate("() => document.getElementById('surface').dataset.view.split(' ').map(Number)")
    box = shapes.page.locator("#surface").bounding_box()
    assert box is not None
    shapes.page.mouse.move(box["x"] + x + scale * 85, box["y"] + y + scale * 115)
    shapes.page.mouse.down()
    shapes.page.mouse.move(box["x"] + x + scale * 90, box["y"] + y + scale * 115, steps=6)
    shapes.page.mouse.up()
    after = elements(shapes)
    assert after[:2] == before[:2] == SHAPES.splitlines()[2:4]
    found = re.fullmatch(r'<circle fill="#182" cx="60" cy="115" r="([\d.]+)"/>', after[2])
    assert found and float(found[1]) == pytest.approx(30, abs=0.02)


def test_a_stroke_becomes_an_outline_and_a_stroke_again(shapes: DeskPage) -> None:
    before = elements(shapes)
    shapes.click(75, 50)
    shapes.page.locator("#to-outline").click()
    say(shapes, "Now an outline")
    outlined = saved(shapes)
    assert "stroke=" not in outlined and outlined.count('<path fill="#c22" d=') == 1
    assert psnr(draw(outlined), draw(SHAPES)) > 40
    assert shapes.page.inner_text("#shape-kind") == "Path"  # it is selected
    shapes.page.locator("#to-stroke").click()
    say(shapes, "Now a stroke")
    again = saved(shapes)
    strokes = read_svg(again).scene.strokes
    assert strokes is not None and strokes.width[0].item() == pytest.approx(12, abs=0.1)
    assert '<path fill="none" stroke="#c22"' in again and psnr(draw(again), draw(SHAPES)) > 40
    for _ in range(2):
        shapes.page.keyboard.press("Control+z")
    assert elements(shapes) == before
    shapes.page.keyboard.press("Control+Shift+z")
    assert elements(shapes)[0].startswith('<path fill="#c22" d=')


def test_an_outline_is_made_a_circle_and_keeps_its_paint(shapes: DeskPage) -> None:
    before = elements(shapes)
    shapes.click(180, 60)
    shapes.page.locator("#make-form").select_option(label="a circle")
    say(shapes, "Now a circle, at most 0.")
    found = re.fullmatch(
        r'<circle fill="#27c" fill-opacity=".5" cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"/>', elements(shapes)[1]
    )
    assert found and [float(text) for text in found.groups()] == pytest.approx([180, 60, 30], abs=0.05)
    shapes.page.locator("#to-path").click()
    assert elements(shapes)[1].startswith('<path fill="#27c"')
    for _ in range(2):
        shapes.page.locator("#undo").click()
    assert elements(shapes) == before


def test_what_cannot_be_is_said_and_changes_nothing(shapes: DeskPage) -> None:
    before = saved(shapes)
    shapes.click(60, 115)
    shapes.page.locator("#to-stroke").click()
    say(shapes, "This shape is no stroke")
    assert saved(shapes) == before


def test_a_shape_that_is_edited_meanwhile_keeps_the_edit(shapes: DeskPage) -> None:
    shapes.click(180, 60)
    script = """() => {
        const ask = window.desk.reshape;
        window.desk.reshape = async (...args) => {
            const answer = await ask(...args);
            document.getElementById("surface").focus();
            document.getElementById("box-x").value = 155;
            document.getElementById("box-x").dispatchEvent(new Event("change"));
            return answer;
        };
    }"""
    shapes.page.evaluate(script)
    shapes.page.locator("#make-form").select_option(label="a circle")
    say(shapes, "changed in the meantime")
    moved = elements(shapes)[1]
    assert moved.startswith('<path fill="#27c" fill-opacity=".5" d="M155 60')
    assert np.all(draw(saved(shapes))[60, 152] == 255)
