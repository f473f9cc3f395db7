"""The page of ``warpvec view`` with files of other programs, hostile files, many paths, and without a mouse."""

from __future__ import annotations

import random
import re

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)

from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw, file_facts

pytestmark = NEEDS_BROWSER

NS = 'xmlns="http://www.w3.org/2000/svg"'

FOREIGN = f"""<svg {NS} viewBox="10 -5 200 120" width="400">
<style>.leaf{{fill:#3a7d2c;fill-opacity:.8}} #dot{{fill:purple}}</style>
<defs><linearGradient id="fade"><stop stop-color="#fff"/><stop offset=".5" stop-color="#e63"/><stop offset="1"/>
</linearGradient></defs>
<rect x="15" y="0" width="70" height="40" rx="8" fill="navy"/>
<g transform="translate(120 30) rotate(20) scale(1.5)" style="fill: orange; stroke: #222; stroke-width: 2">
<circle r="15"/><ellipse cx="30" rx="9" ry="14" stroke="none"/></g>
<path class="leaf" d="M30 60 q20-30 40 0 t40 0 v30 h-80z"/>
<path fill="none" stroke="rgb(200,0,40)" stroke-width="3" d="m120 70c5 5 20-20 30 0s10 20 30 0"/>
<path id="dot" fill-rule="evenodd" d="M150 85a14 12 30 1 0 1 0zm5 3l12 0 0 12-12 0z"/>
<polygon points="20,95 35,110 15,112" fill="hsl(180 60% 40%)" opacity=".5"/>
<polyline points="180 10 200 10 200 30" fill="teal"/>
<path d="M90 100a10 10 0 01 20 0A10,10,0,0,1,90,100" fill="#800"/>
<g id="inner"><g opacity=".6"><path d="M60 0l20 10-20 10z" transform="matrix(1 .2 0 1 5 3)"/></g></g>
<text x="20" y="20">left out</text><path d="M0 0h9v9z" display="none"/>
</svg>"""


def test_another_programs_file_is_shown_edited_and_saved(open_page) -> None:
    plain = FOREIGN.replace('<text x="20" y="20">left out</text>', "")
    viewer = open_page(FOREIGN)
    assert "<text>, left out" in viewer.text("message")
    assert "hidden" in viewer.text("message")
    saved = viewer.saved()
    assert psnr(draw(saved), draw(plain)) > 42
    assert "text" not in saved
    assert [line[:8] for line in saved.splitlines() if "transform" in line] == ["<ellipse"]
    # The page shows the same colours, checked at points away from edges.
    image = draw(plain)
    drawn = draw(saved)
    for row, column in [(20, 60), (90, 230), (160, 100), (234, 60), (200, 300)]:
        shown = viewer.color(column / 2 + 10.25, row / 2 - 4.75)
        assert np.abs(np.subtract(shown, image[row, column].astype(int))).max() <= 3, (row, column)
        assert np.abs(drawn[row, column].astype(int) - image[row, column]).max() <= 3
    viewer.press("Control+a", "Delete")
    assert file_facts(viewer.saved())["paths"] == 0


def test_the_ends_and_corners_of_strokes_are_kept(open_page) -> None:
    svg = (
        f'<svg {NS} width="120" height="60"><g fill="none" stroke="#a40" stroke-width="12" stroke-linecap="round">'
        '<path d="M15 15h30v30" style="stroke-linejoin:bevel"/><path stroke-linecap="square" d="M70 15h30"/>'
        '<path stroke-miterlimit="12" d="M70 45h30l-30 8"/></g></svg>'
    )
    viewer = open_page(svg)
    image = draw(svg)
    points = [(10, 15), (65, 10), (49, 11), (110, 46)]
    assert viewer.colors([(x + 0.5, y + 0.5) for x, y in points]) == [tuple(image[y, x].tolist()) for x, y in points]
    assert np.array_equal(draw(viewer.saved()), image)


@pytest.mark.parametrize("empty", ["", '<text>only text</text><path d="nonsense" fill="url(#no)"/>'])
def test_a_file_without_paths_opens_and_takes_a_stroke(open_page, empty: str) -> None:
    viewer = open_page(f'<svg {NS} width="60" height="40">{empty}</svg>')
    viewer.press("b")
    viewer.drag((10, 20), (50, 20))
    assert file_facts(viewer.saved())["paths"] == 1


