"""The values of gradients of several stops: gradient, Gauss-Newton matrix, bounds, and a fit that finds them again."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX
from warpvec.polish import paint_slopes
from warpvec.polish.gauss_newton import gauss_newton
from warpvec.polish.polish import polish
from warpvec.polish.stop_variables import bounded_offset_step
from warpvec.polish.variables import Variables
from warpvec.rendering.draw import draw_pixels
from warpvec.svg.read import read_svg

TEXT = """<svg xmlns="http://www.w3.org/2000/svg" width="48" height="48" viewBox="0 0 48 48"><defs>
<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="5" y1="8" x2="40" y2="31"><stop stop-color="#d84"/>
<stop offset=".3" stop-color="#26c"/><stop offset=".6" stop-color="#ed7"/><stop offset="1" stop-color="#384"/>
</linearGradient>
<radialGradient id="b" gradientUnits="userSpaceOnUse" cx="0" cy="0" r="1" gradientTransform="matrix(12 5 -3 7.2 30 28)">
<stop offset=".2" stop-color="#ed5"/><stop offset=".55" stop-color="#d13"/><stop offset="1" stop-color="#253"/>
</radialGradient>
<radialGradient id="c" gradientUnits="userSpaceOnUse" cx="12" cy="38" r="9"><stop stop-color="#dcb" {first}/>
<stop offset=".4" stop-color="#36a" {second}/><stop offset="1" stop-color="#412"/></radialGradient></defs>
<path fill="url(#a)" d="M4 4h40v40h-40z"/><path fill="url(#b)" d="M18 18h26v22h-26z"/>
<path fill="url(#c)" d="M2 30h20v16h-20z"/></svg>"""

CONFIG = FitConfig(threads=1)


def scene_of(first: float = 1.0, second: float = 1.0) -> Scene:
    """Return three kinds of gradients of three or four stops, two of them with these opacities."""
    places = {"first": f'stop-opacity="{first}"', "second": f'stop-opacity="{second}"'}
    scene = read_svg(TEXT.format(**places)).scene
    assert scene.gradients is not None and scene.gradients.kind.tolist() == [1, 3, 2]
    return replace(scene, background=torch.tensor([0.9, 0.8, 0.7]), transparent=False)


def _picture(scene: Scene) -> Tensor:
    return torch.from_numpy(draw_pixels(scene, 48, 48, **CONFIG.render_settings))


def _drawing(scene: Scene) -> Variables:
    return Variables(scene, Target(_picture(scene.moved(0.4, -0.3)) * 0.9, CONFIG, "cpu"), CONFIG)


def _move(drawing: Variables, part: int, seed: int) -> Tensor:
    """Return a random move of the values of one part [K], of a size that shows."""
    move = torch.zeros_like(drawing.start)
    values = drawing._of(move)[part]
    values.copy_(torch.randn(values.shape, generator=torch.Generator().manual_seed(seed)))
    return move * drawing.is_free * {7: 1.0, 9: 0.1, 11: 1.0}.get(part, 0.1)


PARTS = {3: "color", 6: "end color", 7: "geometry", 8: "inner color", 9: "offset", 10: "stop opacity", 11: "breadth"}


@pytest.mark.parametrize("part", PARTS, ids=PARTS.values())
def test_the_gradient_is_that_of_the_loss(part: int) -> None:
    drawing = _drawing(scene_of(0.5, 0.7))
    gradient, move = drawing.evaluate(drawing.start).gradient, 0.02 * _move(drawing, part, 1)
    rise = drawing.evaluate(drawing.start + move).loss - drawing.evaluate(drawing.start - move).loss
    assert bool(move.any())
    assert float(gradient @ (2.0 * move)) == pytest.approx(rise, rel=0.02)


@pytest.mark.parametrize("part", [part for part in PARTS if part != 10], ids=[v for k, v in PARTS.items() if k != 10])
def test_the_matrix_is_that_of_the_pixels(part: int) -> None:
    drawing = _drawing(scene_of())
    held, _ = drawing.held(drawing.evaluate(drawing.start))
    matrix, move = gauss_newton(drawing, drawing.start, held & False), _move(drawing, part, 2)
    ends = [_picture(drawing.scene(drawing.start + sign * 0.02 * move)).double() for sign in (1.0, -1.0)]
    exact = 2.0 * float(((ends[0] - ends[1]) / 0.04).square().mean())
    values = move.double().numpy()
    assert float(values @ (matrix @ values)) == pytest.approx(exact, rel=0.03)


def test_a_lattice_of_pixels_stands_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    drawing = _drawing(scene_of())
    held, _ = drawing.held(drawing.evaluate(drawing.start))
    move = _move(drawing, 8, 2).double().numpy()
    found = []
    for least in (10**9, 100):
        monkeypatch.setattr(paint_slopes, "LATTICE_PIXELS_MIN", least)
        found.append(float(move @ (gauss_newton(drawing, drawing.start, held & False) @ move)))
    assert found[0] != found[1] == pytest.approx(found[0], rel=0.15)


def test_ends_that_the_geometry_has_and_opaque_stops_stay() -> None:
    drawing = _drawing(scene_of(0.5))
    *_, inner, offset, opacity, breadth = drawing._of(drawing.is_free)
    assert offset.int().tolist() == [[0, 1, 1, *[0] * 5], [1, 1, *[0] * 6], [0, 1, *[0] * 6]]
    assert inner.any(2).int().sum(1).tolist() == [2, 1, 1] and breadth.tolist() == [False, True, False]
    assert opacity.nonzero().tolist() == [[2, 0]]


def test_values_come_back_into_their_bounds() -> None:
    drawing = _drawing(scene_of(0.5))
    wild = drawing.start + 20.0 * sum(_move(drawing, part, 3) for part in (8, 9, 10, 11))
    stops = drawing.scene(drawing.limited(wild)).gradients.stops
    used = [row[:count] for row, count in zip(stops.offset, stops.count.tolist(), strict=True)]
    assert all(bool((row.diff() >= 0.0).all()) and 0.0 <= float(row.min()) <= float(row.max()) <= 1.0 for row in used)
    assert float(stops.inner_color.min()) >= 0.0 and float(stops.inner_color.max()) <= 1.0
    assert float(stops.opacity.min()) >= 0.0 and float(stops.breadth[1]) > 0.0


@pytest.mark.parametrize("exactly", [True, False], ids=["gauss-newton", "descent"])
def test_moved_stops_are_found_again(exactly: bool) -> None:
    scene = scene_of(0.5, 0.7)
    paints = scene.gradients.map(Tensor.clone)
    generator = torch.Generator().manual_seed(4)
    paints.geometry.add_(torch.randn(3, 4, generator=generator))
    paints.stops.offset[:, 1].add_(0.05)
    paints.stops.inner_color.add_(0.1 * torch.randn(3, 6, 3, generator=generator)).clamp_(0.0, 1.0)
    paints.stops.opacity[2, :2] = torch.tensor([0.6, 0.6])
    start, picture = replace(scene, gradients=paints), _picture(scene)
    most = {} if exactly else {"values_exact_max": 0}
    found = polish(Target(picture, CONFIG, "cpu"), start, CONFIG, iterations=60 if exactly else 300, **most).scene
    errors = [float((_picture(each) - picture).square().mean()) for each in (start, found)]
    assert errors[1] < (1e-3 if exactly else 1e-2) * errors[0]
    assert torch.equal(found.gradients.kind, scene.gradients.kind)
    assert torch.equal(found.gradients.stops.count, scene.gradients.stops.count)


def test_a_shade_of_one_colour_that_fades_is_found_again() -> None:
    """Its place changes no colour, and so nothing that the matrix knows of."""
    scene = scene_of(0.9, 0.0)
    paints, color = scene.gradients.map(Tensor.clone), scene.color.clone()
    color[2], paints.end_color[2], paints.stops.inner_color[2] = 0.2, 0.2, 0.2
    paints.stops.opacity[2, 2] = 0.0
    scene = replace(scene, color=color, gradients=paints)
    moved = paints.map(Tensor.clone)
    moved.geometry[2] += torch.tensor([1.5, -1.0, 1.0, 0.0])
    picture, start = _picture(scene), replace(scene, gradients=moved)
    found = polish(Target(picture, CONFIG, "cpu"), start, CONFIG, iterations=60).scene
    errors = [float((_picture(each) - picture).square().mean()) for each in (start, found)]
    assert errors[1] < 1e-2 * errors[0]


def _padded(*values: float, rest: float) -> torch.Tensor:
    return torch.tensor([[*values, *[rest] * (STOPS_MAX - len(values))]])


@pytest.mark.parametrize(
    ("offset", "step", "expected"),
    [
        ((0.0, 0.6, 1.0), (0.0, 0.1, 0.0), (0.0, 0.7, 1.0)),  # no gap loses a half: as it is
        ((0.0, 0.6, 1.0), (0.0, 0.8, 0.0), (0.0, 0.8, 1.0)),
        ((0.2, 0.6, 1.0), (-0.8, 0.4, 0.0), (0.1, 0.65, 1.0)),  # the gap before the first stop, for both
        ((0.0, 0.5, 0.5, 1.0), (0.0, 0.2, 0.1, 0.0), (0.0, 0.7, 0.6, 1.0)),  # a jump holds nothing
    ],
)
def test_a_step_takes_at_most_half_of_a_gap(
    offset: tuple[float, ...], step: tuple[float, ...], expected: tuple[float, ...]
) -> None:
    before, count = _padded(*offset, rest=1.0), torch.tensor([len(offset)])
    moved = before + bounded_offset_step(before, _padded(*step, rest=0.0), count)
    assert moved[0, : len(expected)].tolist() == pytest.approx(expected)
