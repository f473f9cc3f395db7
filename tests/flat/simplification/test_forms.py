"""Outlines that are circles, ellipses and rectangles are found in pictures, with what is hidden, and no others."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.flat.drawing import FlatDrawing
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, OUTLINE, RECT, ROUND_RECT
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw

CONFIG = FitConfig(threads=1, device="cpu")
SIDE, SAMPLES = 96, 4


def drawn(shapes: str) -> Scene:
    """Return the drawing of a picture of ``shapes`` of SVG."""
    text = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 96 96" width="96" height="96">{shapes}</svg>'
    large = draw(text.replace('width="96" height="96"', 'width="384" height="384"'), SIDE * SAMPLES, SIDE * SAMPLES)
    mean = large.reshape(SIDE, SAMPLES, SIDE, SAMPLES, 3).mean((1, 3))
    image = torch.from_numpy((np.round(mean) / 255).astype(np.float32))
    with torch.no_grad():
        return FlatDrawing(image, CONFIG).draw(CONFIG.detail)[0]


def forms(scene: Scene) -> dict[int, Tensor]:
    """Return the parameters [6] of the last form of each kind."""
    if scene.forms is None:
        return {}
    return dict(zip(scene.forms.kind.tolist(), scene.forms.parameters, strict=True))


def test_forms_are_found_with_their_numbers() -> None:
    found = forms(
        drawn(
            """<circle fill="#c22" cx="22.3" cy="21.6" r="14.4"/>
<ellipse fill="#27c" cx="66" cy="24" rx="20.5" ry="11.2" transform="rotate(30 66 24)"/>
<rect fill="#182" x="10.4" y="52.7" width="29.5" height="33.1"/>
<rect fill="#b3b" x="54" y="55" width="32" height="28" rx="8" transform="rotate(15 70 69)"/>"""
        )
    )
    assert found.keys() == {CIRCLE, ELLIPSE, RECT, ROUND_RECT}
    assert found[CIRCLE][:3].tolist() == pytest.approx([22.3, 21.6, 14.4], abs=0.05)
    ellipse = found[ELLIPSE][[0, 1, 4]].tolist()
    assert ellipse == pytest.approx([66.0, 24.0, math.radians(30)], abs=0.05)
    assert found[RECT][:5].tolist() == pytest.approx([25.15, 69.25, 29.5, 33.1, 0.0], abs=0.1)  # resvg's quarter steps
    assert found[ROUND_RECT].tolist() == pytest.approx([70.0, 69.0, 32.0, 28.0, math.radians(15), 8.0], abs=0.15)


def test_a_ground_with_a_gradient_is_the_rectangle_of_the_picture() -> None:
    scene = drawn(
        """<linearGradient id="g" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="20" y2="96">
<stop stop-color="#a8d8f0"/><stop offset="1" stop-color="#f8e0c0"/></linearGradient>
<rect width="96" height="96" fill="url(#g)"/><circle fill="#c22" cx="40" cy="44" r="20"/>"""
    )
    assert scene.forms is not None and scene.forms.kind.tolist() == [RECT, CIRCLE]
    assert scene.forms.parameters[0].tolist() == pytest.approx([48.0, 48.0, 96.0, 96.0, 0.0, 0.0], abs=1e-4)


def test_a_disc_behind_a_square_is_a_whole_circle() -> None:
    scene = drawn(
        """<circle fill="#c22" cx="40" cy="44" r="28"/><rect fill="#27c" x="42.5" y="40.5" width="45" height="45"/>"""
    )
    found = forms(scene)
    assert found[CIRCLE][:3].tolist() == pytest.approx([40.0, 44.0, 28.0], abs=0.1)
    assert found[RECT][2:4].tolist() == pytest.approx([45.0, 45.0], abs=0.1)


@pytest.mark.parametrize("lobes", [2, 3, 5])
def test_a_blob_is_no_circle(lobes: int) -> None:
    angle = np.linspace(0.0, 2 * math.pi, 200)
    radius = 30 + 0.8 * np.cos(lobes * angle + 0.3)
    points = " ".join(
        f"{48 + r * math.cos(a):.3f},{47 + r * math.sin(a):.3f}" for r, a in zip(radius, angle, strict=True)
    )
    found = forms(drawn(f'<polygon fill="#134" points="{points}"/>'))
    assert CIRCLE not in found and (ELLIPSE not in found or lobes == 2)


def test_dots_apart_become_circles_and_a_letter_stays_whole() -> None:
    dots = "".join(f'<circle fill="#222" cx="{x}" cy="20.3" r="8"/>' for x in (16, 44, 72))
    scene = drawn(f'{dots}<path fill="#c40" d="M20 40h8v40h-8zM24 40M40 40h20v8h-12v24h12v8h-20zM70 40h12l-6 40z"/>')
    assert scene.forms is not None
    assert scene.forms.kind.tolist().count(CIRCLE) == 3 and OUTLINE in scene.forms.kind.tolist()
    assert RECT not in scene.forms.kind.tolist()  # a letter of a word, which four lines state as well
