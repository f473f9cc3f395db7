"""Nodes move to where they pay: what is predicted, what is chosen, and what a fit makes of it."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from scenes import blob_scene

from warpvec.config.fit_config import FitConfig
from warpvec.fit import node_exchange
from warpvec.fit.loop import fit
from warpvec.fit.node_exchange import choose, curve_count
from warpvec.fit.node_gains import merge_costs, node_values
from warpvec.fit.state import Saving, State
from warpvec.fit.target import Target
from warpvec.geometry import nodes
from warpvec.geometry.circles import circle_points
from warpvec.geometry.quick_merge import quick_merges
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.rendering.outline_adjoint import OutlineAdjoint

SIDE, COUNT = 64, 20


def scene_of(points: torch.Tensor, color: float) -> Scene:
    count = len(points)
    fill, generation = torch.full((count, 3), color), torch.zeros(count, dtype=torch.int64)
    return Scene.uniform(points.float(), fill, torch.ones(count), torch.ones(3), generation)


def circle(radius: float = 20.0, segments: int = 4, color: float = 0.2) -> Scene:
    return scene_of(circle_points(torch.tensor([[32.0, 32.0]]), torch.tensor([radius]), segments), color)


def target_of(image: torch.Tensor) -> Target:
    return Target(image, FitConfig(threads=1), "cpu")


def photo() -> torch.Tensor:
    scene = Scene.uniform(
        *(values.float() for values in blob_scene(5, 12, SIDE, SIDE)[:4]), torch.zeros(12, dtype=torch.int64)
    )
    target = target_of(torch.zeros(SIDE, SIDE, 3))
    return target._renderer.render(scene)


def quick(**settings: Any) -> FitConfig:
    return FitConfig(**{"curves": COUNT, "iterations": 120, "threads": 1, "device": "cpu", **settings})


# what is predicted


def test_a_new_node_gains_most_where_the_outline_must_bend() -> None:
    bent = nodes.split(circle(), torch.tensor([2])).scene
    segments = bent.segments.clone()
    segments[3] += (torch.tensor([32.0, 32.0]) - segments[3, :1]) * 0.3  # a dent in the middle of row 2
    scene = circle()
    adjoints, outline = target_of(
        target_of(torch.zeros(SIDE, SIDE, 3))._renderer.render(replace(bent, segments=segments))
    ).outline_step(scene)
    gain = node_values(scene.structure, *outline).gain
    assert gain[2] > 10.0 * torch.cat([gain[:2], gain[3:]]).max()
    assert float(gain[2]) < float(adjoints.loss)


@pytest.mark.parametrize("form", [lambda t: t**3 - t, lambda t: (t - 0.5).abs(), lambda t: torch.sin(9.0 * t)])
def test_a_gain_is_that_of_the_best_spline_less_that_of_the_best_cubic(
    form: Callable[[torch.Tensor], torch.Tensor],
) -> None:
    chords, length, contrast = 400, 30.0, 2.0
    place = torch.linspace(0.0, 1.0, chords + 1, dtype=torch.float64)
    # A long edge to the right, and a triangle below that closes the loop without an adjoint.
    vertices = torch.cat([torch.stack([length * place, torch.zeros_like(place)], 1), torch.tensor([[15.0, 10.0]])])
    weight = form(place) * length / chords / 2.0
    adj = torch.zeros(chords + 2, 4, dtype=torch.float64)
    adj[:chords, 1], adj[:chords, 3] = weight[:-1], weight[1:]
    outline = OutlineAdjoint(torch.tensor([0, chords, chords + 1, chords + 2]), vertices, adj)
    values = node_values(Structure.uniform(1, 3), outline, torch.tensor([contrast], dtype=torch.float64))
    stiffness = 2.0 * contrast / (150.0 + 1.0)
    t = place.numpy()
    cubic = np.stack([t**power for power in range(4)], 1)
    spline = np.concatenate([cubic, np.stack([np.maximum(t - 0.5, 0.0) ** power for power in (1, 2, 3)], 1)], 1)
    wanted = form(place).numpy()
    rests = [wanted - basis @ np.linalg.lstsq(basis, wanted, rcond=None)[0] for basis in (cubic, spline)]
    before, after = (np.trapezoid(rest**2, t) * length / (2.0 * stiffness) for rest in rests)
    assert float(values.gain[0]) == pytest.approx(before - after, rel=0.02, abs=1e-4)
    assert float(values.gain[1]) == 0.0


def test_the_cost_of_a_node_is_the_rise_of_the_loss() -> None:
    scene = circle()
    target = target_of(target_of(torch.zeros(SIDE, SIDE, 3))._renderer.render(scene))
    values, merges = node_values(scene.structure, *target.outline_step(scene)[1]), quick_merges(scene)
    cost = float(merge_costs(values, merges)[3])
    row = torch.tensor([3])
    rise = float(target.fit_step(nodes.merge(scene, row, merges.handles[row], merges.share[row]).scene, False).loss)
    assert rise / 2.0 < cost < 2.0 * rise


def test_a_node_within_one_cubic_costs_nothing() -> None:
    scene = nodes.split(circle(), torch.tensor([1]), 0.4).scene
    merges = quick_merges(scene)
    assert float(merges.offset[2].abs().max()) < 0.01
    assert float(merges.offset[1].abs().max()) > 0.04


# what is chosen


def test_a_choice_keeps_the_total_and_divides_no_segment_that_changes() -> None:
    structure = Structure.of_loops([[5], [3], [4], [6]])
    generator = torch.Generator().manual_seed(4)
    for excess in (-2, 0, 1, 3):
        gain, cost = torch.rand(2, 18, generator=generator, dtype=torch.float64)
        drop, divide = choose(structure, gain + 1.0, cost, excess)
        assert len(drop) - len(divide) == excess
        assert len(structure.segment_path[drop].unique()) == len(drop)
        touched = torch.cat([drop, structure.segment_previous.long()[drop]])
        assert not set(touched.tolist()) & set(divide.tolist())


def test_no_node_moves_for_less_than_it_costs() -> None:
    structure = Structure.of_loops([[5], [5]])
    gain, cost = torch.full((10,), 1.0).double(), torch.full((10,), 10.0).double()
    assert [len(rows) for rows in choose(structure, gain, cost, 0)] == [0, 0]


# what a fit makes of it


def test_a_fit_gives_paths_as_many_nodes_as_they_need_at_the_same_total() -> None:
    moved, fixed = (fit(photo(), quick(fixed_segments=flag)).scene for flag in (False, True))
    counts = moved.structure.path_first_segment.diff()
    assert fixed.is_uniform
    assert moved.structure.segment_count == fixed.structure.segment_count == 4 * COUNT
    assert int(counts.min()) < 4 < int(counts.max())


def test_no_path_gets_nodes_beyond_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_exchange, "SEGMENTS_MAX", 5)
    scene = fit(photo(), quick()).scene
    assert int(scene.structure.path_first_segment.diff().max()) == 5
    assert scene.structure.segment_count == 4 * COUNT


@pytest.mark.parametrize("settings", [{}, {"lod": True}, {"gradients": "auto"}, {"colors": 8}], ids=str)
def test_a_resumed_fit_equals_the_whole_one(settings: dict[str, Any]) -> None:
    kept: list[State] = []
    config = quick(iterations=70, **settings)
    whole = fit(photo(), config, saving=Saving(45, lambda state: kept.append(deepcopy(state)))).scene
    assert not whole.is_uniform
    resumed = fit(photo(), replace(config, threads=2), resume=kept[0]).scene
    torch.testing.assert_close(resumed.to_dict(), whole.to_dict(), rtol=0.0, atol=0.0)


def test_nodes_of_given_paths_beyond_the_mean_are_kept() -> None:
    start = circle(segments=30)
    scene = fit(photo(), quick(curves=5), start=start).scene
    assert curve_count(scene.structure) == 30 + 4 * 4


def test_a_picture_with_alpha_moves_nodes_too() -> None:
    alpha = (photo()[..., :1] > 0.5).float()
    scene = fit(torch.cat([photo(), alpha], -1), quick(iterations=60)).scene
    assert not scene.is_uniform
    assert scene.structure.segment_count == 4 * COUNT
