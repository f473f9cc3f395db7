"""The values of a drawing: gradient, Gauss-Newton matrix and bounds against pictures that are drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.joints import with_lines
from warpvec.geometry.scene import Scene
from warpvec.polish.gauss_newton import gauss_newton
from warpvec.polish.variables import Variables
from warpvec.rendering.draw import draw_pixels
from warpvec.svg.read import read_svg

TEXT = """<svg xmlns="http://www.w3.org/2000/svg" width="48" height="48">
<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="5" y1="8" x2="30" y2="21"><stop stop-color="#d84"/>
<stop offset="1" stop-color="#26c"/></linearGradient>
<radialGradient id="b" gradientUnits="userSpaceOnUse" cx="33" cy="30" r="14"><stop stop-color="#ed5"/>
<stop offset="1" stop-color="#152"/></radialGradient>
<path fill="url(#a)" d="M8 8 H28 C36 8 40 14 40 22 V30 C30 26 24 40 16 36 C10 33 8 20 8 8z M14 14 V20 H20z"/>
<circle fill="url(#b)" cx="32" cy="30" r="11"/>
<path fill="#7b3" d="M6 40 L30 41 L22 46z"/></svg>"""

CONFIG = FitConfig(threads=1)

SLOPE = 2e-4
"""How much the loss changes with a typical one of these moves. A move may change the number of chords of a curve, which
the derivatives overlook, so medians are compared."""


@pytest.fixture
def scene() -> Scene:
    """Lines, smooth nodes, corners, a hole, both kinds of gradients, and a circle."""
    scene = read_svg(TEXT).scene.scaled(1.04).moved(0.31, 0.43)  # off the borders of pixels, where the loss has kinks
    return with_lines(replace(scene, background=torch.tensor([0.9, 0.8, 0.7]), transparent=False))


def _picture(scene: Scene) -> Tensor:
    return torch.from_numpy(draw_pixels(scene, 48, 48, **CONFIG.render_settings))


def _drawing(scene: Scene, free: bool = False) -> Variables:
    goal = _picture(scene.moved(0.4, -0.3)) * 0.9
    return Variables(scene, Target(goal, CONFIG, "cpu"), CONFIG, free=free)


def _direction(drawing: Variables, seed: int) -> Tensor:
    """Return a random move [K] of a pixel or 0.1 in colour; opacities stay."""
    move = torch.randn(len(drawing.start), generator=torch.Generator().manual_seed(seed))
    move[2 * drawing.point_count :] *= 0.1
    move[slice(*drawing.opacity_range)] = 0.0
    forms = 6 * 3
    ends = move[-4 * 3 - forms : -forms]
    ends *= 10.0
    return move * drawing.is_free


@pytest.mark.parametrize("free", [False, True])
def test_the_gradient_is_that_of_the_loss(scene: Scene, free: bool) -> None:
    drawing = _drawing(scene, free)
    gradient, errors = drawing.evaluate(drawing.start).gradient, []
    for seed in range(9):
        move = 0.02 * _direction(drawing, seed)
        rise = drawing.evaluate(drawing.start + move).loss - drawing.evaluate(drawing.start - move).loss
        errors.append(abs(float(gradient @ (2.0 * move)) - rise) / SLOPE)
    assert float(np.median(errors)) < 0.02


def test_the_matrix_is_that_of_the_pixels(scene: Scene) -> None:
    drawing = _drawing(scene)
    held, _ = drawing.held(drawing.evaluate(drawing.start))
    matrix = gauss_newton(drawing, drawing.start, held & False)
    errors, step = [], 0.02
    for seed in range(9):
        move = _direction(drawing, seed)
        ends = [_picture(drawing.scene(drawing.start + sign * step * move)).double() for sign in (1.0, -1.0)]
        exact = 2.0 * float(((ends[0] - ends[1]) / (2.0 * step)).square().mean())
        values = move.double().numpy()
        errors.append(float(values @ (matrix @ values)) / exact - 1.0)
    assert abs(float(np.median(errors))) < 0.06


def test_the_matrix_of_paints_is_that_of_the_pixels(scene: Scene) -> None:
    drawing = _drawing(scene)
    held, _ = drawing.held(drawing.evaluate(drawing.start))
    matrix = gauss_newton(drawing, drawing.start, held & False)
    first, count = 2 * drawing.point_count, len(drawing.start) - 6 * len(scene)
    for start, stop in ((first, count - 12), (count - 12, count)):
        move = torch.zeros_like(drawing.start)
        move[start:stop] = _direction(drawing, 1)[start:stop]
        ends = [_picture(drawing.scene(drawing.start + sign * 0.02 * move)).double() for sign in (1.0, -1.0)]
        exact = 2.0 * float(((ends[0] - ends[1]) / 0.04).square().mean())
        values = move.double().numpy()
        assert float(values @ (matrix @ values)) == pytest.approx(exact, rel=0.01)


def test_opaque_paths_and_kinds_stay_and_values_stay_in_bounds(scene: Scene) -> None:
    drawing = _drawing(scene)
    assert not drawing.is_free[slice(*drawing.opacity_range)].any()
    limited = drawing.limited(drawing.start + 5.0 * _direction(drawing, 1))
    wild = drawing.scene(limited)
    assert float(wild.color.min()) >= 0.0
    assert float(wild.color.max()) <= 1.0
    assert torch.equal(drawing.joints.is_smooth, drawing.joints.of(wild).is_smooth)
    torch.testing.assert_close(drawing.limited(limited), limited, atol=1e-4, rtol=0)
