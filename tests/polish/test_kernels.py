"""The kernels of a fit, against what the geometry and the pixels say in many steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.crossings import crossings_of_rows
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.joints import with_lines
from warpvec.geometry.overshoots import overshoots
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.polish.fold_look import FoldLook
from warpvec.polish.gauss_newton import gauss_newton
from warpvec.polish.variables import Variables
from warpvec.rendering.draw import draw_pixels
from warpvec.svg.read import read_svg

CONFIG = FitConfig(threads=1)

TEXT = """<svg xmlns="http://www.w3.org/2000/svg" width="48" height="40">
<path fill="#7b3" d="M8 8 H28 C36 8 40 14 40 22 V30 C30 26 24 40 16 36 C10 33 8 20 8 8z M14 14 V20 H20z"/>
<circle fill="#25c" cx="30" cy="26" r="9"/>
<path fill="none" stroke="#e52" stroke-width="3" stroke-linecap="round" d="M6 34 C14 30 20 38 28 34 L42 36"/></svg>"""


@pytest.fixture
def scene() -> Scene:
    """Lines, smooth nodes, corners, a hole, a circle as an outline, and a stroke."""
    scene = read_svg(TEXT).scene.scaled(1.04).moved(0.31, 0.43)
    return with_lines(replace(scene.outlined(), background=torch.zeros(3), transparent=True))


def _variables(scene: Scene) -> Variables:
    picture = torch.from_numpy(draw_pixels(scene.moved(0.4, -0.3), 40, 48, **CONFIG.render_settings))
    return Variables(scene, Target(picture, CONFIG, "cpu"), CONFIG)


def _shaken(scene: Scene, size: float, seed: int) -> Tensor:
    return scene.segments + size * torch.randn(scene.segments.shape, generator=torch.Generator().manual_seed(seed))


def test_curves_and_their_slopes_are_those_of_the_joints(scene: Scene) -> None:
    drawing = _variables(scene)
    x = drawing.start + 0.3 * torch.randn(len(drawing.start), generator=torch.Generator().manual_seed(3))
    count = 2 * drawing.point_count

    def placed(values: Tensor) -> Tensor:
        return drawing.joints.segments(*values.view(3, -1, 2).unbind(0))

    torch.testing.assert_close(drawing.shown(x).segments, placed(x[:count]), rtol=0.0, atol=1e-4)
    x = drawing.limited(drawing.start)[:count].double()
    want = torch.autograd.functional.jacobian(placed, x).reshape(-1, 6, count)
    assert bool(drawing.joints.is_smooth.any()) and bool(drawing.joints.is_line.any())
    rows = drawing.row_slopes(drawing.limited(drawing.start))
    for row, number in enumerate(rows.count.numpy()[: len(want)]):
        found = np.zeros((6, len(drawing.start)))
        np.add.at(found.T, rows.value.numpy()[row, :number], rows.slopes.numpy()[row, :number, :6])
        np.testing.assert_allclose(found[:, :count], want[row].numpy(), atol=1e-5)


def test_flat_paints_have_the_matrix_that_paints_have(scene: Scene) -> None:
    """Scenes with gradients, none of which any path uses, take their paints the other way."""
    zero = torch.zeros(len(scene), dtype=torch.int32)
    others = replace(scene, gradients=Gradients(zero, torch.zeros(len(scene), 4), scene.color.clone()))
    found = []
    for each in (scene, others):
        drawing = _variables(each)
        held, _ = drawing.held(drawing.evaluate(drawing.start))
        matrix = gauss_newton(drawing, drawing.start, held).toarray()
        shown = 2 * drawing.point_count + 3 * len(scene)
        found.append(matrix[:shown, :shown])
    np.testing.assert_allclose(*found, rtol=1e-6, atol=1e-9)


def test_a_small_room_for_entries_and_blocks_grows(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    from warpvec.polish import machine

    drawing = _variables(scene)
    held, _ = drawing.held(drawing.evaluate(drawing.start))
    want = gauss_newton(drawing, drawing.start, held)
    fresh = machine.Machine("cpu")
    fresh.entry_room, fresh.block_room = 4, 2
    monkeypatch.setattr(machine, "_machine", lambda device: fresh)
    assert (gauss_newton(drawing, drawing.start, held) != want).nnz == 0
    rooms, entries = (fresh.entry_room, fresh.block_room), len(drawing.scene(drawing.start).segments)
    assert 4 < rooms[0] < 4 * 40 * 48 and 2 < rooms[1] < entries**2  # not far beyond what they need


def test_a_look_for_folds_sees_what_the_geometry_sees(scene: Scene) -> None:
    look, counted = FoldLook(scene, 1), torch.tensor([True, True, False])
    assert FoldLook.is_possible(scene) and scene.strokes is not None
    crossed = overshot = 0
    for seed in range(12):
        shaken = replace(scene, segments=_shaken(scene, 0.5 * seed, seed))
        written = look.written(shaken.segments)
        want = crossings_of_rows(round_nodes(shaken, 1), counted)
        assert torch.equal(look.crossings(written, counted), want)
        turned = look.overshoots(written, scene.strokes.width)
        assert torch.equal(turned, overshoots(round_nodes(shaken, 1)))
        crossed, overshot = crossed + int(want.sum()), overshot + int(turned.sum())
    assert crossed > 10 and overshot > 0  # the shaken drawings cross themselves and turn back


@pytest.mark.parametrize("background", [None, (0.9, 0.8, 0.7)])
def test_tiles_of_one_colour_count_as_their_pixels_do(scene: Scene, background: tuple[float, ...] | None) -> None:
    wide = scene.scaled(3.0)
    if background is not None:
        wide = replace(wide, background=torch.tensor(background), transparent=False)
    picture = torch.from_numpy(draw_pixels(wide.moved(0.4, -0.3), 124, 150, **CONFIG.render_settings)) * 0.9
    target = Target(picture, CONFIG, "cpu")
    found = target.fit_step(wide, False)
    error = target.squared_error(wide)
    measured = target._renderer._compositing._measured
    assert measured
    for _, moments in measured.values():  # which the steps so far have used
        moments.zero_()
    assert target.fit_step(wide, False).loss < 0.9 * found.loss
    measured.clear()
    want = target.fit_step(wide, False)
    for name, value in vars(want).items():
        if value is not None:
            torch.testing.assert_close(getattr(found, name), value, rtol=1e-4, atol=1e-8)
    torch.testing.assert_close(error.sum().double() * target.error_scale, want.loss.double(), rtol=1e-4, atol=0.0)


def test_slopes_after_a_step_are_those_of_the_scene_asked_for(scene: Scene) -> None:
    """A renderer keeps what its last step has covered, for the matrix of the same scene."""
    target, strokes = _variables(scene).target, scene.strokes
    assert strokes is not None
    others = [
        replace(scene, color=scene.color.flip(0)),
        replace(scene, strokes=replace(strokes, cap=torch.zeros_like(strokes.cap))),
        replace(scene, segments=scene.segments + 0.5),
    ]
    for other in [scene, *others]:
        target.fit_step(scene, False)
        got = _slopes(target, other)
        fresh = _variables(scene).target
        for one, want in zip(got, _slopes(fresh, other), strict=True):
            assert np.array_equal(one, want)


def _slopes(target: Target, scene: Scene) -> list[NDArray[np.float32]]:
    return [part.slopes[part.is_partial].copy() for part in target.pixel_slopes(scene)]
