"""The repeated step: recorded, replayed, recorded again; and no memory made once it goes round."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import torch
import warp as wp
from oracles import GRADIENTS, inputs, target_image
from scenes import SceneTensors, random_scene
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode

from warpvec import exact, splat, step
from warpvec.canvas import Canvas
from warpvec.config import make_config
from warpvec.launch import Buffers
from warpvec.limits import Counts
from warpvec.population import Population
from warpvec.regularization import Regularization
from warpvec.renderer import Adjoints, TileRenderer
from warpvec.scene import Scene
from warpvec.step import RepeatedStep

KINDS = ("exact", "splat")


def renderer_of(kind: str, scene: SceneTensors, device: str = "cpu") -> TileRenderer:
    """One whose launches a graph can record on the CPU too: with scalar lanes, as on a GPU, and one thread."""
    shared = {"lane_width": 1, "threads": 1, "transmittance_min": 1e-4, "device": device}
    if kind == "exact":
        return exact.Renderer(scene.height, scene.width, **shared)
    return splat.Renderer(scene.height, scene.width, samples=9, lines=3, **shared)


class Moving:
    """Paths that move in their memory, and their step beside one that is never recorded."""

    def __init__(self, kind: str, scene: SceneTensors, device: str = "cpu") -> None:
        self.renderer, self.plain = renderer_of(kind, scene, device), renderer_of(kind, scene, device)
        self.repeated = RepeatedStep(self.renderer, record=True)
        self.target = self.renderer.prepare_target(target_image(scene))
        self.values = [value.clone() for value in inputs(scene, self.renderer)]

    def move(self, distance: float = 0.7) -> None:
        self.values[0] += distance
        self.values[1].mul_(0.99)

    def step(self, removal: bool = False) -> Adjoints:
        return self.repeated.take(*self.values, self.target, removal)

    def want(self, removal: bool = False) -> Adjoints:
        return self.plain.fit_step(*self.values, self.target, removal)

    def check_step(self, removal: bool = False) -> None:
        check_equal(self.step(removal), self.want(removal))
        self.move()


def check_equal(got: Adjoints, want: Adjoints) -> None:
    for name in (*GRADIENTS, "loss"):
        assert torch.equal(getattr(got, name), getattr(want, name)), name
    assert (got.removal is None) == (want.removal is None)
    assert want.removal is None or torch.equal(got.removal, want.removal)


@pytest.fixture
def launches(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The graphs that were replayed."""
    replayed: list[object] = []
    replay = wp.capture_launch
    monkeypatch.setattr(wp, "capture_launch", lambda graph: (replayed.append(graph), replay(graph)))
    return replayed


@pytest.mark.parametrize("kind", KINDS)
def test_replays_follow_the_paths(kind: str, launches: list[object], device: str) -> None:
    moving = Moving(kind, random_scene(1, 20, 60, 70), device)
    for _ in range(12):
        moving.check_step()
    # One to be counted, one to rehearse, which is checked by a replay, and ten replays of one graph.
    assert len(launches) == 11 and len(set(map(id, launches))) == 1
    assert moving.renderer.lost == 0


@pytest.mark.parametrize("kind", KINDS)
def test_other_memory_is_recorded_anew(kind: str, launches: list[object]) -> None:
    moving = Moving(kind, random_scene(1, 20, 60, 70))
    for count in (20, 12, 20):
        moving.values = [value[:count].clone() for value in moving.values[:3]] + [moving.values[3].clone()]
        extra = max(0, count - len(moving.values[0]))
        rows = inputs(random_scene(2, 20, 60, 70), moving.renderer)
        moving.values[:3] = [torch.cat([a, b[:extra]]) for a, b in zip(moving.values[:3], rows[:3], strict=True)]
        for _ in range(4):
            moving.check_step()
    assert len(set(map(id, launches))) == 3 and len(launches) == 3 * 2 + 1


