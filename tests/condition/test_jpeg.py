"""The quality of JPEG is found from the pixels, and not in pictures that were never compressed."""

from __future__ import annotations

import io

import numpy as np
from damage import as_jpeg, blurred, drawn, levels_of, noisy
from numpy.typing import NDArray
from PIL import Image
from sweep import sweep

from warpvec.condition.jpeg import Jpeg, find_jpeg
from warpvec.svg.measure import draw


@sweep(("width", "quality"), [(width, quality) for width in (128, 400) for quality in (30, 50, 60, 75, 85, 90)])
def test_the_quality_is_found(width: int, quality: int) -> None:
    found = find_jpeg(levels_of(as_jpeg(drawn(width), quality)))
    assert found is not None
    assert found.quality == quality


@sweep(("width", "quality"), [(64, 75), (96, 90), (128, 50), (256, 90)])
def test_ringing_that_white_cuts_off_is_no_obstacle(width: int, quality: int) -> None:
    found = find_jpeg(levels_of(as_jpeg(drawn(width, "#fff"), quality)))
    assert found is not None
    assert found.quality == quality and found.is_subsampled


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


@sweep("width", [16, 18, 24])
def test_icons_of_few_blocks_are_no_jpeg(width: int) -> None:
    shapes = [
        '<circle cx="12" cy="12" r="8" fill="none" stroke="#e33" stroke-width="3"/>',
        '<path d="M12 2c5 0 7 4 7 8v5l2 3H3l2-3v-5c0-4 2-8 7-8zM9 20h6a3 3 0 0 1-6 0z" fill="#26a"/>',
    ]
    page = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24"><path d="M0 0h24v24H0z" fill="#fff"/>'
    for shape in shapes:
        assert find_jpeg(draw(f"{page}{shape}</svg>", width, width).astype(np.float64)) is None


def test_level_bars_are_no_jpeg_although_their_blocks_look_rounded() -> None:
    bars = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24"><rect width="24" height="24" fill="#fff"/>
<path d="M5 9h14M5 15h14" stroke="#000" stroke-width="2" stroke-linecap="round"/></svg>"""
    assert find_jpeg(draw(bars, 512, 512).astype(np.float64)) is None


def test_a_block_and_its_mirror_image_are_one_witness() -> None:
    levels = np.full((16, 24, 3), 128.0)
    rows, columns = np.mgrid[:8, :8]
    one, other = (decoded(128 + 60 * np.sin(a * rows + b * columns)) for a, b in ((0.5, 0.9), (1.1, 0.3)))
    levels[:8, :8], levels[:8, 8:16] = one, one[:, ::-1]
    assert find_jpeg(levels) is None
    levels[8:, :8] = other
    assert find_jpeg(levels) is not None


def decoded(block: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a block [8, 8] as JPEG of quality 50 [8, 8, 3]."""
    data = io.BytesIO()
    Image.fromarray(block.round().astype(np.uint8)).save(data, "JPEG", quality=50)
    return np.asarray(Image.open(data).convert("RGB")).astype(np.float64)
