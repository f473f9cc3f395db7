"""The next drawing keeps locked and hidden layers, leaves locked paths, and says why it is of its kind."""

from __future__ import annotations

from pathlib import Path

from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage
from desk_edits import RECOLOUR
from quick_desk import QuickServer, quick_server_fixture, write_logo  # noqa: F401  (fixture)

pytestmark = NEEDS_BROWSER


def wait_for_states(desk: DeskPage, expected: dict[str, list[bool]]) -> None:
    """Wait until each layer, by the first word of its name, is shown and locked as ``expected``."""
    script = """(expected) => {
        const rows = [...document.querySelectorAll("#layers tbody tr")].map((row) =>
            [row.innerText.trim().split(/\\s/)[0], [...row.querySelectorAll("input")].map(({ checked }) => checked)]);
        return rows.length === Object.keys(expected).length
            && rows.every(([name, states]) => String(states) === String(expected[name]));
    }"""
    desk.page.wait_for_function(script, arg=expected)


def test_a_recoloured_layer_stays_locked_and_hidden_and_is_not_fitted(
    browser, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    page = desk.page
    desk.drop(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    page.evaluate(RECOLOUR, ["#2e9b4f", "#ff8000"])
    page.get_by_label("Lock orange #ff8000").check()
    page.get_by_label("Show goldenrod #f2c230").uncheck()
    with desk.fitting():
        page.locator("#set-cutout").check()
    expected = {
        "darkorange": [True, True], "darkslateblue": [True, False], "firebrick": [True, False],
        "goldenrod": [False, False],
    }  # fmt: skip
    wait_for_states(desk, expected)
    page.evaluate("() => { window.sent = null; window.desk.fitAgain = (text, locked) => { window.sent = locked; }; }")
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")  # of the recolouring: no path is edited now
    page.locator("#fit-again").evaluate("(button) => button.click()")
    assert page.evaluate("() => window.sent") == [0]
    desk.close()


def test_a_drawing_that_is_fitted_again_keeps_why_it_is_of_its_kind(
    browser, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    desk.drop(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    with desk.fitting():
        desk.page.locator("#fit-again").evaluate("(button) => button.click()")
    found = desk.page.locator("#found")
    assert (found.inner_text(), found.get_attribute("title")) == ("found: flat", "it has few colours")
    desk.close()
