"""Gradients of many stops become the nearest ones of two, whose colours are known in closed form."""

from __future__ import annotations

import torch

from warpvec.geometry.paints.registry import ELLIPTIC, FLAT
from warpvec.geometry.two_stops import with_two_stops
from warpvec.svg.read import read_svg

FILE = """<svg xmlns="http://www.w3.org/2000/svg" width="40" height="40"><defs>
<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="40" y2="0"><stop offset="0" stop-color="#000"/>
<stop offset=".5" stop-color="#808080"/><stop offset="1" stop-color="#fff"/></linearGradient>
<linearGradient id="b" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="40" y2="0"><stop offset="0" stop-color="#f00"/>
<stop offset="1" stop-color="#f00" stop-opacity="0"/></linearGradient>
<radialGradient id="c" gradientUnits="userSpaceOnUse" cx="0" cy="0" r="1" gradientTransform="matrix(20 0 0 10 20 20)">
<stop offset="0" stop-color="#00f"/><stop offset="1" stop-color="#0000fe"/></radialGradient></defs>
<path fill="url(#a)" d="M0 0h40v9z"/><path fill="url(#b)" d="M0 9h40v9z"/><path fill="url(#c)" d="M0 19h40v9z"/>
<path fill="#123456" fill-opacity=".5" d="M0 30h40v9z"/></svg>"""


def test_a_ramp_in_three_stops_keeps_its_ends_and_fading_becomes_the_opacity_of_the_path() -> None:
    scene = read_svg(FILE).scene
    assert scene.gradients is not None and scene.gradients.stops is not None and ELLIPTIC in scene.gradients.kind
    found = with_two_stops(scene)
    assert found.gradients is not None and found.gradients.stops is None
    assert torch.allclose(found.color[0], torch.zeros(3), atol=0.01)
    assert torch.allclose(found.gradients.end_color[0], torch.ones(3), atol=0.01)
    assert torch.allclose(found.color[1], torch.tensor([1.0, 0.0, 0.0]), atol=1e-3)
    assert abs(float(found.opacity[1]) - 0.5) < 1e-3
    assert found.gradients.kind[2] == FLAT and torch.allclose(found.color[2], torch.tensor([0.0, 0.0, 1.0]), atol=0.01)
    assert torch.equal(found.color[3], scene.color[3]) and float(found.opacity[3]) == float(scene.opacity[3])
