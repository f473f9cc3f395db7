"""Uneven light of paper is found in scans alone, and can be made even."""

from __future__ import annotations

import numpy as np
import pytest
from damage import drawn, levels_of, noisy, unevenly_lit
from PIL import Image, ImageDraw

from warpvec.condition.light import find_uneven_light, in_even_light


def sheet(side: int = 320) -> Image.Image:
    """Return black strokes on white paper."""
    image = Image.new("RGB", (side, side), "white")
    pen = ImageDraw.Draw(image)
    for k in range(6):
        pen.line((40, 50 + 40 * k, 260 - 20 * k, 60 + 30 * k), fill="black", width=3)
    pen.ellipse((200, 180, 280, 260), fill="black")
    return image


def test_uneven_light_is_found_and_made_even() -> None:
    paper = sheet()
    lit = levels_of(unevenly_lit(paper, 0.5))
    light = find_uneven_light(lit)
    assert light is not None
    assert light.range == pytest.approx(127.0, rel=0.15)  # from corner to corner
    even = 255.0 * in_even_light((lit / 255.0).astype(np.float32), light)
    is_paper = levels_of(paper).min(2) == 255.0
    assert np.abs(even[is_paper] - 255.0).mean() < 6.0
    assert even[levels_of(paper).max(2) == 0.0].mean() < 30.0


def test_even_paper_and_drawn_gradients_are_not_lit_unevenly() -> None:
    gradient = Image.linear_gradient("L").resize((320, 320)).point(lambda level: 128 + level // 2).convert("RGB")
    for image in (sheet(), noisy(sheet(), 4.0), gradient, drawn(320), noisy(drawn(320), 4.0)):
        assert find_uneven_light(levels_of(image)) is None
