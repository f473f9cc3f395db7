"""Days of work on the page, with the mouse alone and with keys alone: a cutter, and a brand."""

from __future__ import annotations

import re
from pathlib import Path
from zipfile import ZipFile

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage
from desk_hands import HANDS, Keys, Mouse, focus, press
from quick_desk import QuickServer, quick_server_fixture, write_logo  # noqa: F401  (fixture)

pytestmark = NEEDS_BROWSER

GREEN, ORANGE, BLUE = "#2e9b4f", "#ff8000", "#1c4fa0"

SWATCHES_MAX = 12
"""Steps that pass by all swatches: the logo has four colours."""


def fills(text: str) -> set[str]:
    """Return the colours of the paths of a drawing, of six digits."""
    found = re.findall(r'<(?:path|circle|ellipse|rect|g)\b(?![^>]*id="background")[^>]*fill="#(\w+)"', text)
    return {"#" + (digits if len(digits) == 6 else "".join(2 * digit for digit in digits)) for digits in found}


def recolour_by_mouse(hand: Mouse) -> None:
    """Choose the green shape, and drag the hue of its colour to that of orange."""
    hand.desk.click(40, 40)
    hand.desk.drag_slider("hue", 30)


def recolour_by_keys(hand: Keys) -> None:
    """Step to the green swatch of the palette, and type the code of another colour."""
    focus(hand.desk, "swatch")
    for _ in range(SWATCHES_MAX):
        hand.page.keyboard.press("ArrowRight")
        if hand.page.evaluate("() => document.activeElement.value") == GREEN:
            break
    else:
        raise AssertionError(f"there is no swatch {GREEN}")
    press(hand.desk, "replace-hex", "Control+a")
    hand.page.keyboard.type(ORANGE)
    hand.page.keyboard.press("Enter")


