"""The page of ``warpvec app`` has no serious fault for those who use a screen reader or keys: axe-core's checks."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage, DeskServer, desk_fixture, desk_server_fixture  # noqa: F401  (fixtures)
from logo import logo
from PIL import Image, ImageDraw

pytestmark = [
    *NEEDS_BROWSER,
    pytest.mark.skipif(find_spec("axe_playwright_python") is None, reason="axe-playwright-python is not installed"),
]

WINDOWS: dict[str, dict[str, Any]] = {
    "desk": {},
    "dark": {"color_scheme": "dark"},
    "phone": {"viewport": {"width": 390, "height": 844}, "has_touch": True},
}

JARGON = (
    "PSNR|SSIM|SVG|svgz|PNG|PDF|gradient|opacity|opaque|residual|generation|convergence|iteration|segment|gzipped|node|"
    "palette|hue|vivid|canvas|layer|pan|cut|mono|flat|fit|smooth|corner|code|near|detail"
)
"""Words of the page that are not everyday English, or mean something of their own there."""


def faults(desk: DeskPage) -> list[str]:
    """Return the serious faults that axe-core finds, each with the elements that have it."""
    from axe_playwright_python.sync_playwright import Axe

    found = Axe().run(desk.page).response["violations"]
    return [
        f"{fault['id']}: {node['html'][:200]}"
        for fault in found
        if fault["impact"] in ("serious", "critical")
        for node in fault["nodes"]
    ]


def outside(desk: DeskPage) -> list[str]:
    """Return the controls and words of the panels that reach over their edges."""
    script = """() => [...document.querySelectorAll("aside")].flatMap((panel) => {
        const { left, right } = panel.getBoundingClientRect();
        const isOut = (box) => box.width && (box.left < left - 1 || box.right > right + 1);
        return [...panel.querySelectorAll("*")].filter((each) => isOut(each.getBoundingClientRect()))
            .map(({ outerHTML }) => outerHTML.slice(0, 200));
    })"""
    return list(desk.page.evaluate(script))


def write_arrow(path: Path) -> None:
    """Write a shape that has nodes: a circle would have a radius instead."""
    large = Image.new("RGB", (480, 320), "white")
    ImageDraw.Draw(large).polygon(
        [(40, 120), (280, 120), (260, 40), (440, 170), (290, 290), (280, 200), (40, 220)], "navy"
    )
    large.resize((120, 80), Image.Resampling.BOX).save(path)


@pytest.mark.parametrize("window", WINDOWS)
def test_no_state_of_the_page_has_a_serious_fault(
    browser, desk_server: DeskServer, tmp_path: Path, window: str
) -> None:
    write_arrow(tmp_path / "arrow.png")
    desk = DeskPage(browser, desk_server, tmp_path, **WINDOWS[window])
    page = desk.page
    assert faults(desk) == []
    desk.drop(tmp_path / "arrow.png")
    desk.wait_for_status("done")
    assert faults(desk) == [] and outside(desk) == []
    page.locator("#sides label").nth(1).click()
    page.locator("#path-next").click()
    assert faults(desk) == []
    page.locator("#tools label", has_text="Nodes").click()
    page.locator("#node-next").click()
    page.wait_for_selector("#surface[data-points*=node]")
    assert faults(desk) == [] and outside(desk) == []
    page.locator("#help-open").click()
    assert faults(desk) == []
    desk.close()


def test_words_that_are_not_everyday_english_are_explained(desk: DeskPage, tmp_path: Path) -> None:
    Image.fromarray(logo(has_shadow=False)).save(tmp_path / "logo.png")
    desk.drop(tmp_path / "logo.png")
    desk.wait_for_status("done")
    script = r"""(words) => {
        const jargon = new RegExp(`\\b(${words})s?\\b`, "i");
        const isText = ({ nodeType }) => nodeType === Node.TEXT_NODE;
        const own = ({ childNodes }) => [...childNodes].filter(isText).map(({ data }) => data).join("");
        const parts = [...document.querySelectorAll("h2, h2 span, label, label > span, button, th, summary")];
        const found = parts.filter((element) => jargon.test(own(element)));
        const bare = found.filter((element) => !element.closest("[title]"));
        return [found.length, bare.map(({ outerHTML }) => outerHTML)];
    }"""
    count, bare = desk.page.evaluate(script, JARGON)
    assert count > 20
    assert bare == []
