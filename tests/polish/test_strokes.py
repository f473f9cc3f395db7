"""Strokes in a polish: they go back to where they were, and stay strokes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch
from strokes import stroked_scene

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.joints import with_lines
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.strokes import BEVEL, BUTT, MITER, ROUND, SQUARE, Strokes
from warpvec.geometry.structure import Structure
from warpvec.image.metrics import psnr
from warpvec.polish.folds import FoldGuard
from warpvec.polish.normal_matrix import NormalMatrix
from warpvec.polish.polish import polish
from warpvec.polish.variables import Variables
from warpvec.rendering.draw import draw_exactly
from warpvec.rendering.exact import ExactRenderer

HEIGHT, WIDTH = 90, 120


def three_strokes() -> Scene:
    """Return a hook with round caps, a closed curve, and a corner with square caps."""
    hook = [[(15, 20), (30, 5), (50, 10)], [(55, 30), (58, 45), (40, 50)], [(30, 40), (0, 0), (0, 0)]]
    ring = [[(70, 20), (85, 8), (105, 15)], [(105, 35), (102, 55), (75, 50)]]
    corner = [[(20, 75), (0, 0), (0, 0)], [(70, 70), (0, 0), (0, 0)], [(100, 82), (0, 0), (0, 0)]]
    is_line = torch.tensor([0, 0, 1, 0, 0, 1, 1, 1], dtype=torch.bool)
    structure = Structure.of_loops([[3], [2], [3]], is_line, torch.tensor([True, False, True]))
    segments = straightened(torch.tensor([*hook, *ring, *corner], dtype=torch.float32), structure)
    looks = [torch.tensor(kinds, dtype=torch.int32) for kinds in ((ROUND, BUTT, SQUARE), (ROUND, BEVEL, MITER))]
    strokes = Strokes(torch.tensor([6.0, 4.0, 7.0]), *looks, torch.full((3,), 4.0))
    color = torch.tensor([[0.1, 0.2, 0.6], [0.8, 0.1, 0.1], [0.0, 0.4, 0.1]])
    return Scene(segments, structure, color, torch.ones(3), torch.ones(3), torch.zeros(3).long(), strokes=strokes)


def test_moved_strokes_go_back() -> None:
    scene, config = with_lines(three_strokes()), FitConfig(device="cpu", threads=1)
    target = torch.from_numpy(draw_exactly(scene, HEIGHT, WIDTH, 1))
    noise = torch.randn(scene.segments.shape, generator=torch.Generator().manual_seed(0))
    assert scene.strokes is not None
    widths = scene.strokes.width + torch.tensor([1.0, -0.7, 0.5])
    moved = replace(
        scene,
        segments=straightened(scene.segments + noise, scene.structure),
        strokes=replace(scene.strokes, width=widths),
    )
    result = polish(Target(target, config, "cpu"), moved, config, iterations=150).scene
    assert psnr(draw_exactly(result, HEIGHT, WIDTH, 1), target.numpy()) > 45
    assert result.strokes is not None and (result.strokes.width - scene.strokes.width).abs().max() < 0.1
    assert result.structure.is_open is not None and result.structure.is_open.tolist() == [True, False, True]


def one_line(first: Sequence[float], second: Sequence[float]) -> Scene:
    """Return a stroke of one cubic from (10, 40) to (54, 40) with these handles."""
    rows = torch.tensor([[[10.0, 40.0], [*first], [*second]], [[54.0, 40.0]] * 3])
    structure = Structure.of_loops([[2]], torch.tensor([False, True]), torch.tensor([True]))
    line = three_strokes().select(torch.tensor([0]))
    return with_lines(replace(line, segments=straightened(rows, structure), structure=structure))


def test_no_handle_passes_the_end_of_its_line() -> None:
    scene, beyond = one_line((25.0, 40.0), (40.0, 40.5)), one_line((25.0, 40.0), (60.0, 40.5))
    config = FitConfig(device="cpu", threads=1)
    variables = Variables(scene, Target(torch.zeros(HEIGHT, WIDTH, 3), config, "cpu"), config)
    moved = Variables(beyond, variables.target, config).start
    assert FoldGuard(scene, variables, 2, is_on=True).folds(moved).tolist() == [True, False]
    assert not FoldGuard(beyond, variables, 2, is_on=True).folds(moved).any()


def test_a_stroke_may_become_steep() -> None:
    scene, config = one_line((30.0, 10.0), (34.0, 70.0)), FitConfig(device="cpu", threads=1)
    target = torch.from_numpy(draw_exactly(scene, HEIGHT, WIDTH, 1))
    result = polish(Target(target, config, "cpu"), one_line((26.0, 30.0), (40.0, 50.0)), config, iterations=150).scene
    assert psnr(draw_exactly(result, HEIGHT, WIDTH, 1), target.numpy()) > 45


def test_samples_tell_how_the_covered_area_changes() -> None:
    # The sum of the windings over the canvas is the area of a stroke that neither crosses nor leaves it. Corners of a
    # stroke, which the samples leave out, change it too.
    scene = three_strokes().select(torch.tensor([0, 1]))
    scene = scene._mapped(lambda tensor: tensor.double() if tensor.is_floating_point() else tensor)
    renderer = ExactRenderer(HEIGHT, WIDTH, dtype=torch.float64, threads=1)
    black = replace(scene, color=torch.zeros_like(scene.color), background=torch.ones_like(scene.background))
    adjoint = renderer.adjoint(black, -torch.ones(HEIGHT, WIDTH, 3, dtype=torch.float64) / 3.0)
    row, slopes = NormalMatrix(scene, (HEIGHT, WIDTH), None, 0.0, 11, True).entries
    owner = scene.structure.segment_path.long()[torch.from_numpy(row).long()]
    by_width = torch.zeros(2, dtype=torch.float64).index_add_(0, owner, torch.from_numpy(slopes[:, 8]).clone())
    torch.testing.assert_close(by_width.abs(), adjoint.width.abs(), rtol=0.03, atol=0.0)


def test_a_random_scene_is_not_made_worse() -> None:
    scene, config = stroked_scene(3, 6, HEIGHT, WIDTH, filled=2), FitConfig(device="cpu", threads=1)
    scene = with_lines(scene._mapped(lambda tensor: tensor.float() if tensor.is_floating_point() else tensor))
    target = Target(torch.rand(HEIGHT, WIDTH, 3, generator=torch.Generator().manual_seed(1)), config, "cpu")
    before = float(target.fit_step(scene, False).loss)
    result = polish(target, scene, config, iterations=20).scene
    assert float(target.fit_step(result, False).loss) < before
    assert result.strokes is not None and torch.equal(result.strokes.cap, scene.strokes.cap)
