"""Nodes and differences of the page on random shapes: its own scripts, run in a real Chromium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixtures)

from warpvec.viewer import page

pytestmark = NEEDS_BROWSER

SCRIPTS = ("paths", "pen", "basics", "gradients", "brush", "raster", "changes", "nodes")


@pytest.mark.parametrize("check", ["checkNodes(1500)", "checkDifferences(3000)"])
def test_random_changes_leave_nothing_wrong(browser: Any, check: str) -> None:
    folder = Path(page.__file__).parent / "assets"
    texts = [(folder / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS]
    texts.append((Path(__file__).parent / "geometry_checks.js").read_text(encoding="utf-8"))
    blank = browser.new_page()
    script = "\n".join(texts)
    faults = blank.evaluate(f'() => {{ "use strict";\n{script}\nreturn {check}; }}')
    blank.close()
    assert faults == []
