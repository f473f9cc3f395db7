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
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1, iterations=700)
SIGMA = 2.8  # one of those that a drawing has


def disks(move: float = 0.0) -> Scene:
    """Return two disks, moved to the right."""
    center = torch.tensor([[16.0, 16.0], [44.0, 30.0]]) + torch.tensor([move, 0.0])
    color = torch.tensor([[0.9, 0.8, 0.2], [0.2, 0.5, 0.9]])
    points = circle_points(center, torch.tensor([9.0, 10.0]), 4)
    return Scene.uniform(points, color, torch.ones(2), torch.tensor([0.1, 0.1, 0.2]), torch.arange(2))


def finished(picture: Scene, soft_max: int | None, *, keeps_points: bool = False) -> Scene:
    target = Target(torch.from_numpy(draw_pixels(picture, 48, 64, threads=1)), CONFIG, "cpu")
    part = Watch().part()
    return finish(disks(0.3), target, CONFIG, part, soft_max=soft_max, keeps_points=keeps_points)


def test_the_blurred_disk_becomes_soft() -> None:
    found = finished(replace(disks(), softness=Softness(torch.tensor([0.0, SIGMA]))), 1)
    assert found.softness is not None and found.softness.is_soft.tolist() == [False, True]
    assert float(found.softness.sigma[1]) == pytest.approx(SIGMA)


def test_sharp_disks_stay_sharp_and_move_to_their_places() -> None:
    found = finished(disks(), 2)
    assert found.softness is None
    assert psnr(*(draw_pixels(scene, 48, 64, threads=1) for scene in (found, disks()))) > 50


def test_points_stay_where_a_file_rounds_them() -> None:
    picture = replace(disks(), color=disks().color.flip(0), softness=Softness(torch.tensor([SIGMA, 0.0])))
    found = finished(picture, 1, keeps_points=True)
    assert torch.equal(found.segments, disks(0.3).segments)
    assert found.softness is not None and (found.color - picture.color).abs().max() < 0.05


@pytest.mark.parametrize("rule", [{"lod": True}, {"colors": 3}, {"renderer": "splat"}, {"iterations": 100}])
def test_fits_with_other_rules_have_no_such_end(rule: dict[str, object]) -> None:
    assert planned_iterations(CONFIG) > 0 == planned_iterations(FitConfig(**rule))
