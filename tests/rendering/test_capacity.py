"""Steps whose counts the host does not read: the same results, and no harm where something has no room."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import torch
import warp as wp
from oracles import GRADIENTS, inputs, lane_widths, target_image
from scenes import ZOO, SceneTensors, ZooCase, circle, degenerate_scene, random_scene

from warpvec.rendering import exact, launch, splat
from warpvec.rendering.capacity import Counts
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer

SIZES = [(1, 1), (16, 16), (17, 15), (33, 50), (20, 16 * 65)]
KINDS = ("exact", "splat")

# Entries, a multiple of 4, on either side of a buffer.
_GUARD = 4096


def renderer_of(kind: str, scene: SceneTensors, lane_width: int = 1) -> TileRenderer:
    shared = {"lane_width": lane_width, "threads": 2, "transmittance_min": 1e-4}
    if kind == "exact":
        return exact.ExactRenderer(scene.height, scene.width, **shared)
    return splat.SplatRenderer(scene.height, scene.width, samples=9, lines=3, **shared)


def step(scene: SceneTensors, renderer: TileRenderer) -> Adjoints:
    return renderer.fit_step(*inputs(scene, renderer), renderer.prepare_target(target_image(scene)))


def limited(scene: SceneTensors, renderer: TileRenderer, room: Counts) -> Adjoints:
    renderer.limit(room)
    return step(scene, renderer)


def overflow(renderer: TileRenderer) -> list[int]:
    return renderer._launch.capacity.overflow.numpy().tolist()


def check_equal(got: Adjoints, want: Adjoints) -> None:
    for name in (*GRADIENTS, "loss"):
        assert torch.equal(getattr(got, name), getattr(want, name)), name


def check_same(scene: SceneTensors, kind: str, lane_width: int) -> None:
    """With as much room as it needs, and with more, a step is what it is with all counts read."""
    renderer = renderer_of(kind, scene, lane_width)
    want = step(scene, renderer)
    for room in (renderer.counts, renderer.counts.with_headroom()):
        check_equal(limited(scene, renderer, room), want)
        assert renderer.counts[1:] == room[1:] and overflow(renderer) == [0] * 4 and renderer.dropped_steps == 0
        assert renderer.fits == 1.0


@pytest.mark.parametrize(("height", "width"), SIZES)
@pytest.mark.parametrize("kind", KINDS)
@lane_widths
def test_with_room_nothing_changes(height: int, width: int, kind: str, lane_width: int) -> None:
    check_same(random_scene(height, 12, height, width), kind, lane_width)
    check_same(degenerate_scene(width, 9, height, width), kind, lane_width)


@pytest.mark.parametrize("path_count", [0, 1, 63, 64, 65, 300])
@pytest.mark.parametrize("kind", KINDS)
def test_any_number_of_paths(path_count: int, kind: str) -> None:
    check_same(random_scene(path_count, path_count, 33, 50), kind, 1)


@pytest.mark.parametrize("case", ZOO, ids=lambda case: case.name)
@pytest.mark.parametrize("kind", KINDS)
def test_the_zoo(case: ZooCase, kind: str) -> None:
    check_same(case.scene, kind, 1)


@pytest.mark.parametrize("kind", KINDS)
def test_what_another_scene_left_does_not_count(kind: str) -> None:
    large, small = random_scene(1, 40, 33, 50), random_scene(2, 3, 33, 50)
    renderer = renderer_of(kind, large)
    step(large, renderer)
    room = renderer.counts
    got = limited(small, renderer, room)
    check_equal(got, step(small, renderer_of(kind, small)))
    check_equal(limited(large, renderer, room), step(large, renderer_of(kind, large)))


@pytest.mark.parametrize("kind", KINDS)
def test_removal_too(kind: str) -> None:
    scene = random_scene(3, 12, 33, 50)
    renderer = renderer_of(kind, scene)
    arguments = [*inputs(scene, renderer), renderer.prepare_target(target_image(scene)), True]
    want = renderer.fit_step(*arguments)
    renderer.limit(renderer.counts)
    assert torch.equal(renderer.fit_step(*arguments).removal_cost, want.removal_cost)


# Overflow


def short_rooms(counts: Counts) -> Iterator[tuple[int, Counts]]:
    """Rooms that are one short in one count, or have no room for it at all, and the index of that count."""
    for index, (name, count) in enumerate(counts._asdict().items()):
        for room in {count - 1, 0} if count else ():
            yield index, counts._replace(**{name: room})


@pytest.fixture
def guards(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Memory around each buffer, which ends where it was asked to: 0, 1, 2, 3 over and over.

    Whoever reads there finds paths, boxes of two columns, and classes of pairs.
    """
    made: list[np.ndarray] = []

    class Guarded(launch.Buffers):
        def get(self, name: str, shape: int | tuple[int, ...], dtype: object) -> wp.array:
            shape = (shape,) if isinstance(shape, int) else shape
            length = max(shape[0], 1)
            growth = self.growth
            whole = super().get(name, (length + 2 * _GUARD, *shape[1:]), dtype)
            if self.growth > growth:
                for part in (whole.numpy()[:_GUARD], whole.numpy()[_GUARD + length :]):
                    part.reshape(-1)[:] = np.arange(part.size) % 4
                    made.append(part)
            return whole[_GUARD : _GUARD + length]

    monkeypatch.setattr(launch, "Buffers", Guarded)
    return made


