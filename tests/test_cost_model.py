"""The cost model of bench_step: what it counts."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import torch

from warpvec.exact import Renderer

sys.path.append(str(Path(__file__).parents[1] / "bench"))
cost_model = import_module("cost_model")


def test_work_of_a_scene_is_counted() -> None:
    square = torch.tensor(
        [[4, 4], [8, 4], [14, 4], [20, 4], [20, 8], [20, 14], [20, 20], [14, 20], [8, 20], [4, 20], [4, 14], [4, 8]]
    )
    renderer = Renderer(40, 40)
    with torch.no_grad():
        points = square[None].float()
        renderer.render(points, torch.ones(1, 3), torch.ones(1), torch.zeros(3))
    work = cost_model.work_of(renderer._flattening, renderer._binning, np.zeros(9, np.int32), points)
    # Straight cubics are one chord each; 16 pixels along each of four sides, and the one where each starts.
    assert work == cost_model.Work(1, 12, 4, 4 * 16 + 4, 4, 4, 4)
    ideal = cost_model.ideal_seconds(work)
    assert set(ideal) >= {"flattening", "binning", "coverage", "compositing_adjoint"}
    assert ideal["flattening"] == pytest.approx(4 * cost_model.VERTEX_NS * 1e-9)
    double = cost_model.ideal_seconds(work._replace(shown_pairs=8))
    assert double["compositing_adjoint"] == pytest.approx(2 * ideal["compositing_adjoint"])