def test_zoom_and_pan_move_picture_and_clicks_alike(open_page) -> None:
    viewer = open_page(
        f'<svg {NS} width="60" height="40"><rect id="background" width="60" height="40" fill="#fff"/>'
        '<path fill="#00f" d="M10 10h4v4h-4z"/><path fill="#f00" d="M40 30h4v4h-4z"/></svg>'
    )
    page, before = viewer.page, viewer.at(12, 12)
    page.mouse.move(*before)  # which the browser rounds to pixels
    for _ in range(4):
        page.mouse.wheel(0, -240)
    viewer.settle()
    assert viewer.at(12, 12) == pytest.approx(before, abs=1.5)
    assert viewer.at(13, 12)[0] - before[0] > 20
    page.keyboard.down(" ")
    page.mouse.down()
    page.mouse.move(before[0] + 150, before[1] - 90, steps=4)
    page.mouse.up()
    page.keyboard.up(" ")
    viewer.settle()
    assert viewer.at(12, 12) == pytest.approx((before[0] + 150, before[1] - 90), abs=1.5)
    page.wait_for_timeout(200)
    assert viewer.color(12, 12) == (0, 0, 255)
    assert viewer.color(15, 12) == (255, 255, 255)
    assert viewer.click(12, 12).startswith("1 of 2")
    assert viewer.click(15, 12) == "Nothing selected"
    viewer.press("0")
    assert viewer.at(12, 12) == pytest.approx(before, abs=1.5)
    assert viewer.color(42, 32) == (255, 0, 0)


HOSTILE = f"""<svg {NS} xmlns:xlink="http://www.w3.org/1999/xlink" width="60" height="40" onload="top.ran='onload'">
<title>&lt;/script&gt;&lt;script&gt;top.ran='title'&lt;/script&gt;&lt;img src=x onerror="top.ran='img'"&gt;</title>
<metadata>{{"&lt;img src=x onerror=top.ran=1&gt;": "&lt;script&gt;top.ran='metadata'&lt;/script&gt;"}}</metadata>
<!-- </script><script>top.ran='comment'</script> --><script>top.ran='script'</script>
<script xlink:href="http://example.org/x.js"/><style>@import url(http://example.org/x.css);
rect {{ fill: url(http://example.org/y.svg#z) }}</style>
<g id="layer-1-generation-0&quot;&gt;&lt;script&gt;top.ran='id'&lt;/script&gt;" onclick="top.ran='click'">
<a xlink:href="javascript:top.ran='link'"><path d="M0 0h60v40H0z" fill="red" onmouseover="top.ran='over'"/></a></g>
<foreignObject width="60" height="40"><iframe xmlns="http://www.w3.org/1999/xhtml" src="javascript:top.ran='frame'"/>
<img xmlns="http://www.w3.org/1999/xhtml" src="http://example.org/x.png" onerror="top.ran='html'"/></foreignObject>
<animate attributeName="href" values="javascript:top.ran='animate'" onbegin="top.ran='begin'"/></svg>"""


def test_nothing_in_a_hostile_file_runs_or_loads(open_page) -> None:
    viewer = open_page(HOSTILE, name="</script><script>top.ran='name'</script>")
    viewer.click(30, 20)
    saved = viewer.saved()
    viewer.page.wait_for_timeout(100)
    assert viewer.page.evaluate("() => window.ran ?? null") is None
    assert viewer.page.inner_text("h1").startswith("</script><script>top.ran='title'")
    assert viewer.page.locator("script").count() == 3
    for word in ("<script", "onload=", "onmouseover=", "javascript", "example.org", "foreignObject"):
        assert word not in saved
    assert (draw(saved) == (255, 0, 0)).all()