def check_untouched(guards: list[np.ndarray]) -> None:
    assert guards and all((part.reshape(-1) == np.arange(part.size) % 4).all() for part in guards)
    guards.clear()


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_with_room_stays_within_it(kind: str, guards: list[np.ndarray]) -> None:
    scene = random_scene(6, 30, 60, 70)
    # Strips of no path, taken for more of the last one's, would have pairs far beyond all others, and there find the
    # slots of the first one.
    ends = circle(35.0, 30.0, 13.0), circle(35.0, 30.0, 80.0)
    scene = scene._replace(points=torch.cat([ends[0][None], scene.points[1:-1], ends[1][None]]))
    want = step(scene, counted := renderer_of(kind, scene))
    for room in (counted.counts, counted.counts.with_headroom()):
        check_equal(limited(scene, renderer_of(kind, scene), room), want)
    check_untouched(guards)


@pytest.mark.parametrize("kind", KINDS)
@lane_widths
def test_a_step_without_room_changes_nothing(kind: str, lane_width: int) -> None:
    scene = random_scene(4, 30, 60, 70)
    renderer = renderer_of(kind, scene, lane_width)
    adjoints = step(scene, renderer)
    target, loss = renderer.prepare_target(target_image(scene)), adjoints.loss.clone()
    for dropped_steps, (index, room) in enumerate(short_rooms(renderer.counts), 1):
        renderer.limit(None)
        step(scene, renderer)  # leaves all that a step without room must not read
        renderer.limit(room)
        renderer.fit_step(*inputs(scene, renderer), target, out=adjoints)
        assert overflow(renderer)[index] == 1 and renderer.dropped_steps == dropped_steps and renderer.fits == -1.0
        assert not any(getattr(adjoints, name).any() for name in GRADIENTS), room
        assert torch.equal(adjoints.loss, loss)


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_without_room_stays_within_it(kind: str, guards: list[np.ndarray]) -> None:
    scene = random_scene(4, 30, 60, 70)
    step(scene, counted := renderer_of(kind, scene))
    for _, room in short_rooms(counted.counts):
        adjoints = limited(scene, renderer_of(kind, scene), room)
        assert not any(getattr(adjoints, name).any() for name in GRADIENTS), room
    check_untouched(guards)


@pytest.mark.parametrize("kind", KINDS)
def test_room_to_grow_recovers(kind: str) -> None:
    small, large = random_scene(5, 4, 60, 70), random_scene(5, 60, 60, 70)
    renderer = renderer_of(kind, small)
    step(small, renderer)
    room = renderer.counts
    limited(large, renderer, room)
    check_equal(limited(small, renderer, room), step(small, renderer_of(kind, small)))
    limited(large, renderer, room)
    assert renderer.dropped_steps == 2
    renderer.limit(None)
    want = step(large, renderer)
    check_equal(want, step(large, renderer_of(kind, large)))
    check_equal(limited(large, renderer, renderer.counts.with_headroom()), want)
    assert renderer.dropped_steps == 2 and overflow(renderer) == [0] * 4


def test_headroom_is_half_of_a_large_count_and_some_of_a_small_one() -> None:
    assert Counts(10_000, 1_000, 0, 1).with_headroom() == Counts(15_256, 1_756, 256, 257)
