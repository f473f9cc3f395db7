"""The quality of JPEG is found from the pixels, and not in pictures that were never compressed."""

from __future__ import annotations

import numpy as np
import pytest
from damage import as_jpeg, blurred, drawn, levels_of, noisy
from sweep import sweep

from warpvec.condition.jpeg import Jpeg, find_jpeg
from warpvec.svg.measure import draw


@sweep(("width", "quality"), [(width, quality) for width in (128, 400) for quality in (30, 50, 60, 75, 85, 90)])
def test_the_quality_is_found(width: int, quality: int) -> None:
    found = find_jpeg(levels_of(as_jpeg(drawn(width), quality)))
    assert found is not None
    assert found.quality == pytest.approx(quality, abs=3)


@sweep("quality", [50, 75, 90])
def test_colors_at_half_size_are_found(quality: int) -> None:
    image = drawn(300)
    half, full = (find_jpeg(levels_of(as_jpeg(image, quality, subsampling))) for subsampling in (2, 0))
    assert isinstance(half, Jpeg) and half.is_subsampled
    assert isinstance(full, Jpeg) and not full.is_subsampled


@sweep("width", [20, 64, 100, 257, 512])
def test_pictures_that_were_not_compressed_are_no_jpeg(width: int) -> None:
    clean = drawn(width)
    for image in (clean, blurred(clean, 1.0), noisy(clean, 5.0)):
        assert find_jpeg(levels_of(image)) is None


def test_level_bars_are_no_jpeg_although_their_blocks_look_rounded() -> None:
    bars = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24"><rect width="24" height="24" fill="#fff"/>
<path d="M5 9h14M5 15h14" stroke="#000" stroke-width="2" stroke-linecap="round"/></svg>"""
    assert find_jpeg(draw(bars, 512, 512).astype(np.float64)) is None
