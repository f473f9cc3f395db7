"""The end of the fit of a photo: soft paths where the picture is soft, sharp ones elsewhere, and what stays."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.image.metrics import psnr
from warpvec.polish.finishing import finish, planned_iterations
from warpvec.rendering.draw import draw_pixels
from warpvec.watch.interrupt import CtrlC
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1, iterations=700)
SIGMA = 2.8  # one of those that a drawing has


def disks(move: float = 0.0) -> Scene:
    """Return two disks, moved to the right."""
    center = torch.tensor([[16.0, 16.0], [44.0, 30.0]]) + torch.tensor([move, 0.0])
    color = torch.tensor([[0.9, 0.8, 0.2], [0.2, 0.5, 0.9]])
    points = circle_points(center, torch.tensor([9.0, 10.0]), 4)
    return Scene.uniform(points, color, torch.ones(2), torch.tensor([0.1, 0.1, 0.2]), torch.arange(2))


def finished(
    picture: Scene, soft_max: int | None, step: tuple[float, float] | None = None,
    *, begun: Scene | None = None, watch: Watch | None = None,
) -> Scene:  # fmt: skip
    target = Target(torch.from_numpy(draw_pixels(picture, 48, 64, threads=1)), CONFIG, "cpu")
    part = (watch or Watch()).part()
    return finish(disks(0.3) if begun is None else begun, target, CONFIG, part, soft_max=soft_max, step=step)


def at_multiples(scene: Scene, step: tuple[float, float]) -> Scene:
    across_down = torch.tensor(step)
    return replace(scene, segments=(scene.segments / across_down).round() * across_down)


def shown_psnr(scene: Scene, other: Scene) -> float:
    return psnr(*(draw_pixels(each, 48, 64, threads=1) for each in (scene, other)))


def test_the_blurred_disk_becomes_soft() -> None:
    found = finished(replace(disks(), softness=Softness(torch.tensor([0.0, SIGMA]))), 1)
    assert found.softness is not None and found.softness.is_soft.tolist() == [False, True]
    assert float(found.softness.sigma[1]) == pytest.approx(SIGMA)


def test_sharp_disks_stay_sharp_and_move_to_their_places() -> None:
    found = finished(disks(), 2)
    assert found.softness is None
    assert shown_psnr(found, disks()) > 50


def crowd(move: float) -> Scene:
    """Return forty translucent disks that hide parts of each other, moved to the right and down."""
    generator = torch.Generator().manual_seed(1)
    center = torch.rand(40, 2, generator=generator) * torch.tensor([64.0, 48.0]) + move
    points = circle_points(center, 4 + 8 * torch.rand(40, generator=generator), 2)
    color = torch.rand(40, 3, generator=generator)
    return Scene.uniform(points, color, torch.full((40,), 0.7), torch.full((3,), 0.5), torch.arange(40))


def test_points_of_coarse_files_are_rounded_while_the_others_follow() -> None:
    picture, step = crowd(0.0), (1.0, 0.5)
    free, found = (finished(picture, 0, steps, begun=crowd(0.2)) for steps in (None, step))
    assert torch.equal(found.segments, at_multiples(found, step).segments)
    assert shown_psnr(found, picture) > shown_psnr(at_multiples(free, step), picture) + 1.5


class Stopped(CtrlC):
    def has_signal(self) -> bool:
        return True


def test_a_stopped_end_leaves_the_drawing_as_it_is() -> None:
    found = finished(crowd(0.0), None, (0.5, 0.5), begun=crowd(0.2), watch=Watch(listener=Stopped()))
    assert torch.equal(found.segments, crowd(0.2).segments)


@pytest.mark.parametrize("rule", [{"lod": True}, {"colors": 3}, {"renderer": "splat"}, {"iterations": 100}])
def test_fits_with_other_rules_have_no_such_end(rule: dict[str, object]) -> None:
    assert planned_iterations(CONFIG) > 0 == planned_iterations(FitConfig(**rule))
