"""The tension of outlines: its derivative, and the spikes that it takes away."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.joints import with_lines
from warpvec.geometry.scene import Scene
from warpvec.polish.gauss_newton import gauss_newton
from warpvec.polish.polish import polish
from warpvec.polish.tension import tension_of
from warpvec.polish.variables import Variables
from warpvec.rendering.draw import draw_pixels
from warpvec.svg.read import read_svg

CONFIG = FitConfig(threads=1)

STROKE = '<path fill="none" stroke="#000" stroke-width="2" d="M3 4C6 1 9 7 12 5L14 12"/>'


def _scene(elements: str) -> Scene:
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="24" height="24">{elements}</svg>'
    return with_lines(replace(read_svg(text).scene, background=torch.ones(3), transparent=False))


def _target(scene: Scene) -> Target:
    picture = draw_pixels(scene, 24, 24, **CONFIG.render_settings)
    return Target((255.0 * torch.from_numpy(picture)).round() / 255.0, CONFIG, "cpu")


def _tension(scene: Scene) -> torch.Tensor:
    return torch.full((len(scene.segments),), 0.01 / (3 * 24 * 24), dtype=torch.float64)


def test_the_adjoint_is_the_derivative_and_the_end_of_an_open_line_counts_nothing() -> None:
    scene = _scene(STROKE + '<path d="M4 15C5 13 9 12 12 14S21 17 20 20L6 22Z"/>')
    scene = replace(scene, segments=scene.segments.double())
    weight = 0.1 + torch.rand(len(scene.segments), generator=torch.Generator().manual_seed(1)).double()
    move = torch.randn(scene.segments.shape, generator=torch.Generator().manual_seed(2)).double()
    _, adjoint = tension_of(scene, weight)
    ahead, behind = (tension_of(replace(scene, segments=scene.segments + s * move), weight)[0] for s in (1e-5, -1e-5))
    assert float((adjoint * move).sum()) == pytest.approx((ahead - behind) / 2e-5, rel=1e-6)
    only_end = scene.structure.end_rows.double()
    assert tension_of(scene, only_end)[0] == 0.0 < float(only_end.sum())


def test_its_matrix_bounds_its_second_derivative() -> None:
    scene = _scene('<path d="M4 5C5 3 9 2 12 4S21 7 20 20L6 22Z"/>')
    target = _target(scene)
    pulled, free = (Variables(scene, target, CONFIG, tension=each) for each in (_tension(scene), None))
    move = torch.randn(len(free.start), generator=torch.Generator().manual_seed(3)) * free.is_free
    held = torch.zeros((len(scene.segments), 2), dtype=torch.bool)
    matrices = [gauss_newton(each, each.start, held) for each in (pulled, free)]
    bound = float(move.double().numpy() @ ((matrices[0] - matrices[1]) @ move.double().numpy()))
    step = 1e-2
    here, ahead, behind = (
        tension_of(pulled.scene(pulled.start + s * step * move), _tension(scene))[0] for s in (0.0, 1.0, -1.0)
    )
    assert 0.0 < (ahead + behind - 2.0 * here) / step**2 < 1.05 * bound


def test_a_spike_that_pixels_hardly_show_goes() -> None:
    right = _scene('<path d="M5 5H19V19H5Z"/>')
    spiked = _scene('<path d="M5 5H19V12L22 12.04L19 12.08V19H5Z"/>')
    target = _target(right)
    reach = []
    for tension in (None, _tension(spiked)):
        found = polish(target, spiked, CONFIG, iterations=40, tension=tension).scene
        reach.append(float(found.segments[:, 0, 0].max()))
    assert reach[1] < 19.5 < 20.0 < reach[0]
