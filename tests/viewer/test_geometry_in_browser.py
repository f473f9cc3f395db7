"""Nodes and differences of the page on random shapes: its own modules, run in a real Chromium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixtures)

from warpvec.viewer.modules import module_scripts, module_texts

pytestmark = NEEDS_BROWSER

CHECKS = Path(__file__).parent / "geometry_checks.js"


@pytest.mark.parametrize("check", ["checkNodes(1500)", "checkDifferences(3000)"])
def test_random_changes_leave_nothing_wrong(browser: Any, check: str) -> None:
    texts = {**module_texts("viewer"), "tests/checks.js": CHECKS.read_text(encoding="utf-8")}
    blank = browser.new_page()
    blank.set_content(module_scripts("tests/checks.js", "any", texts))
    blank.wait_for_function("() => window.checkNodes")
    faults = blank.evaluate(f"() => {check}")
    blank.close()
    assert faults == []