def test_the_policy_of_the_page_refuses_other_scripts(open_page) -> None:
    viewer = open_page(f'<svg {NS} width="60" height="40"/>')
    viewer.page.evaluate(
        """() => {
            const address = "data:text/javascript,window.ran=1";
            const kinds = [{ textContent: "window.ran = 1" }, { src: address }, { src: address, type: "module" }];
            for (const script of kinds) {
                document.body.append(Object.assign(document.createElement("script"), script));
            }
        }"""
    )
    viewer.page.wait_for_timeout(100)
    assert viewer.page.evaluate("() => window.ran ?? null") is None
    refusals = [text for text in viewer.complaints if "Content Security Policy" in text]
    assert len(refusals) >= 3
    viewer.complaints.clear()


def test_every_control_has_a_name_and_takes_the_focus(open_page) -> None:
    level = '<g><path d="M9 9h9v9z"/></g>'
    viewer = open_page(f'<svg {NS} width="60" height="40">{2 * level}</svg>', scheme="dark")
    unnamed = viewer.page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, canvas[tabindex]")]
            .filter((control) => !(control.ariaLabel || control.labels?.length || control.textContent.trim()))
            .map((control) => control.id)"""
    )
    assert unnamed == []
    viewer.press("]")
    viewer.page.locator("h1").click()
    reached = set()
    for _ in range(80):
        viewer.page.keyboard.press("Tab")
        reached.add(viewer.page.evaluate("() => document.activeElement.id || document.activeElement.name"))
    some = {"save", "tool", "fill", "opacity", "scale", "front", "to-layer", "surface", "shown-count", "zoom-fit"}
    assert some <= reached
    dark = viewer.page.evaluate("() => getComputedStyle(document.body).backgroundColor")
    assert max(map(int, dark[4:-1].split(","))) < 64
    viewer.press("?")
    assert viewer.page.locator("#help").is_visible()
    # Controls that need a photo or a history are hidden without them.
    assert viewer.page.locator("[data-needs]:visible").count() == 0


def test_thousands_of_paths_follow_the_pointer(open_page) -> None:
    generator = random.Random(1)

    def path() -> str:
        x, y, side = generator.uniform(0, 760), generator.uniform(0, 500), generator.uniform(2, 80)
        return (
            f'<path fill="#{generator.randrange(4096):03x}" fill-opacity=".7" d="M{x:.2f} {y:.2f}q{side} 0 9 {side}z"/>'
        )

    groups = [f'<g id="layer-{i + 1}-generation-{i}">{"".join(path() for _ in range(512))}</g>' for i in range(8)]
    viewer = open_page(f'<svg {NS} width="768" height="512">{"".join(groups)}</svg>')
    viewer.press("Control+a")
    assert viewer.selected() == "4,096 of 4,096 paths selected"
    viewer.page.evaluate(
        """() => {
            window.frames_ = [];
            const note = (now) => { window.frames_.push(now); requestAnimationFrame(note); };
            requestAnimationFrame(note);
        }"""
    )
    viewer.drag((300, 200), (330, 220), (300, 240), (360, 250))
    viewer.press(*["ArrowLeft"] * 10, "Escape", "+", "+", "-", "-", "]", *["ArrowDown"] * 10, "n", "]")
    viewer.press(*["ArrowRight"] * 10, "v")
    for level in range(8, 0, -1):
        viewer.slide("shown-count", str(level))
    gaps = np.diff(viewer.page.evaluate("() => window.frames_"))
    # A frame takes 17 ms on an idle machine; ten times that would be noticeable.
    assert np.median(gaps) < 40
    assert np.percentile(gaps, 95) < 170
    # The drag, and a command for each run of keys: all paths, one path, and one node. A busy machine may cut a run.
    undo_count = 0
    while viewer.page.locator("#undo").is_enabled():
        viewer.press("Control+z")
        undo_count += 1
    assert 4 <= undo_count <= 12


def test_a_move_changes_only_where_a_path_starts(open_page) -> None:
    curves = "c3.15-7.8 10.35-6.1 12.5.25 2.2 4.4-1.05 9.9-6.4 8.15-5.6-2.1-8.3-4.2-6.1-8.4z"
    viewer = open_page(f'<svg {NS} width="480" height="320"><path d="M40.5 30.25{curves}"/></svg>')
    viewer.press("]", "ArrowRight", "ArrowUp", "ArrowUp")
    assert f'd="M41.5 28.25{curves}"' in viewer.saved()
    viewer.press(">", "<")
    assert not re.search(r"\.\d{3}", viewer.saved())