@pytest.mark.parametrize("count", [20, 7])
@pytest.mark.parametrize("removal", [False, True])
def test_steps_between_replays_leave_them_alone(count: int, removal: bool, launches: list[object]) -> None:
    """With removal, or of fewer paths while paused: neither is recorded."""
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    for _ in range(3):
        moving.check_step()
    fewer = [value[:count].clone() for value in moving.values[:3]] + [moving.values[3]]
    for _ in range(2):
        moving.repeated.is_paused = not removal
        got = moving.repeated.take(*fewer, moving.target, removal)
        check_equal(got, moving.plain.fit_step(*fewer, moving.target, removal))
        moving.repeated.is_paused = False
        moving.check_step()
        assert not removal or torch.equal(got.color, moving.plain.fit_step(*fewer, moving.target).color)
    assert len(launches) == 4 and len(set(map(id, launches))) == 1


def test_a_pause_leaves_the_recording_alone(launches: list[object]) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    for is_paused in (False, False, False, True, True, False):
        moving.repeated.is_paused = is_paused
        moving.check_step()
    assert len(launches) == 3 and len(set(map(id, launches))) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_another_render_that_moves_the_buffers_ends_the_recording(kind: str, launches: list[object]) -> None:
    moving, large = Moving(kind, random_scene(1, 6, 60, 70)), random_scene(2, 200, 60, 70)
    for _ in range(3):
        moving.check_step()
    assert moving.repeated.is_recorded
    growth = moving.renderer.growth
    moving.renderer.render(*inputs(large, moving.renderer))
    assert moving.renderer.growth > growth
    for _ in range(4):
        moving.check_step()
    assert moving.repeated.is_recorded and len(set(map(id, launches))) == 2


def test_a_render_between_replays_changes_nothing(launches: list[object]) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    for _ in range(6):
        moving.check_step()
        moving.renderer.render(*inputs(random_scene(2, 3, 60, 70), moving.renderer))
    assert len(set(map(id, launches))) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_paths_that_outgrow_their_room_are_counted_again(
    kind: str, launches: list[object], device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(step, "_CHECK_GAP", 4)
    monkeypatch.setattr(Counts, "with_headroom", lambda counts: Counts(*(count + 1 for count in counts)))
    moving = Moving(kind, random_scene(3, 12, 60, 70), device)
    for _ in range(3):
        check_equal(moving.step(), moving.want())
    loss = moving.want().loss
    center = moving.values[0].mean(1, keepdim=True)
    moving.values[0].copy_(center + 2.0 * (moving.values[0] - center))
    for _ in range(3):  # until the host looks
        lost = moving.step()
        assert not any(getattr(lost, name).any() for name in GRADIENTS)
        assert torch.equal(lost.loss, loss) and moving.renderer.fits == -1.0
    # What has no limit minds no overflow.
    adj_image = torch.ones(60, 70, 3, device=moving.renderer.device)
    assert moving.renderer.adjoint(*moving.values, adj_image).background.any()
    check_equal(moving.step(), moving.want())
    assert moving.renderer.fits == 1.0
    for _ in range(7):
        check_equal(moving.step(), moving.want())
    assert moving.repeated.is_recorded and moving.renderer.lost == 3


@pytest.mark.parametrize("fault", ["a replay", "a rehearsal"])
def test_a_recording_that_differs_is_not_used(
    fault: str, launches: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70))
    spoil = (wp, "capture_launch") if fault == "a replay" else (moving.renderer, "fit_step")
    act = getattr(*spoil)

    def spoiled(*args: Any, **kwargs: Any) -> Any:
        result = act(*args, **kwargs)
        if fault == "a replay" or moving.renderer._launch.limits.room is not None:
            moving.repeated._out.color[0] += 1e-6
        return result

    monkeypatch.setattr(*spoil, spoiled)
    for _ in range(5):
        moving.check_step()
    assert len(launches) == 1 and not moving.repeated.is_recorded


