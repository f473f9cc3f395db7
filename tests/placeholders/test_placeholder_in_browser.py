"""Chromium shows a placeholder as resvg does, from CSS and from an image element."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from browser import NEEDS_BROWSER, browser_fixture
from PIL import Image, ImageDraw

import warpvec
from warpvec.image.metrics import psnr
from warpvec.placeholders.text import PREFIX
from warpvec.svg.measure import draw

pytestmark = NEEDS_BROWSER
__all__ = ["browser_fixture"]

PAGE = """<!doctype html><style>body {{ margin: 0 }} div, img {{ width: 480px; height: 320px; display: block }}
div {{ background: url("{uri}") }}</style><div></div><img src="{uri}">"""


def test_chromium_shows_it_as_resvg_does(browser: Any, tmp_path: Path) -> None:
    picture = Image.new("RGB", (480, 320), (90, 150, 220))
    pen = ImageDraw.Draw(picture)
    pen.ellipse((60, 40, 300, 260), fill=(240, 200, 40))
    pen.rectangle((0, 220, 480, 320), fill=(30, 90, 40))
    uri = warpvec.placeholder(picture)
    (tmp_path / "page.html").write_text(PAGE.format(uri=uri))
    page = browser.new_page(viewport={"width": 480, "height": 640})
    page.goto((tmp_path / "page.html").as_uri())
    shot = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
    page.close()
    svg = uri.removeprefix(PREFIX).replace("%23", "#")
    for part in (shot[:320], shot[320:]):
        assert psnr(part, draw(svg, 480, 320)) > 35.0
        assert psnr(part, np.asarray(picture)) > 24.0
