"""Enlargements are found with their exact size, and only where there are some."""

from __future__ import annotations

import math

import numpy as np
import pytest
from damage import as_jpeg, blurred, drawn, enlarged, levels_of, noisy
from PIL import Image, ImageDraw
from PIL.Image import Resampling
from sweep import sweep

from warpvec.condition.enlargement import Enlargement, Lines, busiest, find_enlargement
from warpvec.condition.resampling import NEAREST
from warpvec.condition.restoration import before_enlargement

LUMA = np.array([0.299, 0.587, 0.114])


def found_in(image: Image.Image) -> Enlargement | None:
    return find_enlargement(levels_of(image) @ LUMA)


@sweep(
    ("kernel", "width", "factor"),
    [
        (kernel, width, factor)
        for kernel in (Resampling.BILINEAR, Resampling.BICUBIC, Resampling.LANCZOS)
        for width, factor in ((50, 8.0), (110, 2.0), (130, 1.5), (90, 2.7))
    ]
    + [(Resampling.BICUBIC, 75, 5.2), (Resampling.BILINEAR, 75, 5.2)],
)
def test_an_enlargement_is_found_with_its_exact_size_and_kernel(kernel: Resampling, width: int, factor: float) -> None:
    small = drawn(width)
    found = found_in(enlarged(small, factor, kernel))
    assert found is not None
    assert (found.width, found.height) == small.size
    if factor != 2.0:  # linear and cubic kernels make the same pictures from different ones there
        assert found.kernel == kernel.name.lower()


@sweep("factor", [3, 5, 8])
def test_an_enlargement_is_found_where_it_was_cut_off_at_black_and_white(factor: int) -> None:
    large = Image.new("RGB", (240, 240), "white")
    pen = ImageDraw.Draw(large)
    pen.ellipse([19, 34, 144, 158], outline="black", width=22)
    pen.line([48, 216, 211, 72], fill="black", width=17)
    found = found_in(enlarged(large.resize((60, 60), Resampling.BOX), factor, Resampling.BICUBIC))
    assert found is not None
    assert (found.width, found.height, found.kernel) == (60, 60, "bicubic")


@sweep("factor", [2, 3, 8, 20])
def test_whole_pixels_are_found_with_their_exact_size(factor: int) -> None:
    found = found_in(enlarged(drawn(40), factor, Resampling.NEAREST))
    assert found is not None
    assert (found.width, found.kernel) == (40, NEAREST)


@sweep(("factor", "quality"), [(4, 75), (5, 90), (6, 75)])
def test_whole_pixels_are_found_after_jpeg(factor: int, quality: int) -> None:
    found = found_in(as_jpeg(enlarged(drawn(32), factor, Resampling.NEAREST), quality))
    assert found is not None
    assert (found.width, found.kernel) == (32, NEAREST)


@sweep("quality", [90, 75, 60])
def test_an_enlargement_is_found_after_jpeg(quality: int) -> None:
    found = found_in(as_jpeg(enlarged(drawn(100), 4.0, Resampling.BICUBIC), quality))
    assert found is not None
    assert found.width == 100


@sweep("width", [64, 100, 257, 512])
def test_nothing_is_found_in_clean_blurred_noisy_and_compressed_pictures(width: int) -> None:
    clean = drawn(width)
    blurs = [blurred(clean, deviation) for deviation in (0.5, 1.0, 2.0)]
    for image in (clean, *blurs, noisy(clean, 5.0), as_jpeg(clean, 60), as_jpeg(clean, 90)):
        assert found_in(image) is None


def test_edges_and_a_ramp_on_a_grid_of_whole_pixels_are_no_enlargement() -> None:
    levels = np.full((64, 64), 255.0)
    levels[8:44, 8:44] = np.round(np.linspace(18, 11, 36))[:, None]
    assert find_enlargement(levels) is None


def test_an_icon_whose_edges_lie_on_a_grid_is_no_enlargement() -> None:
    # Bars of an icon of 24 px, drawn at 512 px: each edge shares its pixel in one of three ways.
    scale = 512 / 24
    places = np.arange(513)[:, None] / scale
    bars = [[2, 6], [8, 12], [14, 18], [20, 22]]
    share = scale * sum(np.diff(np.clip(places, *bar), axis=0) for bar in bars)
    assert find_enlargement(np.round(255 - 255 * share @ share.T)) is None


def test_nothing_is_found_in_even_and_in_tiny_pictures() -> None:
    assert find_enlargement(np.full((64, 64), 200.0)) is None
    assert find_enlargement(np.arange(9.0).reshape(3, 3)) is None


@pytest.mark.parametrize("kernel", [Resampling.BILINEAR, Resampling.BICUBIC, Resampling.LANCZOS, Resampling.NEAREST])
def test_the_picture_before_its_enlargement_comes_back(kernel: Resampling) -> None:
    small = drawn(60)
    large = enlarged(small, 4.0, kernel)
    found = found_in(large)
    assert found is not None
    restored = before_enlargement((levels_of(large) / 255.0).astype(np.float32), found)
    error = 255.0 * restored - levels_of(small)
    assert (
        np.sqrt((error**2).mean()) < 1.5
    )  # rounding of the large picture, and what was cut off beyond black and white


def test_a_transparent_picture_comes_back_with_its_alpha() -> None:
    small = drawn(60).convert("RGBA")
    alpha = Image.fromarray(np.where(levels_of(small)[..., 2] > 200, 0, 255).astype(np.uint8))
    small.putalpha(alpha)
    large = small.resize((240, 192), Resampling.BICUBIC)
    pixels = np.asarray(large).astype(np.float32) / 255.0
    restored = before_enlargement(pixels, Enlargement(60, 48, "bicubic", 4.0, 0.0))
    expected = np.asarray(small).astype(np.float64) / 255.0
    assert np.abs(restored[..., 3] - expected[..., 3]).mean() < 0.02
    is_opaque = expected[..., 3] == 1.0
    assert np.abs(restored[..., :3] - expected[..., :3])[is_opaque].mean() < 0.02


def test_a_dip_that_is_too_shallow_is_known_without_all_sizes_beside_it() -> None:
    rows = busiest((levels_of(enlarged(drawn(90), 2.0, Resampling.BICUBIC)) @ LUMA).T)
    dips = [Lines(rows).dip(size, "bicubic", is_cut=True) for size in (90, 120)]
    lines = Lines(rows)
    found = [lines.dip(size, "bicubic", is_cut=True, most=2.0 * dips[0]) for size in (90, 120)]
    assert found == [dips[0], math.inf] and dips[1] > 2.0 * dips[0]
    assert {size for size, *_ in lines._known if size > 100} < {118, 119, 120, 121, 122}


def test_even_cells_on_white_are_no_enlargement() -> None:
    rng, levels = np.random.default_rng(4), np.full((420, 640), 255.0)
    for row in range(15):
        for column in range(24):
            top, left = 33 + 22 * row, 32 + 22 * column
            levels[top : top + 20, left : left + 20] = rng.uniform(60.0, 180.0)
    assert find_enlargement(levels) is None
