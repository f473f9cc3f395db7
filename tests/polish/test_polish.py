"""The fit that keeps the structure of a drawing: how far it gets, and what it never does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.joints import Joints, with_lines
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.polish import folds
from warpvec.polish import polish as polishing
from warpvec.polish.levenberg_marquardt import LevenbergMarquardt
from warpvec.polish.polish import polish
from warpvec.polish.variables import Evaluation
from warpvec.rendering.draw import draw_pixels
from warpvec.svg.read import read_svg
from warpvec.watch.watch import FitResult

CONFIG = FitConfig(threads=1)

RING = "M10 32 C10 20 20 10 32 10 C44 10 54 20 54 32 C54 44 44 54 32 54 C20 54 10 44 10 32z M26 26 V38 H38 V26z"


def _scene(data: str, color: str = "#26c") -> Scene:
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64"><path fill="{color}" d="{data}"/></svg>'
    return with_lines(replace(read_svg(text).scene, background=torch.ones(3), transparent=False))


def _picture(scene: Scene) -> Tensor:
    return torch.from_numpy(draw_pixels(scene, 64, 64, **CONFIG.render_settings))


def _shaken(scene: Scene, size: float) -> Scene:
    joints = Joints.of(scene)
    anchor, *handles = joints.values(scene)
    moved = anchor + size * torch.randn(anchor.shape, generator=torch.Generator().manual_seed(0))
    return replace(scene, segments=joints.segments(moved, *handles), color=scene.color * 0.9)


def _polished(picture: Tensor, start: Scene, iterations: int, threads: int = 1) -> FitResult:
    config = FitConfig(threads=threads)
    return polish(Target(picture, config, "cpu"), start, config, iterations=iterations)


def _psnr(result: FitResult, picture: Tensor) -> float:
    return -10.0 * math.log10(float((_picture(result.scene) - picture).square().mean()))


@pytest.mark.parametrize("values", [polishing.VALUES_EXACT_MAX, 0], ids=["exact", "by gradients"])
def test_a_shaken_drawing_comes_back_and_never_gets_worse(monkeypatch: pytest.MonkeyPatch, values: int) -> None:
    monkeypatch.setattr(polishing, "VALUES_EXACT_MAX", values)
    right = _scene(RING)
    picture, start = _picture(right), _shaken(right, 1.0)
    found = [_psnr(_polished(picture, start, count), picture) for count in (0, 1, 8, 60)]
    assert found == sorted(found)
    assert found[-1] > (50.0 if values else 45.0)
    result = _polished(picture, start, 60)
    assert result.iterations <= 60
    before, after = Joints.of(start), Joints.of(result.scene)
    assert torch.equal(before.is_smooth, after.is_smooth)
    assert torch.equal(before.is_line, after.is_line)


@pytest.mark.parametrize("values", [polishing.VALUES_EXACT_MAX, 0], ids=["exact", "by gradients"])
def test_what_folds_goes_no_farther(monkeypatch: pytest.MonkeyPatch, values: int) -> None:
    """Here nodes right of 54 px stand for a fold, and the picture asks for one at 56 px."""
    monkeypatch.setattr(polishing, "VALUES_EXACT_MAX", values)
    monkeypatch.setattr(folds, "crossings_of_rows", lambda scene, _: (scene.segments[:, 0, 0] > 54.0).long().clone())
    monkeypatch.setattr(folds.FoldLook, "is_possible", lambda scene: False)
    picture, start = _picture(_scene("M8 8 H56 V50 L10 56z")), _scene("M10 12 H51 V48 L12 52z")
    kept = _polished(picture, start, 60)
    monkeypatch.setattr(folds.FoldGuard, "folds", lambda guard, _: torch.zeros(4, dtype=torch.bool))
    free = _polished(picture, start, 60)
    assert float(free.scene.segments[:, 0, 0].max()) > 55.5
    assert float(kept.scene.segments[:, 0, 0].max()) <= 54.01
    assert _psnr(kept, picture) > _psnr(_polished(picture, start, 0), picture) + 2.0


def test_what_is_folded_before_a_step_does_not_hold_it_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here the first segment stands for a fold that no step can undo."""
    looks = []

    def see(_: folds.FoldGuard, x: Tensor) -> Tensor:
        looks.append(x)
        return torch.arange(4) == 0

    right = _scene("M8 8 H48 V50 L10 56z")
    picture, start = _picture(right), _scene("M9 9 H46 V46 L12 52z")
    monkeypatch.setattr(folds.FoldGuard, "folds", see)
    monkeypatch.setattr(folds.FoldGuard, "unfolded", lambda _, x: (x, None))
    found = _polished(picture, start, 12)
    assert len(looks) <= 4 * found.iterations
    assert torch.equal(found.scene.segments[0, 0], start.segments[0, 0])
    assert _psnr(found, picture) > _psnr(_polished(picture, start, 0), picture)


def test_a_fit_ends_where_nothing_is_left_to_gain() -> None:
    """The steps of one that starts at its end gain hardly anything, or fail."""
    picture = _picture(_scene(RING)).mul(255.0).round() / 255.0
    found = _polished(picture, _scene("M12 32 C12 20 20 12 32 12 C44 12 54 20 54 32 C54 44 44 54 32 54 C20 54 12 44 "
                                      "12 32z"), 60)  # fmt: skip
    assert _polished(picture, found.scene, 60).iterations <= 4


def test_steps_start_anew_from_the_best_while_that_pays(monkeypatch: pytest.MonkeyPatch) -> None:
    starts: list[float] = []

    class Impatient(LevenbergMarquardt):
        def steps(self, count: int, gain_min: float, unseen: float = 0.0) -> Iterator[Evaluation]:
            starts.append(self._here.loss)
            return super().steps(min(count, 3), gain_min, unseen)

    monkeypatch.setattr(polishing, "LevenbergMarquardt", Impatient)
    scene = _scene(RING)
    result = _polished(_picture(scene), _shaken(scene, 1.0), 80)
    assert len(starts) > 2 and starts == sorted(starts, reverse=True)
    assert _psnr(result, _picture(scene)) > 45
    starts.clear()
    _polished(_picture(scene), _shaken(scene, 1.0), 40)
    assert len(starts) == 1  # too few are left


def test_a_fit_ends_sooner_where_viewers_add_more_than_it_gains() -> None:
    picture, start = _picture(_scene(RING)), _shaken(_scene(RING), 1.0)
    target = Target(picture, CONFIG, "cpu")
    whole, short = (polish(target, start, CONFIG, iterations=60, unseen=unseen) for unseen in (0.0, 1e-4))
    assert short.iterations < whole.iterations
    assert _psnr(short, picture) > 40.0


def test_the_bits_do_not_depend_on_the_threads() -> None:
    picture, start = _picture(_scene(RING)), _shaken(_scene(RING), 1.0)
    one, two = (_polished(picture, start, 12, threads=n).scene for n in (1, 2))
    assert torch.equal(one.segments, two.segments)
    assert torch.equal(one.color, two.color)


def test_handles_of_smooth_nodes_do_not_vanish_where_the_picture_has_a_corner() -> None:
    start = _scene("M12 32 C12 22 22 12 32 12 C42 12 52 22 52 32 C52 42 42 52 32 52 C22 52 12 42 12 32z")
    result = _polished(_picture(_scene("M12 12 H52 V52 H12z")), start, 60)
    file = round_nodes(result.scene, 2)
    assert torch.equal(Joints.of(file).is_smooth, Joints.of(start).is_smooth)
    assert Joints.of(start).is_smooth.all()
