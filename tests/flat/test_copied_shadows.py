"""Shadows that are copies of traced pieces, of pictures that are uneven or were saved as JPEG."""

from __future__ import annotations

import numpy as np
import pytest
from damage import as_jpeg
from PIL import Image

from warpvec.condition.jpeg import Jpeg
from warpvec.flat.evidence.evidence import Evidence
from warpvec.flat.regions.regions import find_regions
from warpvec.flat.softness.copies import find_shadows
from warpvec.rendering.draw import draw_8_bits
from warpvec.svg.read import read_svg

CARD = """<svg xmlns="http://www.w3.org/2000/svg" width="96" height="96"><defs>
<linearGradient id="g" gradientUnits="userSpaceOnUse" x1="15" y1="15" x2="63" y2="52"><stop stop-color="#ffb347"/>
<stop offset="1" stop-color="#d1345b"/></linearGradient><filter id="b" filterUnits="userSpaceOnUse" x="-50" y="-50"
width="200" height="200" color-interpolation-filters="sRGB"><feGaussianBlur stdDeviation="2.5"/></filter></defs>
<rect width="96" height="96" fill="#f4f1ea"/>{shadow}<rect x="15" y="15" width="46" height="34" rx="6" fill="url(#g)"/>
<circle cx="66" cy="58" r="18" fill="#2a6f97"/><path d="M10 84L30 57L50 84Z" fill="#386641"/></svg>"""

SHADOW = '<rect x="18" y="20" width="46" height="34" rx="6" fill="#000" fill-opacity=".35" filter="url(#b)"/>'

HOOK = """<svg xmlns="http://www.w3.org/2000/svg" width="113" height="113" viewBox="0 0 128 128"><defs>
<linearGradient id="g" gradientUnits="userSpaceOnUse" x1="20" y1="20" x2="84" y2="70"><stop stop-color="#ffb347"/>
<stop offset="1" stop-color="#d1345b"/></linearGradient><filter id="f" x="-30%" y="-30%" width="160%" height="160%">
<feGaussianBlur stdDeviation="2.5"/></filter></defs><rect width="128" height="128" fill="#f4f1ea"/>{shadow}
<rect x="20" y="20" width="62" height="46" rx="8" fill="url(#g)"/><circle cx="88" cy="78" r="24" fill="#2a6f97"/>
<path d="M78 16L110 16L110 26L88 26L88 44L78 44Z" fill="#22223b"/></svg>"""


def picture(shadow: str, noise: float, text: str = CARD, side: int = 96) -> np.ndarray:
    scene = read_svg(text.format(shadow=shadow)).scene
    levels = draw_8_bits(scene, side, side, 1)[..., :3].astype(np.float64)
    noisy = levels + np.random.default_rng(0).normal(0.0, noise, levels.shape) if noise else levels
    return np.asarray(np.rint(noisy).clip(0, 255) / 255.0, np.float32)


@pytest.mark.parametrize("noise", [0.0, 2.0])
def test_a_card_among_shapes_casts_its_shadow_even_in_noise(noise: float) -> None:
    pytest.importorskip("svgelements")
    image = picture(SHADOW, noise)
    found = find_shadows(image, find_regions(image), lambda: False)
    assert len(found) == 1
    assert found[0].look.sigma == pytest.approx(2.5, rel=0.2)
    assert found[0].look.offset == pytest.approx((3.0, 5.0), abs=0.6)


def test_a_shadow_goes_away_where_a_shape_hides_what_casts_it() -> None:
    pytest.importorskip("svgelements")
    shadow = '<rect x="23" y="26" width="62" height="46" rx="8" fill-opacity=".35" filter="url(#f)"/>'
    image, clean = (picture(each, 0.0, HOOK, 113) for each in (shadow, ""))
    found = find_shadows(image, find_regions(image), lambda: False)
    assert np.abs(found[-1].clean - clean).max() < 30.0 / 255.0  # a slab of it is 65 levels off


@pytest.mark.parametrize("noise", [0.0, 2.0])
def test_shapes_without_a_shadow_have_none(noise: float) -> None:
    pytest.importorskip("svgelements")
    image = picture("", noise)
    assert not find_shadows(image, find_regions(image), lambda: False)


def test_what_a_jpeg_does_to_colours_at_edges_is_no_shadow() -> None:
    y, x = np.mgrid[:128, :128] + 0.5
    share = (30.5 - np.hypot(x - 64.0, y - 64.0)).clip(0.0, 1.0)[..., None]
    clean = np.rint(255.0 - share * (255.0 - np.array([40.0, 170.0, 190.0]))).astype(np.uint8)
    image = (np.asarray(as_jpeg(Image.fromarray(clean), 80)) / 255.0).astype(np.float32)
    traced = find_regions(image, is_jpeg=True)
    assert not find_shadows(image, traced, lambda: False, Evidence.of(image, Jpeg(80, is_subsampled=True)))
