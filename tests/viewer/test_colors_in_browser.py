"""Changes of whole drawings and paths: size, fewer nodes, a brand, no background, lines, and locked layers."""

from __future__ import annotations

import re

from browser import NEEDS_BROWSER, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)

pytestmark = NEEDS_BROWSER

SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="100" height="80" viewBox="0 0 100 80">
<rect id="background" width="100" height="80" fill="#fffffe"/>
<g id="a"><path fill="#fdfdf0" d="M0 0h100v80h-100z"/></g>
<g id="b"><path fill="#c03020" d="M10 10h30v30h-30z"/></g>
<g id="c"><path fill="#2040c0" d="M50 10h30v30h-30z"/></g>
</svg>"""


def fills(text: str) -> list[str]:
    return re.findall('fill="(#[0-9a-f]+)"', text)


def test_each_colour_becomes_the_nearest_of_a_brand_but_on_locked_layers(open_page) -> None:
    page = open_page(SVG)
    page.page.locator("[aria-label='Lock c']").check()
    page.page.get_by_text("Colours of a brand").click()
    page.page.locator("#brand").fill("Red: #D00000, paper #fff; ink 001")
    page.press_button("brand-apply")
    assert fills(page.saved()) == ["#fff", "#fff", "#d00000", "#2040c0"]
    page.press("Control+z")
    assert fills(page.saved()) == fills(SVG)


def test_a_colour_that_no_path_has_any_more_leaves_the_palette(open_page) -> None:
    page = open_page(SVG)
    page.click(20, 20)
    assert page.page.locator("[name=swatch]:checked").get_attribute("value") == "#c03020"
    page.page.get_by_text("Colours of a brand").click()
    page.page.locator("#brand").fill("#d00000 #fff")
    page.press_button("brand-apply")
    page.page.wait_for_selector("[name=swatch][value='#d00000']:checked")
    assert page.page.locator("[name=swatch]").count() == 2


def test_a_locked_layer_is_not_selected(open_page) -> None:
    page = open_page(SVG)
    page.click(60, 20)
    assert page.selected() == "1 of 3 paths selected: c"
    page.page.locator("[aria-label='Lock c']").check()
    assert page.selected() == "Nothing selected"
    assert page.click(60, 20) == "1 of 3 paths selected: a"


def test_the_background_and_a_shape_over_the_whole_canvas_are_removed(open_page) -> None:
    page = open_page(SVG)
    page.press_button("remove-background")
    assert fills(page.saved()) == ["#c03020", "#2040c0"]
    page.press_button("remove-background")
    assert "no background" in page.text("message")
    page.press("Control+z")
    assert fills(page.saved()) == fills(SVG)


def test_lines_show_the_paths_of_hidden_layers_too(open_page) -> None:
    page = open_page(SVG)
    page.page.locator("[aria-label='Show c']").uncheck()
    page.press("u")
    inside, edge = page.colors([(65, 25), (50.05, 25)])
    assert inside == (255, 255, 255)
    assert max(edge) < 200


def test_needless_nodes_are_left_out_and_corners_stay(open_page) -> None:
    data = "M10 10h10 10 10v12 18h-30z"
    page = open_page(SVG.replace("M10 10h30v30h-30z", data))
    page.click(20, 20)
    page.press_button("simplify")
    assert page.text("message") == "7 nodes became 4"
    assert 'd="M10 10h30v30h-30z"' in page.saved()
    page.press_button("simplify")
    assert "No node can be left out" in page.text("message")
    page.press("Control+z")
    assert f'd="{data}"' in page.saved()


def test_the_width_is_stated_in_millimetres_and_undone(open_page) -> None:
    page = open_page(SVG)
    page.choose("size-unit", "mm")
    assert 'width="26.458mm" height="21.167mm"' in page.saved()
    page.page.locator("#size-width").fill("90")
    page.page.locator("#size-width").press("Enter")
    assert 'width="90mm" height="72mm" viewBox="0 0 100 80"' in page.saved()
    assert "90 \u00d7 72 mm" in page.text("figures")
    page.page.locator("#undo").click()
    page.page.locator("#undo").click()
    assert 'width="100" height="80"' in page.saved()
    assert page.page.input_value("#size-width") == "100"


ONE_COLOR = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
 width="100" height="80" viewBox="0 0 100 80">
<g id="red" inkscape:groupmode="layer" inkscape:label="1 red #c03020"><path fill="#c03020" d="M0 0h30v30h-30z"/>
<path fill="#c03020" d="M40 0h30v30h-30z"/><path fill="#c03020" d="M0 40h30v30h-30z"/></g>
<g id="shades" inkscape:groupmode="layer" inkscape:label="2 grey #808080, shaded"><path fill="#808080" d="M80 0h9v9z"/>
<path fill="#888888" d="M80 40h9v9z"/></g>
</svg>"""


def test_a_layer_of_one_colour_is_saved_apart_when_some_of_it_is_recoloured(open_page) -> None:
    def labels() -> list[str]:
        return re.findall('inkscape:label="([^"]+)"', page.saved())

    page = open_page(ONE_COLOR)
    assert labels() == ["1 red #c03020", "2 grey #808080, shaded"]
    page.click(50, 10)
    page.slide("fill", "#2040c0")
    assert labels() == ["1 red #c03020", "2 blue #2040c0", "3 red #c03020", "4 grey #808080, shaded"]
    text = page.saved()
    assert len(set(re.findall('<g id="([^"]+)"', text))) == 4
    page.press("Control+z")
    assert labels() == ["1 red #c03020", "2 grey #808080, shaded"]
    assert [name.split()[0] for name in re.findall('label="[0-9] ([^"]+)"', open_page(text).saved())] == [
        "red", "blue", "red", "grey",
    ]  # fmt: skip
