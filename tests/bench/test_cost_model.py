"""Test the counts of the cost model."""

from __future__ import annotations

import bench_step
import cost_model
import torch

from warpvec.geometry.scene import Scene
from warpvec.rendering.exact import ExactRenderer


def test_work_of_a_scene_is_counted() -> None:
    corners = torch.tensor([[4, 4], [22, 4], [22, 22], [4, 22]])
    square = torch.cat(
        [
            corner + (after - corner) // 3 * torch.arange(3)[:, None]
            for corner, after in zip(corners, corners.roll(-1, 0), strict=True)
        ]
    )
    renderer = ExactRenderer(40, 40)
    with torch.no_grad():
        color, opacity, background = torch.ones(1, 3), torch.ones(1), torch.zeros(3)
        scene = Scene.uniform(square[None].float(), color, opacity, background, torch.zeros(1).long())
        renderer.render(scene)
    work = cost_model.work_of(
        renderer._flattening, renderer._binning, renderer._binning.tile_first_hit.numpy()[:9], scene
    )
    # A straight cubic is one chord. Each of the four sides crosses 18 pixels after the one it starts in.
    assert work == cost_model.Work(1, 12, 4, 4 * 18 + 4, 4, 4, 4)
    assert set(cost_model.ideal_seconds(work)) <= {stage.name for stage in bench_step.STAGES["exact"]}