@pytest.mark.parametrize("hindrance", ["memory", "capture"])
@pytest.mark.parametrize("recorded", [0, 4])
def test_where_nothing_can_be_recorded_steps_are_counted(
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
    moving.values = [value.clone() for value in moving.values]
    launches.clear()
    for _ in range(5):
        moving.check_step()
    assert not launches and moving.renderer.lost == 0


def test_steps_are_recorded_on_a_gpu_alone_unless_asked_for(launches: list[object], device: str) -> None:
    moving = Moving("exact", random_scene(1, 20, 60, 70), device)
    moving.repeated = RepeatedStep(moving.renderer)
    for _ in range(4):
        moving.check_step()
    assert len(launches) == (0 if device == "cpu" else 3)


# Memory


class NewTensors(TorchDispatchMode):
    """Notes the sizes of tensors whose memory is new."""

    def __init__(self) -> None:
        super().__init__()
        self.sizes: list[tuple[str, int]] = []

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        result = func(*args, **(kwargs or {}))
        given = (*args, *(kwargs or {}).values())
        known = {value.data_ptr() for value in given if isinstance(value, Tensor)}
        if isinstance(result, Tensor) and result.data_ptr() not in known:
            self.sizes.append((str(func), result.numel()))
        return result


@pytest.mark.parametrize("record", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_steady_step_makes_no_memory(kind: str, record: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    moving = Moving(kind, random_scene(1, 20, 60, 70))
    moving.repeated = RepeatedStep(moving.renderer, record)
    for _ in range(4):
        moving.step()
    growth, made = moving.renderer.growth, count_arrays(monkeypatch)
    with NewTensors() as new:
        for _ in range(5):
            moving.step()
    assert moving.renderer.growth == growth and not made
    assert not new.sizes


def count_arrays(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Warp arrays that bring memory of their own from now on."""
    made: list[Any] = []
    for name in ("zeros", "empty", "full", "ones"):
        make: Callable[..., Any] = getattr(wp, name)
        monkeypatch.setattr(wp, name, lambda *a, _make=make, **k: made.append(_make(*a, **k)) or made[-1])
    return made


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("reduction", [1, 2])
def test_a_steady_step_of_the_fit_makes_nothing_large(
    kind: str, reduction: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside the rows of a few paths, nothing: tensors of the image's size, or of all points', are made once."""
    tensors = random_scene(4, 30, 64, 96)
    floats = (value.float() for value in tensors[:4])
    config = make_config(renderer=kind, device="cpu")
    population = Population(Scene(*floats, generation=torch.zeros(30, dtype=torch.int64)), config, 48.0)
    canvas = Canvas(target_image(tensors).float(), config, "cpu", reduction)
    regularization = Regularization(64, 96, config, "cpu", 3)

    def take_step() -> None:
        adjoints = canvas.fit_step(population.live, False)
        regularization.add_adjoint(population.live.points, population.live.opacity, adjoints.points, adjoints.opacity)
        population.step(adjoints.points, adjoints.color, adjoints.opacity, adjoints.background, 0.0)

    with torch.no_grad():
        for _ in range(3):
            take_step()
        growth, made = canvas._renderer.growth, count_arrays(monkeypatch)
        with NewTensors() as new:
            for _ in range(3):
                take_step()
    assert canvas._renderer.growth == growth and not made
    assert max((size for _, size in new.sizes), default=0) <= 4


def test_new_tensors_and_arrays_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    value, made = torch.zeros(7), count_arrays(monkeypatch)
    with NewTensors() as new:
        value.reshape(1, 7).add_(1.0)
        value + 1.0
        torch.empty(5)
    assert [size for _, size in new.sizes] == [7, 5]
    buffers = Buffers("cpu")
    buffers.get("a", 3, wp.float32), buffers.get("a", 3, wp.float32)
    assert len(made) == 1
