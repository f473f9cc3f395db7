"""The recorded step: recorded, replayed, recorded again, and taken directly if it cannot be recorded."""

from __future__ import annotations

from typing import Any

import pytest
import torch
import warp as wp
from oracles import GRADIENTS, inputs
from scenes import random_scene
from stepping import KINDS, Moving, check_equal, copied

from warpvec.rendering import graph
from warpvec.rendering.capacity import Counts
from warpvec.rendering.graph import RecordedStep
from warpvec.rendering.tile_renderer import Adjoints


@pytest.fixture
def launches(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Collect the graphs that are replayed."""
    replayed: list[object] = []
    replay = wp.capture_launch
    monkeypatch.setattr(wp, "capture_launch", lambda graph: (replayed.append(graph), replay(graph)))
    return replayed


@pytest.mark.parametrize("kind", KINDS)
def test_replays_follow_the_paths(kind: str, launches: list[object], device: str) -> None:
    moving = Moving(kind, random_scene(1, 20, 60, 70), device)
    for _ in range(12):
        moving.check_step()
    # One step reads its counts, one records a graph and checks a replay of it, and ten replay the graph.
    assert len(launches) == 11 and len(set(map(id, launches))) == 1
    assert moving.renderer.dropped_steps == 0


@pytest.mark.parametrize("kind", KINDS)
def test_inputs_in_other_memory_are_recorded_again(kind: str, launches: list[object]) -> None:
    moving = Moving(kind, random_scene(1, 20, 60, 70))
    for count in (20, 12, 20):
        kept = moving.scene.select(torch.arange(min(count, len(moving.scene))))
        extra = inputs(random_scene(2, 20, 60, 70), moving.renderer).select(torch.arange(count - len(kept)))
        moving.scene = copied(kept.joined(extra))
        for _ in range(4):
            moving.check_step()
    assert len(set(map(id, launches))) == 3 and len(launches) == 3 * 2 + 1


@pytest.mark.parametrize("count", [20, 7])
@pytest.mark.parametrize("want_removal_cost", [False, True])
def test_direct_steps_between_replays_keep_the_recording(
    count: int, want_removal_cost: bool, launches: list[object]
) -> None:
    """Steps that want removal costs, or are of fewer paths while paused, are not recorded."""
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    for _ in range(3):
        moving.check_step()
    fewer = moving.scene.select(torch.arange(count))
    for _ in range(2):
        moving.recorded.is_paused = not want_removal_cost
        got = moving.recorded.take(fewer, moving.target, want_removal_cost)
        check_equal(got, moving.plain.fit_step(fewer, moving.target, want_removal_cost))
        moving.recorded.is_paused = False
        moving.check_step()
        assert not want_removal_cost or torch.equal(got.color, moving.plain.fit_step(fewer, moving.target).color)
    assert len(launches) == 4 and len(set(map(id, launches))) == 1


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("count", "draws"), [(7, 1), (400, 2)])
def test_drawing_within_the_capacity_reads_no_counts_unless_it_is_exceeded(kind: str, count: int, draws: int) -> None:
    """With 400 paths the recorded capacity is too small, and the second drawing reads its counts."""
    moving = Moving(kind, random_scene(1, 20, 60, 70))
    for _ in range(3):
        moving.check_step()
    other = inputs(random_scene(2, count, 60, 70), moving.renderer)
    limits = []

    def draw() -> Adjoints:
        limits.append(moving.renderer._launch.capacity.limit)
        return moving.renderer.fit_step(other, moving.target, True)

    got = moving.recorded.within(draw)
    check_equal(got, moving.plain.fit_step(other, moving.target, True))
    assert len(limits) == draws and limits[0] is not None
    moving.check_step()


def test_a_pause_keeps_the_recording(launches: list[object]) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    for is_paused in (False, False, False, True, True, False):
        moving.recorded.is_paused = is_paused
        moving.check_step()
    assert len(launches) == 3 and len(set(map(id, launches))) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_another_render_that_moves_the_buffers_ends_the_recording(kind: str, launches: list[object]) -> None:
    moving, large = Moving(kind, random_scene(1, 6, 60, 70)), random_scene(2, 200, 60, 70)
    for _ in range(3):
        moving.check_step()
    assert len(launches) == 2
    growth = moving.renderer.growth
    moving.renderer.render(inputs(large, moving.renderer))
    assert moving.renderer.growth > growth
    for _ in range(4):
        moving.check_step()
    assert len(launches) == 4 and len(set(map(id, launches))) == 2


def test_a_render_between_replays_changes_nothing(launches: list[object]) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    for _ in range(6):
        moving.check_step()
        moving.renderer.render(inputs(random_scene(2, 3, 60, 70), moving.renderer))
    assert len(set(map(id, launches))) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_paths_that_outgrow_the_capacity_get_a_larger_one(
    kind: str, launches: list[object], device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(graph, "_CHECK_GAP", 4)
    monkeypatch.setattr(Counts, "with_headroom", lambda counts: Counts(*(count + 1 for count in counts)))
    moving = Moving(kind, random_scene(3, 12, 60, 70), device)
    for _ in range(3):
        check_equal(moving.step(), moving.want())
    loss = moving.want().loss
    points = moving.scene.points  # a view
    center = points.mean(1, keepdim=True)
    points.copy_(center + 2.0 * (points - center))
    for _ in range(3):  # until the host looks
        dropped_steps = moving.step()
        assert not any(getattr(dropped_steps, name).any() for name in ("segments", *GRADIENTS[1:]))
        assert torch.equal(dropped_steps.loss, loss) and moving.renderer.fits == -1.0
    # A render without a limit ignores the overflow.
    adj_image = torch.ones(60, 70, 3, device=moving.renderer.device)
    assert moving.renderer.adjoint(moving.scene, adj_image).background.any()
    check_equal(moving.step(), moving.want())
    assert moving.renderer.fits == 1.0
    for _ in range(7):
        check_equal(moving.step(), moving.want())
    launches.clear()
    check_equal(moving.step(), moving.want())
    assert launches and moving.renderer.dropped_steps == 3


@pytest.mark.parametrize("fault", ["a replay", "a rehearsal"])
def test_a_recording_that_differs_is_not_used(
    fault: str, launches: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    spoil = (wp, "capture_launch") if fault == "a replay" else (moving.renderer, "fit_step")
    act = getattr(*spoil)

    def spoiled(*args: Any, **kwargs: Any) -> Any:
        result = act(*args, **kwargs)
        if fault == "a replay" or moving.renderer._launch.capacity.limit is not None:
            moving.recorded._out.color[0] += 1e-6
        return result

    monkeypatch.setattr(*spoil, spoiled)
    for _ in range(5):
        moving.check_step()
    assert len(launches) == 1


@pytest.mark.parametrize("hindrance", ["memory", "capture"])
@pytest.mark.parametrize("recorded", [0, 4])
def test_steps_that_cannot_be_recorded_are_taken_directly(
    hindrance: str, recorded: int, launches: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*args: Any, **kwargs: Any) -> None:
        raise RuntimeError("no capture")

    moving = Moving("exact", random_scene(1, 20, 60, 70))
    for _ in range(recorded):
        moving.check_step()
    assert len(launches) == max(0, recorded - 1)
    if hindrance == "memory":
        monkeypatch.setattr(Counts, "with_headroom", lambda counts: counts._replace(pairs=2**31))
    else:
        monkeypatch.setattr(wp, "ScopedCapture", refuse)
    moving.scene = copied(moving.scene)
    launches.clear()
    for _ in range(5):
        moving.check_step()
    assert not launches and moving.renderer.dropped_steps == 0


def test_by_default_only_a_gpu_records(launches: list[object], device: str) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70), device)
    moving.recorded = RecordedStep(moving.renderer)
    for _ in range(4):
        moving.check_step()
    assert len(launches) == (0 if device == "cpu" else 3)
