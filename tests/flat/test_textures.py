"""Photos in drawings are found, take simple outlines, and show through windows of the drawing."""

from __future__ import annotations

import numpy as np
import torch
from cards import card, texture
from damage import as_jpeg
from logo import logo, over_matte
from PIL import Image
from sweep import sweep

from warpvec.flat.cutting.windows import with_windows
from warpvec.flat.texture_outlines import with_key
from warpvec.flat.textures import _has_many_levels, find_textures
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw
from warpvec.svg.resvg import rasterize
from warpvec.svg.write import write_svg


@sweep("form", ["rectangle", "ellipse"])
def test_a_photo_in_a_drawing_is_found_with_its_outline(form: str) -> None:
    image, share = card(form)
    found = find_textures(image)
    assert found is not None
    assert (found != (share > 0.0)).mean() < 0.01
    keyed = with_key(image, found)
    covered = np.abs(keyed.image - image).sum(2) > 0.0
    assert covered[share == 0.0].mean() < 0.002
    distance = np.abs(keyed.image - keyed.color).max(2)
    assert distance[share == 1.0].mean() < 0.01
    edge = (share > 0.2) & (share < 0.8)
    assert not edge.any() or abs(float((1.0 - distance / distance[0, 0])[edge].mean() - share[edge].mean())) < 0.1


def test_drawings_and_photos_have_no_photos_in_them() -> None:
    image, share = card("rectangle")
    shaded = np.linspace(0.2, 0.9, 200, dtype=np.float32)[None, :, None].repeat(160, 0).repeat(3, 2)
    assert find_textures(texture(160, 200).astype(np.float32)) is None
    small, larger = image[60:124, 60:124], image[60:128, 60:128]
    assert find_textures(small) is None and find_textures(larger) is not None
    assert find_textures(np.where(share[..., None] > 0.0, shaded, image)) is None
    assert find_textures(image[:20, :20]) is None
    assert find_textures(over_matte(logo() / np.float32(255.0), 1.0)) is None  # it has a shadow
    lines = image.copy()
    lines[share > 0.0] = 1.0
    lines[30:130:6, 80:180] = 0.0
    assert find_textures(lines) is None


def test_traces_of_a_jpeg_around_an_edge_are_no_levels_of_a_photo() -> None:
    noise = np.random.default_rng(1).normal(0.0, 9.0, (40, 40, 3))
    edge = np.where(np.arange(40)[:, None] < 20, 0.0, 255.0)
    traces = np.rint(edge + noise).clip(0.0, 255.0).astype(np.int16)
    assert not _has_many_levels(traces.reshape(-1, 3))
    assert _has_many_levels(np.rint(255.0 * texture(40, 40)).astype(np.int16).reshape(-1, 3))


def test_what_lies_below_a_drawing_shows_in_its_windows_alone() -> None:
    def square(left: float, side: float) -> torch.Tensor:
        corners = torch.tensor([[left, left], [left + side, left], [left + side, left + side], [left, left + side]])
        return torch.stack([corners, corners + 1e-6, corners.roll(-1, 0) - 1e-6], 1).reshape(12, 2)

    points = torch.stack([square(4.0, 20.0), square(10.0, 20.0), square(26.0, 8.0)])
    color = torch.tensor([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    scene = Scene.uniform(points, color, torch.ones(3), torch.ones(3), torch.zeros(3, dtype=torch.int64))
    cut = with_windows(scene, torch.tensor([False, True, False]), 40, 40)
    assert len(cut) == 3  # the page, and two squares
    before = draw(write_svg(scene, 40, 40), 40, 40)
    after = draw(write_svg(Scene(**{**vars(cut), "background": torch.zeros(3)}), 40, 40), 40, 40)
    is_window = (before == (0, 255, 0)).all(2)
    assert is_window.sum() > 300
    np.testing.assert_array_equal(after[is_window], 0)
    np.testing.assert_array_equal(after[~is_window], before[~is_window])


def test_lines_on_a_ramp_are_no_photo_as_jpeg() -> None:
    lines = "".join(
        f'<circle cx="{128 + 60 * np.cos(turn):.1f}" cy="{128 + 60 * np.sin(turn):.1f}" r="22"/><path d="M128,128L'
        f'{128 + 100 * np.cos(turn):.1f},{128 + 100 * np.sin(turn):.1f}"/>'
        for turn in np.arange(0.3, 6.3, 0.9)
    )
    drawing = f"""<svg xmlns="http://www.w3.org/2000/svg" width="256" height="256"><defs>
    <linearGradient id="a" x1="0" y1="1" x2="1" y2="0"><stop stop-color="#b0084d"/>
    <stop offset="1" stop-color="#ff4f8b"/></linearGradient></defs><rect width="256" height="256" fill="#fff"/>
    <rect x="18" y="18" width="220" height="220" fill="url(#a)"/>
    <g fill="none" stroke="#fff" stroke-width="5">{lines}</g></svg>"""
    image = as_jpeg(Image.fromarray(rasterize(drawing, sandboxed=False)), 50)
    assert find_textures(np.asarray(image, np.float32) / 255.0, is_jpeg=True) is None


def test_bars_with_a_gradient_are_no_photo_as_poor_jpeg() -> None:
    bars = "".join(
        f'<rect x="{x}" y="{90 - high}" width="5" height="{2 * high}" rx="2.5"/>'
        for x, high in zip(range(20, 160, 10), np.random.default_rng(0).integers(45, 80, 14), strict=True)
    )
    drawing = f"""<svg xmlns="http://www.w3.org/2000/svg" width="180" height="180"><defs>
    <linearGradient id="a" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="0" y2="180"><stop stop-color="#ff8c14"/>
    <stop offset="1" stop-color="#f0323c"/></linearGradient></defs><rect width="180" height="180" fill="#fff"/>
    <g fill="url(#a)">{bars}</g></svg>"""
    image = as_jpeg(Image.fromarray(rasterize(drawing, sandboxed=False)), 30)
    assert find_textures(np.asarray(image, np.float32) / 255.0, is_jpeg=True) is None
