"""Test the regions of pictures that JPEG, scanners or enlargement have changed."""

from __future__ import annotations

import io

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.noise import measure_noise, measure_tolerances
from warpvec.flat.regions.regions import Regions, find_regions, premultiplied
from warpvec.geometry.paints.registry import FLAT, LINEAR
from warpvec.svg.resvg import rasterize

Floats = NDArray[np.float32]

FACE = """<rect width="256" height="256" fill="#fff"/><circle cx="128" cy="132" r="105.3" fill="#ffcd88"/>
<path d="M40,60L70,18L110,45Z" fill="#b6885a"/><circle cx="90" cy="110" r="16" fill="#010101"/>
<circle cx="95" cy="104" r="5" fill="#fff"/>
<path d="M75,170Q128,215 185,165" stroke="#c2185b" stroke-width="7" fill="none"/>
<rect x="150.4" y="95.3" width="37" height="22" fill="#4fb5e1"/>"""

PAINTS = {"ffffff", "ffcd88", "b6885a", "010101", "c2185b", "4fb5e1"}


def drawn(elements: str) -> NDArray[np.uint8]:
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="256" height="256">'
    return rasterize(f"{head}{elements}</svg>", sandboxed=False)


def as_jpeg(pixels: NDArray[np.uint8], quality: int, subsampling: int = 2) -> Floats:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=quality, subsampling=subsampling)
    return np.asarray(Image.open(file), np.float32) / 255


def enlarged(pixels: NDArray[np.uint8]) -> Floats:
    small = Image.fromarray(pixels).resize((128, 128), Image.Resampling.LANCZOS)
    return np.asarray(small.resize((256, 256), Image.Resampling.BICUBIC), np.float32) / 255


def is_close(regions: Regions, names: set[str], limit: int) -> bool:
    """Return whether the flat colours are ``names``, within ``limit`` levels."""
    wanted = [list(bytes.fromhex(name)) for name in sorted(names)]
    found = np.unique(np.round(regions.paints.color[regions.paints.kind == FLAT] * 255), axis=0)
    distance = np.abs(found[:, None] - np.array(wanted)[None]).max(2)
    return len(found) == len(wanted) and bool((distance.min(1) <= limit).all())


@pytest.mark.parametrize("quality", [60, 75, 85, 95])
def test_jpeg_has_the_regions_and_colors_of_the_drawing(quality: int) -> None:
    pixels = drawn(FACE)
    assert len(find_regions(pixels.astype(np.float32) / 255)) == 7
    regions = find_regions(as_jpeg(pixels, quality))
    assert len(regions) == 7
    assert is_close(regions, PAINTS, 8)


def test_scans_have_the_regions_of_the_drawing() -> None:
    pixels = drawn(FACE) / 255
    noise = np.random.default_rng(5).normal(0, 0.015, pixels.shape)
    regions = find_regions(np.clip(pixels + noise, 0, 1).astype(np.float32))
    assert len(regions) == 7
    assert is_close(regions, PAINTS, 6)


def test_enlarged_pictures_have_the_regions_of_the_drawing() -> None:
    image = enlarged(drawn(FACE))
    assert measure_tolerances(premultiplied(image)).reach > REGIONS.sharp_reach
    regions = find_regions(image)
    assert len(regions) == 7
    assert is_close(regions, PAINTS, 8)


def test_a_gradient_in_jpeg_is_one_region() -> None:
    gradient = (
        '<linearGradient id="a" x1="0" y1="0" x2="0" y2="1"><stop stop-color="#2aabee"/>'
        '<stop offset="1" stop-color="#1a6fa9"/></linearGradient>'
    )
    pixels = drawn(
        f'{gradient}<rect width="256" height="256" fill="#fff"/><circle cx="128" cy="128" r="120" fill="url(#a)"/>'
    )
    regions = find_regions(as_jpeg(pixels, 80))
    shape = int(regions.label[128, 128])
    assert regions.paints.kind[shape] == LINEAR
    # The corners of the picture are four more.
    assert len(regions) <= 5
    assert abs(regions.paints.at(np.array([shape]), np.array([128.0]), np.array([20.0]))[0, 2] * 255 - 0xE8) < 4


@pytest.mark.parametrize("quality", [60, 80, 95])
def test_noise_of_jpeg_is_told_from_clean_art(quality: int) -> None:
    pixels = drawn(FACE)
    assert measure_noise(premultiplied(pixels.astype(np.float32) / 255)) == 0
    assert measure_noise(premultiplied(as_jpeg(pixels, quality))) > 1.2 / 255


def test_noise_on_one_side_of_a_mark_on_white_is_noise() -> None:
    bars = "".join(f'<rect x="{40 + 52 * k}" y="40" width="28" height="180"/>' for k in range(4))
    turned = f'<g fill="#1a1918" transform="rotate(37 128 128)">{bars}</g>'
    clean = drawn(f'<rect width="256" height="256" fill="#fff"/>{turned}')
    assert measure_noise(premultiplied(as_jpeg(clean, 80))) > 0
    assert measure_noise(premultiplied(clean.astype(np.float32) / 255)) == 0


def test_faint_details_of_a_small_picture_are_no_noise() -> None:
    pixels = np.full((96, 96, 3), 0.5, np.float32)
    pixels[:, np.arange(96) // 6 % 2 == 1, :2] += 2 / 255
    assert measure_noise(premultiplied(pixels)) == 0
    assert measure_noise(premultiplied(np.tile(pixels, (3, 3, 1)))) > 0


def test_pixels_of_a_dropped_area_belong_to_a_region_of_their_color() -> None:
    # A block of a JPEG makes areas of their own at a side. No pure pixel of the shape is as near as the ground.
    pixels = drawn('<rect width="256" height="256" fill="#fff"/><path d="M15,10L90,10V180H40Z" fill="#c6302b"/>')
    clean = premultiplied(pixels[:190, :100] / np.float32(255))
    found = find_regions(as_jpeg(pixels[:190, :100], 30, subsampling=0))
    assert np.abs(found.mixed() - clean).max() < 0.6
