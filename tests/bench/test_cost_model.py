"""The cost model of bench_step: what it counts."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import pytest
import torch

from warpvec.rendering.exact import ExactRenderer

sys.path.append(str(Path(__file__).parents[2] / "bench"))
cost_model = import_module("cost_model")


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
        points = square[None].float()
        renderer.render(points, torch.ones(1, 3), torch.ones(1), torch.zeros(3))
    work = cost_model.work_of(
        renderer._flattening, renderer._binning, renderer._binning.tile_first_hit.numpy()[:9], points
    )
    # Straight cubics are one chord each; 18 pixels along each of four sides, and the one where each starts.
    assert work == cost_model.Work(1, 12, 4, 4 * 18 + 4, 4, 4, 4)
    ideal = cost_model.ideal_seconds(work)
    assert set(ideal) >= {"flattening", "binning", "coverage", "compositing_adjoint"}
    assert ideal["flattening"] == pytest.approx(4 * cost_model.VERTEX_NS * 1e-9)
    double = cost_model.ideal_seconds(work._replace(shown_pairs=8))
    assert double["compositing_adjoint"] == pytest.approx(2 * ideal["compositing_adjoint"])
