"""Steps with a capacity: the same results if it suffices, and no damage if it does not."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import torch
import warp as wp
from backends import SCALAR, Backend
from oracles import GRADIENTS, inputs, target_image
from scenes import ZOO, SceneTensors, ZooCase, circle, degenerate_scene, random_scene
from sweep import sweep

from warpvec.kernels.capacity import make_kernels
from warpvec.kernels.lanes import make_lanes
from warpvec.paper import splat
from warpvec.rendering import exact, launch
from warpvec.rendering.capacity import Counts
from warpvec.rendering.launch import Launcher
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer

SIZES = [(1, 1), (16, 16), (17, 15), (33, 50), (20, 16 * 33)]
KINDS = ("exact", "splat")
VALUES = ("segments", *GRADIENTS[1:])

# Guard entries, a multiple of 4, on either side of a buffer.
_GUARD = 4096


def renderer_of(kind: str, scene: SceneTensors, backend: Backend = SCALAR) -> TileRenderer:
    shared = {**backend._asdict(), "threads": 2, "transmittance_min": 1e-4}
    if kind == "exact":
        return exact.ExactRenderer(scene.height, scene.width, **shared)
    return splat.SplatRenderer(scene.height, scene.width, samples=9, lines=3, **shared)


def step(scene: SceneTensors, renderer: TileRenderer) -> Adjoints:
    return renderer.fit_step(inputs(scene, renderer), renderer.prepare_target(target_image(scene)))


def limited(scene: SceneTensors, renderer: TileRenderer, limit: Counts) -> Adjoints:
    renderer.set_capacity(limit)
    return step(scene, renderer)


def overflow(renderer: TileRenderer) -> list[int]:
    return renderer._launch.capacity.overflow.numpy().tolist()


def check_equal(got: Adjoints, want: Adjoints) -> None:
    for name in (*VALUES, "loss"):
        assert torch.equal(getattr(got, name), getattr(want, name)), name


def check_same(scene: SceneTensors, kind: str, backend: Backend) -> None:
    """Check that with exactly the capacity it needs, and with more, a step equals one that reads its counts."""
    renderer = renderer_of(kind, scene, backend)
    want = step(scene, renderer)
    for limit in (renderer.counts, renderer.counts.with_headroom()):
        check_equal(limited(scene, renderer, limit), want)
        assert renderer.counts[1:] == limit[1:] and overflow(renderer) == [0] * 4 and renderer.dropped_steps == 0
        assert renderer.fits == 1.0


@pytest.mark.parametrize(("height", "width"), SIZES)
@pytest.mark.parametrize("kind", KINDS)
def test_enough_capacity_changes_nothing(height: int, width: int, kind: str, backend: Backend) -> None:
    check_same(random_scene(height, 12, height, width), kind, backend)
    check_same(degenerate_scene(width, 9, height, width), kind, backend)


@pytest.mark.parametrize("path_count", [0, 1, 63, 64, 65, 300])
@pytest.mark.parametrize("kind", KINDS)
def test_any_number_of_paths(path_count: int, kind: str) -> None:
    check_same(random_scene(path_count, path_count, 33, 50), kind, SCALAR)


@sweep("case", ZOO)
@pytest.mark.parametrize("kind", KINDS)
def test_the_zoo(case: ZooCase, kind: str) -> None:
    check_same(case.scene, kind, SCALAR)


@pytest.mark.parametrize("kind", KINDS)
def test_values_left_by_another_scene_do_not_count(kind: str) -> None:
    large, small = random_scene(1, 40, 33, 50), random_scene(2, 3, 33, 50)
    renderer = renderer_of(kind, large)
    step(large, renderer)
    limit = renderer.counts
    got = limited(small, renderer, limit)
    check_equal(got, step(small, renderer_of(kind, small)))
    check_equal(limited(large, renderer, limit), step(large, renderer_of(kind, large)))


@pytest.mark.parametrize("kind", KINDS)
def test_removal_costs_too(kind: str) -> None:
    scene = random_scene(3, 12, 33, 50)
    renderer = renderer_of(kind, scene)
    arguments = [inputs(scene, renderer), renderer.prepare_target(target_image(scene)), True]
    want = renderer.fit_step(*arguments)
    renderer.set_capacity(renderer.counts)
    assert torch.equal(renderer.fit_step(*arguments).removal_cost, want.removal_cost)


# Overflow


def short_capacities(counts: Counts) -> Iterator[tuple[int, Counts]]:
    """Yield capacities with one count that is one too small, or zero, and the index of that count."""
    for index, (name, count) in enumerate(counts._asdict().items()):
        for limit in {count - 1, 0} if count else ():
            yield index, counts._replace(**{name: limit})


@pytest.fixture
def guards(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Put guard entries 0, 1, 2, 3, 0, 1, ... around each buffer, which has the exact size asked for; return them.

    A kernel that reads the guards finds valid paths, boxes of two columns, and classes of pairs.
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
def test_a_step_within_its_capacity_stays_in_its_buffers(kind: str, guards: list[np.ndarray]) -> None:
    scene = random_scene(6, 30, 60, 70)
    # A strip of no path that was taken for one of the last path would have a pair beyond all others, and there find a
    # slot of the first path.
    ends = circle(35.0, 30.0, 13.0), circle(35.0, 30.0, 80.0)
    scene = scene._replace(points=torch.cat([ends[0][None], scene.points[1:-1], ends[1][None]]))
    want = step(scene, counted := renderer_of(kind, scene))
    for limit in (counted.counts, counted.counts.with_headroom()):
        check_equal(limited(scene, renderer_of(kind, scene), limit), want)
    check_untouched(guards)


@pytest.mark.parametrize("kind", KINDS)
def test_a_dropped_step_changes_nothing(kind: str, backend: Backend) -> None:
    scene = random_scene(4, 30, 60, 70)
    renderer = renderer_of(kind, scene, backend)
    adjoints = step(scene, renderer)
    target, loss = renderer.prepare_target(target_image(scene)), adjoints.loss.clone()
    for dropped_steps, (index, limit) in enumerate(short_capacities(renderer.counts), 1):
        renderer.set_capacity(None)
        step(scene, renderer)  # leaves values that a dropped step must not read
        renderer.set_capacity(limit)
        renderer.fit_step(inputs(scene, renderer), target, out=adjoints)
        assert overflow(renderer)[index] == 1 and renderer.dropped_steps == dropped_steps and renderer.fits == -1.0
        assert not any(getattr(adjoints, name).any() for name in VALUES), limit
        assert torch.equal(adjoints.loss, loss)


@pytest.mark.parametrize("kind", KINDS)
def test_a_dropped_step_stays_in_its_buffers(kind: str, guards: list[np.ndarray]) -> None:
    scene = random_scene(4, 30, 60, 70)
    step(scene, counted := renderer_of(kind, scene))
    for _, limit in short_capacities(counted.counts):
        adjoints = limited(scene, renderer_of(kind, scene), limit)
        assert not any(getattr(adjoints, name).any() for name in VALUES), limit
    check_untouched(guards)


@pytest.mark.parametrize("kind", KINDS)
def test_a_larger_capacity_recovers(kind: str) -> None:
    small, large = random_scene(5, 4, 60, 70), random_scene(5, 60, 60, 70)
    renderer = renderer_of(kind, small)
    step(small, renderer)
    limit = renderer.counts
    limited(large, renderer, limit)
    check_equal(limited(small, renderer, limit), step(small, renderer_of(kind, small)))
    limited(large, renderer, limit)
    assert renderer.dropped_steps == 2
    renderer.set_capacity(None)
    want = step(large, renderer)
    check_equal(want, step(large, renderer_of(kind, large)))
    check_equal(limited(large, renderer, renderer.counts.with_headroom()), want)
    assert renderer.dropped_steps == 2 and overflow(renderer) == [0] * 4


def test_a_count_that_wrapped_around_does_not_fit() -> None:
    """A sum of 2^31 or more is a negative number in 32 bits."""
    sums = wp.array([0, -5], dtype=wp.int32, device="cpu")
    first_vertex, overflow = wp.full(2, -1, dtype=wp.int32, device="cpu"), wp.zeros(4, dtype=wp.int32, device="cpu")
    kernel = make_kernels(make_lanes(1, wp.float32)).admit_vertices
    Launcher("cpu", threads=1)(kernel, 2, [sums, 1, 100, first_vertex, overflow])
    assert overflow.numpy().tolist() == [1, 0, 0, 0]
    assert first_vertex.numpy().tolist() == [0, 0]
