"""Populations whose segments are split and merged between steps."""

from __future__ import annotations

import pytest
import torch
from compound import compound_scene
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.population import Population
from warpvec.geometry import nodes
from warpvec.geometry.quick_merge import quick_merges
from warpvec.geometry.scene import Scene

HALF_SIDE = 40.0
RATE = FitConfig().lr_points * HALF_SIDE
"""Pixels by which a step of Adan moves a point at most, about."""


def smooth_adjoints(scene: Scene) -> list[Tensor]:
    """Return adjoints like those of outlines that are pulled with the same force per length all along.

    A quarter of the pull at a segment is at each of its four points.
    """
    structure = scene.structure
    control = torch.cat([scene.segments, scene.segments[structure.segment_next.long(), :1]], 1)
    quarter = 1e-3 * control.diff(dim=1).norm(dim=-1).sum(1, keepdim=True)
    pull = torch.stack([quarter + quarter[structure.segment_previous.long()], quarter, quarter], 1)
    others = (torch.full_like(value, 1e-3) for value in (scene.color, scene.opacity, scene.background))
    return [pull.expand_as(scene.segments).clone(), *others]


def stepped(count: int, seed: int = 0) -> Population:
    population = Population(compound_scene(seed, 9, 60, 80), FitConfig(), HALF_SIDE)
    for _ in range(count):
        population.step(*smooth_adjoints(population.scene), 1.0)
    return population


def every_other_row(scene: Scene) -> Tensor:
    """Return the rows at odd places of their loops, none of which follows another."""
    first = scene.structure.loop_first_segment.long()
    places = torch.arange(len(scene.segments)) - first[:-1].repeat_interleave(first.diff())
    return (places % 2 == 1).nonzero().flatten()


def merge(population: Population, rows: Tensor) -> None:
    found = quick_merges(population.scene)
    population.merge(rows, found.handles[rows], found.share[rows])


OPERATIONS = {
    "split": lambda population: population.split(torch.arange(0, 12, 2), 0.3),
    "merge": lambda population: merge(population, every_other_row(population.scene)),
}


@pytest.mark.parametrize("age", [0, 1, 60])
@pytest.mark.parametrize("name", OPERATIONS)
def test_a_population_goes_on_at_its_speed(name: str, age: int) -> None:
    population = stepped(age)
    before = population.scene
    OPERATIONS[name](population)
    scene = population.scene
    assert torch.equal(scene.color, before.color) and len(scene) == len(before)
    state = population.state()
    population.check(state, None, age, len(scene), 100) if scene.segments.dtype == torch.float32 else None
    assert all(bool(plane.isfinite().all()) and plane.is_contiguous() for plane in state["segments"])
    for _ in range(3):
        last = population.scene
        population.step(*smooth_adjoints(last), 1.0)
        moved = population.scene.segments - last.segments
        assert bool(moved.isfinite().all())
        # A steady pull moves each point by the rate a step, before the change and after it.
        assert moved.abs().max() < 1.1 * RATE
        assert moved[:, 0].max() < 0.0


def square_population(cut: bool) -> Population:
    """Return a square of four curves of even speed, of which the second one may be cut at 0.3."""
    corners = torch.tensor([[20, 20], [60, 20], [60, 60], [20, 60.0]], dtype=torch.float64)
    points = torch.stack([corners + share * (corners.roll(-1, 0) - corners) for share in (0, 1 / 3, 2 / 3)], 1)
    one = torch.full((1, 3), 0.5, dtype=torch.float64)
    scene = Scene.uniform(points.reshape(1, 12, 2), one, one[0, :1], one[0], torch.zeros(1, dtype=torch.int64))
    return Population(nodes.split(scene, torch.tensor([1]), 0.3).scene if cut else scene, FitConfig(), HALF_SIDE)


@pytest.mark.parametrize("steps", [1, 3, 60])
def test_a_new_segment_has_the_averages_that_it_would_have_had_from_the_start(steps: int) -> None:
    late, early = square_population(False), square_population(True)
    for population in (late, early):
        for _ in range(steps):
            population.step(*smooth_adjoints(population.scene), 1.0)
    whole, handles = late.state()["segments"].clone(), late.scene.segments[1:2, 1:]
    late.split(torch.tensor([1]), 0.3)
    torch.testing.assert_close(late.scene.segments, early.scene.segments, rtol=1e-5, atol=1e-5)
    pieces = late.state()["segments"][1:, 1:3], early.state()["segments"][1:, 1:3]
    # Half of the first anchor's gradient is from the segment before, whose length is as before.
    torch.testing.assert_close(*pieces, rtol=1e-5, atol=1e-9)
    early.merge(torch.tensor([2]), handles, torch.tensor([0.3], dtype=torch.float64))
    torch.testing.assert_close(early.state()["segments"][1:, 1], whole[1:, 1], rtol=1e-5, atol=1e-9)


def test_rows_that_are_not_changed_keep_their_bits() -> None:
    population = stepped(7)
    before = {name: value.clone() for name, value in population.state().items() if isinstance(value, Tensor)}
    edit = nodes.split(population.scene, torch.tensor([3, 3, 8]), torch.tensor([0.2, 0.6, 0.5]))
    population.split(torch.tensor([3, 3, 8]), torch.tensor([0.2, 0.6, 0.5]))
    after = population.state()
    kept, source = ~edit.is_fresh, edit.source[:, 0]
    assert edit.source[edit.is_fresh, 0].tolist() == [3, 3, 3, 8, 8]
    assert torch.equal(after["segments"][:, kept], before["segments"][:, source[kept]])
    assert after["segment_age"].tolist() == [7] * len(source)
    assert torch.equal(after["color"], before["color"]) and torch.equal(after["age"], before["age"])


def test_a_merged_segment_has_the_age_of_the_older() -> None:
    population = stepped(5)
    young = compound_scene(1, 1, 60, 80)
    population.append(young)
    count = population.scene.structure.segment_count
    first = count - young.structure.segment_count
    population.split(torch.tensor([first]))
    for _ in range(2):
        population.step(*smooth_adjoints(population.scene), 1.0)
    merge(population, torch.tensor([1, first + 1]))
    ages = population.state()["segment_age"].tolist()
    assert ages == [7] * (first - 1) + [2] * (count - first)


def test_a_population_that_is_saved_and_restored_steps_to_the_same_bits() -> None:
    scene = compound_scene(0, 9, 60, 80)
    narrow = Scene(
        scene.segments.float(), scene.structure, *(v.float() for v in (scene.color, scene.opacity, scene.background)),
        scene.generation,
    )  # fmt: skip
    population = Population(narrow, FitConfig(), HALF_SIDE)
    for _ in range(4):
        population.step(*(value.float() for value in smooth_adjoints(population.scene)), 1.0)
    population.split(torch.arange(5), 0.4)
    merge(population, torch.tensor([1]))
    state = population.state()
    other = Population(narrow, FitConfig(), HALF_SIDE)
    other.check(state, None, 4, len(narrow), 100)
    other.restore(state, None)
    for each in (population, other):
        each.step(*(value.float() for value in smooth_adjoints(each.scene)), 1.0)
    assert torch.equal(population.scene.segments, other.scene.segments)
