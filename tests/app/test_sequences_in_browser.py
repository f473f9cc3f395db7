"""Whatever order a user does things in: no edit is lost, no figure is stale, and the page reports no error."""

from __future__ import annotations

import itertools
import os
from pathlib import Path

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage
from quick_desk import QuickServer, logo_bytes, quick_server_fixture, write_logo  # noqa: F401  (fixture)

from warpvec.image.metrics import psnr
from warpvec.image.read import read_image
from warpvec.svg.measure import draw_like

pytestmark = NEEDS_BROWSER

STEPS = ("setting", "fit", "edit", "undo", "redo", "stop")

SHARE = 1 if os.environ.get("WARPVEC_ALL_SEQUENCES") else 4
"""One in so many of the sequences is tried; the environment variable asks for all of them, which takes minutes."""

SCRIPT = Path(__file__).with_name("sequences.js").read_text(encoding="utf-8")

BROWSER_GAP = 0.5
"""Largest difference in dB between what the browser and resvg draw of the logo: edges at about 14 to 45 dB."""


def check(desk: DeskPage, source: Path, steps: tuple[str, ...]) -> None:
    """Drop the logo anew, do ``steps`` with it, and remove it again."""
    desk.drop(source)
    desk.page.wait_for_function("() => warpvecView.state.paths && !warpvecView.state.live")
    desk.wait_for_status("done")
    found = desk.page.evaluate("(steps) => run(steps)", list(steps))
    assert not found["faults"], (steps, found["faults"])
    target = read_image(logo_bytes())
    measured = psnr(draw_like(found["text"].encode(), target), target)
    assert abs(measured - found["stated"]) < BROWSER_GAP, (steps, measured, found["stated"])
    desk.page.locator("#pictures button:not(.open)").click()


@pytest.mark.parametrize("first", STEPS)
def test_no_three_steps_lose_an_edit(browser, quick_server: QuickServer, tmp_path: Path, first: str) -> None:
    source = write_logo(tmp_path / "logo.png")
    desk = DeskPage(browser, quick_server, tmp_path)
    desk.page.evaluate(SCRIPT + "null")
    for rest in list(itertools.product(STEPS, repeat=2))[STEPS.index(first) % SHARE :: SHARE]:
        check(desk, source, (first, *rest))
    desk.close()


def test_no_eight_steps_lose_an_edit(browser, quick_server: QuickServer, tmp_path: Path) -> None:
    source = write_logo(tmp_path / "logo.png")
    desk = DeskPage(browser, quick_server, tmp_path)
    desk.page.evaluate(SCRIPT + "null")
    rng = np.random.default_rng(0)
    for _ in range(12 // SHARE):
        check(desk, source, tuple(rng.choice(STEPS, 8).tolist()))
    desk.close()
