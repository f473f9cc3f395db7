"""Forms in a fit: their own parameters are moved, with the right derivatives, so that each stays what it is."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene, over_white
from warpvec.polish import polish
from warpvec.polish.gauss_newton import gauss_newton
from warpvec.polish.variables import Variables
from warpvec.rendering.draw import draw_pixels
from warpvec.svg.read import read_svg

TEXT = """<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64" viewBox="0 0 64 64">
<g><path fill="#246" d="M2 3h50v11l-48 4z"/><circle fill="#d42" cx="17.3" cy="20.6" r="10.2"/>
<ellipse fill="#2a4" cx="45.2" cy="20.1" rx="13.3" ry="7.4" transform="rotate(25 45.2 20.1)"/>
<rect fill="#44c" x="6" y="40" width="20" height="15" transform="rotate(-12 16 47.5)"/>
<rect fill="#c84" x="35" y="35" width="24" height="22" rx="6" transform="rotate(8 47 46)"/></g></svg>"""

CONFIG = FitConfig(threads=1)


@pytest.fixture
def scene() -> Scene:
    """All forms, two of them above an outline, off the borders of pixels, where the loss has kinks."""
    return over_white(read_svg(TEXT).scene.scaled(1.01).moved(-0.31, 0.23))


def picture(scene: Scene) -> Tensor:
    return torch.from_numpy(draw_pixels(scene, 64, 64, **CONFIG.render_settings))


def drawing_of(scene: Scene) -> Variables:
    return Variables(scene, Target(picture(scene.moved(0.4, -0.3)) * 0.9, CONFIG, "cpu"), CONFIG)


def move_of_forms(drawing: Variables, seed: int) -> Tensor:
    """A random move [K] of the parameters of forms by a pixel, of angles by 0.1."""
    move = torch.zeros_like(drawing.start)
    forms = move[-6 * 5 :].view(5, 6)
    forms.copy_(torch.randn(5, 6, generator=torch.Generator().manual_seed(seed)))
    forms[:, 4] *= 0.1
    return move * drawing.is_free


def test_the_gradient_by_parameters_is_that_of_the_loss(scene: Scene) -> None:
    drawing = drawing_of(scene)
    gradient, errors = drawing.evaluate(drawing.start).gradient, []
    for seed in range(9):
        move = 0.02 * move_of_forms(drawing, seed)
        rise = drawing.evaluate(drawing.start + move).loss - drawing.evaluate(drawing.start - move).loss
        errors.append(abs(float(gradient @ (2.0 * move)) - rise) / 1e-4)
    assert float(np.median(errors)) < 0.02


def test_the_matrix_of_parameters_is_that_of_the_pixels(scene: Scene) -> None:
    drawing = drawing_of(scene)
    held, _ = drawing.held(drawing.evaluate(drawing.start))
    matrix, errors = gauss_newton(drawing, drawing.start, held & False), []
    for seed in range(9):
        move = move_of_forms(drawing, seed)
        ends = [picture(drawing.scene(drawing.start + sign * 0.02 * move)).double() for sign in (1.0, -1.0)]
        exact = 2.0 * float(((ends[0] - ends[1]) / 0.04).square().mean())
        errors.append(float(move.double().numpy() @ (matrix @ move.double().numpy())) / exact - 1.0)
    assert abs(float(np.median(errors))) < 0.06


def test_the_points_of_forms_are_not_free_and_a_step_is_bounded(scene: Scene) -> None:
    drawing = drawing_of(scene)
    assert scene.forms is not None
    points = drawing.is_free[: 2 * drawing.point_count].view(3, -1, 2)
    owner = scene.structure.segment_path.long()
    assert torch.equal(points.any(2).any(0), ~scene.forms.is_form[owner])
    step = drawing.with_bounded_forms(1e3 * move_of_forms(drawing, 0), 0.5)
    before, after = (drawing.scene(x).segments for x in (drawing.start, drawing.start + step))
    assert 0.1 < float((after - before).norm(dim=2).max()) < 0.6


@pytest.mark.parametrize("values", [10**6, 0])
def test_shaken_forms_come_back_and_stay_forms(scene: Scene, monkeypatch: pytest.MonkeyPatch, values: int) -> None:
    assert scene.forms is not None
    noise = torch.randn(5, 6, generator=torch.Generator().manual_seed(3)) * torch.tensor([1, 1, 1, 1, 0.05, 1])
    forms = scene.forms
    shaken = type(forms)(forms.kind, forms.parameters + 0.7 * noise * (forms.parameters != 0))
    target = Target(picture(scene), CONFIG, "cpu")
    found = polish.polish(target, scene.with_forms(shaken), CONFIG, iterations=150, values_exact_max=values).scene
    assert found.forms is not None and torch.equal(found.forms.kind, forms.kind)
    wrong = (found.forms.parameters - forms.parameters)[1:].abs().max()
    assert float(wrong) < (0.02 if values else 0.2)
    torch.testing.assert_close(found.segments, found.forms.placed(found.segments, found.structure))