@pytest.mark.parametrize("way", HANDS)
def test_a_logo_is_recoloured_cut_out_in_millimetres_and_saved_as_dxf(
    browser, quick_server: QuickServer, tmp_path: Path, way: str
) -> None:
    ezdxf = pytest.importorskip("ezdxf")
    from ezdxf import bbox

    desk = DeskPage(browser, quick_server, tmp_path)
    hand = HANDS[way](desk)
    hand.choose(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    hand.turn_to("edit")
    recolour_by_mouse(hand) if isinstance(hand, Mouse) else recolour_by_keys(hand)
    recoloured = fills(desk.page.evaluate("() => warpvecView.drawingText()"))
    assert GREEN not in recoloured and len(recoloured) == 4
    hand.turn_to("make")
    with desk.fitting():
        hand.click("set-cutout")
    assert fills(desk.page.evaluate("() => warpvecView.drawingText()")) == recoloured
    if isinstance(hand, Mouse):
        desk.page.locator("#size-unit").select_option("mm")
    else:
        press(desk, "size-unit", "m")
    desk.page.wait_for_function("() => document.getElementById('size-width').value === '63.5'")
    document = ezdxf.readfile(hand.save("dxf"))
    assert not document.audit().errors
    found = bbox.extents(document.modelspace())
    assert found.size.x < 63.5 and found.size.x == pytest.approx(200 / 240 * 63.5, abs=0.1)
    colors = {f"#{layer.rgb[0]:02x}{layer.rgb[1]:02x}{layer.rgb[2]:02x}" for layer in document.layers if layer.rgb}
    assert recoloured <= colors
    desk.close()


@pytest.mark.parametrize("way", HANDS)
def test_a_drawing_gets_the_colours_of_a_brand_but_for_a_locked_layer(
    browser, quick_server: QuickServer, tmp_path: Path, way: str
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    hand = HANDS[way](desk)
    hand.choose(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    hand.turn_to("edit")
    label = f"Lock darkslateblue {BLUE}"
    if isinstance(hand, Mouse):
        desk.page.get_by_label(label).click()
        desk.page.locator("summary", has_text="Colours of a brand").click()
        desk.page.locator("#brand").evaluate("(box) => { box.value = '#111111 ff8000 #ffffff'; }")  # pasted by a menu
    else:
        press(desk, label, "Space")
        press(desk, "Colours of a brand", "Enter")
        press(desk, "brand")
        desk.page.keyboard.type("#111111 ff8000 #ffffff")
    hand.click("brand-apply")
    with desk.page.expect_download() as download:
        desk.page.locator("#save").click() if isinstance(hand, Mouse) else desk.page.keyboard.press("Control+s")
    saved = Path(download.value.path()).read_text()
    assert BLUE in fills(saved)
    assert fills(saved) <= {BLUE, "#111111", ORANGE, "#ffffff"}
    desk.close()


@pytest.mark.parametrize("way", HANDS)
def test_sheets_of_vinyl_are_made_and_what_may_go_wrong_is_said(
    browser, quick_server: QuickServer, tmp_path: Path, way: str
) -> None:
    pytest.importorskip("shapely")
    desk = DeskPage(browser, quick_server, tmp_path)
    page, hand = desk.page, HANDS[way](desk)
    hand.choose(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    with desk.fitting():
        page.locator("[data-machine=vinyl]").click() if isinstance(hand, Mouse) else press(desk, "Vinyl", "Space")
    assert page.is_checked("#set-cutout") and page.is_checked("[name=set-mode][value=flat]")
    hand.click("make-check")
    page.locator("#make-warnings li").first.wait_for()
    assert page.locator("#make-warnings li").all_inner_texts()[0] == "The drawing is 63.5 x 42.33 mm."
    with page.expect_download() as download:
        hand.click("make-save")
    with ZipFile(download.value.path()) as sheets:
        names = sheets.namelist()
        assert len(names) == 4 and "01-2e9b4f.svg" in names
        assert b'fill="#2e9b4f"' in sheets.read("01-2e9b4f.svg")
    page.keyboard.press("Control+z")
    assert page.locator("#make-warnings li").count() == 0
    assert not page.is_checked("#set-cutout") and page.is_checked("[name=set-mode][value=auto]")
    assert page.locator("[data-machine][aria-pressed=true]").count() == 0 and page.is_hidden("#make-box")
    desk.close()


def test_a_machine_stays_chosen_only_while_the_controls_are_set_for_it(
    browser, quick_server: QuickServer, tmp_path: Path
) -> None:
    pytest.importorskip("shapely")
    desk = DeskPage(browser, quick_server, tmp_path)
    page = desk.page
    for machine in ("laser", "vinyl"):  # of the same settings
        page.locator(f"[data-machine={machine}]").click()
        pressed = page.locator("[data-machine][aria-pressed=true]")
        assert pressed.count() == 1 and pressed.get_attribute("data-machine") == machine
        assert page.is_visible("#make-box") and page.is_disabled("#make-save")
    page.locator("#set-cutout").uncheck()
    assert pressed.count() == 0 and page.is_hidden("#make-box")
    page.locator("#set-cutout").check()
    assert pressed.count() == 1
    desk.close()


def test_what_may_go_wrong_with_a_drawing_is_not_said_of_the_next_one(
    browser, quick_server: QuickServer, tmp_path: Path
) -> None:
    pytest.importorskip("shapely")
    desk = DeskPage(browser, quick_server, tmp_path)
    page, held = desk.page, []
    desk.drop(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    with desk.fitting():
        page.locator("[data-machine=vinyl]").click()
    page.route("**/cut?*", lambda route: route.continue_() if held else held.append(route))
    page.evaluate("""() => {
        window.lists = 0;
        const count = (changes) => { window.lists += changes.filter(({ addedNodes }) => addedNodes.length).length; };
        new MutationObserver(count).observe(document.getElementById("make-warnings"), { childList: true });
    }""")
    with page.expect_request("**/cut?*"):
        page.locator("#make-check").click()
    page.evaluate("() => warpvecView.app.select(warpvecView.app.drawing.layers[0].items)")
    page.locator("#surface").press("Delete")
    with page.expect_response("**/cut?*") as answer:
        held[0].continue_()
    answer.value.finished()
    page.locator("#make-check").click()
    page.locator("#make-warnings li").first.wait_for()
    assert page.evaluate("() => window.lists") == 1
    desk.close()


def test_each_value_of_a_slider_stands_in_one_line_beside_it(
    browser, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    found = desk.page.evaluate("""() => [...document.querySelectorAll("#desk input[type=range]")].flatMap((slider) => {
        const text = document.getElementById(`${slider.id}-text`);
        return Array.from({ length: Number(slider.max) + 1 }, (_, step) => {
            slider.value = step;
            slider.dispatchEvent(new Event("input"));
            const lines = text.scrollHeight / parseFloat(getComputedStyle(text).lineHeight);
            const isWide = text.scrollWidth > text.clientWidth;
            return { text: text.textContent, lines, isWide, slider: slider.clientWidth };
        });
    })""")
    assert len(found) > 50
    assert [each["text"] for each in found if each["lines"] > 1.5 or each["isWide"] or each["slider"] < 120] == []
    desk.close()
