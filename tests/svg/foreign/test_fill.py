"""Gradients of other programs become one colour."""

from __future__ import annotations

import pytest
from svg_files import square_file

from warpvec.svg.foreign import fill
from warpvec.svg.read import read_svg


def test_the_mean_colour_of_a_gradient_is_over_its_length_and_premultiplied(monkeypatch):
    monkeypatch.setattr(fill, "RAMP_EFFORT", 0)
    stops = 2 * '<stop offset="0.5" stop-color="red"/>' + '<stop offset="1" style="stop-color:#00f;stop-opacity:0"/>'
    gradients = f'<linearGradient id="a">{stops}</linearGradient><radialGradient id="b" xlink:href="#a"/>'
    scene = read_svg(square_file(f'{gradients}<rect width="9" height="9" fill="url(#b)" fill-opacity=".5"/>')).scene
    assert scene.color[0].tolist() == [1, 0, 0]
    assert scene.opacity[0].item() == pytest.approx(0.5 * 0.75)
