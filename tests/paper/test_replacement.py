"""Bezier Splatting's policy: each rule at its threshold, regions against a plain search, and whole fits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from scenes import with_points
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.fit.loop import fit
from warpvec.fit.population import Population
from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene
from warpvec.paper.replacement import Replacement, overlap_scores, region_centers, removable
from warpvec.watch.watch import Watch

HEIGHT, WIDTH = 300, 400
EARLY, LATE, LAST = 0.3, 0.75, 0.85


def ellipses(*rows: tuple[float, float, float, float], opacity: float = 0.9) -> Scene:
    """Return ellipses (x, y, width, height) in distinct colours, oldest first."""
    values = torch.tensor(rows, dtype=torch.float64)
    unit = circle_points(torch.zeros(len(rows), 2), torch.ones(len(rows)), 4).double()
    points = values[:, None, :2] + unit * values[:, None, 2:] / 2
    color = torch.linspace(0.0, 1.0, len(rows), dtype=torch.float64)[:, None].expand(-1, 3)
    alpha = torch.full((len(rows),), opacity, dtype=torch.float64)
    return Scene.uniform(
        points, color, alpha, torch.ones(3, dtype=torch.float64), torch.zeros(len(rows), dtype=torch.int64)
    )


def removed(scene: Scene, progress: float = EARLY) -> list[bool]:
    return removable(scene, HEIGHT, WIDTH, progress).tolist()


def test_paths_mostly_off_the_canvas_are_removed() -> None:
    # Of 100 pixels of width, 59 and 61 lie beyond each edge.
    across = [(x, 150.0, 100.0, 20.0) for x in (-9.0, -11.0, 409.0, 411.0)]
    down = [(200.0, y, 20.0, 100.0) for y in (-9.0, -11.0, 309.0, 311.0)]
    assert removed(ellipses(*across, *down)) == [False, True] * 4
    assert removed(ellipses((-500.0, 150.0, 100.0, 20.0), (200.0, 150.0, 100.0, 20.0))) == [True, False]


def test_tiny_paths_are_removed() -> None:
    sizes = [(3.9, 3.9), (4.1, 4.1), (2.0, 4.9), (2.0, 5.1), (5.1, 2.0), (0.0, 3.0)]
    rows = [(50.0 * k + 20.0, 100.0, width, height) for k, (width, height) in enumerate(sizes)]
    assert removed(ellipses(*rows)) == [True, False, True, False, False, True]


def test_faint_paths_are_removed_and_late_in_the_run_only_small_ones() -> None:
    rows = [(100.0, 100.0, 80.0, 80.0), (300.0, 100.0, 20.0, 20.0)]
    assert removed(ellipses(*rows, opacity=0.21)) == [False, False]
    assert removed(ellipses(*rows, opacity=0.19)) == [True, True]
    # 6400 square pixels are small until 80 % of the run.
    assert removed(ellipses(*rows, opacity=0.19), LATE) == [True, True]
    assert removed(ellipses(*rows, opacity=0.19), LAST) == [False, True]


def pair(side: float, color_step: float = 0.0) -> Scene:
    """Return a square and a younger one over it that is larger by half."""
    scene = ellipses((200.0, 150.0, side, side), (200.0, 150.0, 1.5 * side, 1.5 * side))
    return replace(scene, color=torch.tensor([[0.5] * 3, [0.5 + color_step] * 3], dtype=torch.float64))


def test_the_older_of_two_similar_paths_is_removed_if_it_is_small() -> None:
    assert removed(pair(100.0)) == [True, False]
    # A difference of 0.04 / sqrt(3) in each channel, times the opacity of 0.9, is below 0.05, 0.06 / sqrt(3) above.
    assert removed(pair(100.0, 0.04 / math.sqrt(3) / 0.9)) == [True, False]
    assert removed(pair(100.0, 0.06 / math.sqrt(3) / 0.9)) == [False, False]
    areas = [(40.0, LAST), (50.0, LAST), (140.0, LATE), (142.0, LATE), (220.0, EARLY), (225.0, EARLY)]
    assert [removed(pair(side, 0.0) if side < 200 else wide_pair(side), at)[0] for side, at in areas] == [
        True,
        False,
    ] * 3


def wide_pair(side: float) -> Scene:
    """Return a `pair` of equal size."""
    scene = pair(side)
    return with_points(scene, torch.stack([scene.points[0], scene.points[0]]))


def test_scores_are_those_of_a_plain_loop() -> None:
    generator = torch.Generator().manual_seed(3)
    corner = torch.rand(300, 2, generator=generator, dtype=torch.float64) * 60
    box = torch.cat([corner, corner + 1 + 20 * torch.rand(300, 2, generator=generator, dtype=torch.float64)], 1)
    level = torch.randint(0, 3, (300, 1), generator=generator)
    weighted_color = level * 0.3 + 0.03 * torch.rand(300, 3, generator=generator)
    scores = overlap_scores(box, weighted_color.double())
    expected = [plain_score(k, box.tolist(), weighted_color.double().tolist()) for k in range(300)]
    torch.testing.assert_close(scores, torch.tensor(expected, dtype=torch.float64), rtol=1e-12, atol=1e-12)
    assert (scores > 0.5).any() and (scores == 0.0).any()
    assert overlap_scores(box[:0], weighted_color[:0].double()).shape == (0,)


def plain_score(k: int, box: list[list[float]], weighted_color: list[list[float]]) -> float:
    left, top, right, bottom = box[k]
    score = 0.0
    for j in range(k + 1, len(box)):
        width = min(right, box[j][2]) - max(left, box[j][0])
        height = min(bottom, box[j][3]) - max(top, box[j][1])
        share = max(width, 0.0) * max(height, 0.0) / ((right - left) * (bottom - top))
        difference = math.dist(weighted_color[k], weighted_color[j])
        if share > 0.1 and difference < 0.05:
            score += share / (1 / (1 + math.exp(-100 * difference)) + 0.01)
    return score


# Regions


def plain_centers(error: NDArray[np.float64], count: int) -> list[tuple[float, float]]:
    """Apply the rule of `region_centers` pixel by pixel."""
    error = np.where(error < 0.05, 0.0, error)
    bins = sorted(set(np.quantile(error, np.linspace(0, 1, 200)).tolist()))[1:-1]
    level = {(y, x): sum(value >= b for b in bins) for (y, x), value in np.ndenumerate(error)}
    centers = []
    for _ in range(count):
        present = [value for value in level.values() if value > 0]
        if not present:
            break
        top = max(sorted(set(present)), key=lambda value: value * present.count(value))
        near = {pixel for pixel, value in level.items() if value > 0 and top - 1 <= value <= top + 3}
        component = max(plain_components(near), key=len)
        mean_y, mean_x = (sum(pixel[axis] for pixel in component) / len(component) for axis in (0, 1))
        y, x = min(component, key=lambda pixel: ((pixel[0] - mean_y) ** 2 + (pixel[1] - mean_x) ** 2, pixel))
        centers.append((x + 0.5, y + 0.5))
        level.update(dict.fromkeys(component, 0))
    return centers


def plain_components(pixels: set[tuple[int, int]]) -> list[list[tuple[int, int]]]:
    """Return the components connected by sides, in the order of their first pixels."""
    left, components = set(pixels), []
    for start in sorted(pixels):
        if start not in left:
            continue
        left.remove(start)
        component, ahead = [], [start]
        while ahead:
            y, x = ahead.pop()
            component.append((y, x))
            neighbours = {(y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)} & left
            left -= neighbours
            ahead += neighbours
        components.append(component)
    return components


@pytest.mark.parametrize("seed", range(4))
def test_regions_are_those_of_a_plain_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    error = rng.random((17, 26)).cumsum(0).cumsum(1) % 1.7 * rng.integers(0, 2, (17, 26))
    centers = region_centers(error, 30)
    assert centers.tolist() == [list(center) for center in plain_centers(error, 30)]
    assert len({tuple(center) for center in centers.tolist()}) == len(centers) > 5


def test_the_centre_of_the_larger_error_comes_first() -> None:
    y, x = np.mgrid[:60, :80] + 0.5
    error = np.exp(-((x - 15) ** 2 + (y - 15) ** 2) / 50) + np.exp(-((x - 55) ** 2 + (y - 40) ** 2) / 200)
    assert np.abs(region_centers(error, 1) - [[55.0, 40.0]]).max() < 1.0


@pytest.mark.parametrize("value", [0.0, 0.04, 1.0])
def test_an_even_error_has_no_regions(value: float) -> None:
    assert region_centers(np.full((8, 9), value), 3).shape == (0, 2)


# The policy


def picture() -> Tensor:
    """Draw discs over a ramp [200, 260, 3], so large that new paths, of 5.2 x 4 pixels, are not tiny."""
    y, x = torch.meshgrid(torch.arange(200) + 0.5, torch.arange(260) + 0.5, indexing="ij")
    image = torch.stack([x / 260, y / 200, 0.3 + 0.0 * x], -1)
    image[(x - 75).square() + (y - 60).square() < 1350] = torch.tensor([0.9, 0.2, 0.1])
    image[(x - 180).square() + (y - 120).square() < 1080] = torch.tensor([0.1, 0.3, 0.9])
    return image


def config_of(**settings: object) -> FitConfig:
    given = {
        "policy": "replacement",
        "curves": 100,
        "iterations": 60,
        "replace_gap": 10,
        "threads": 1,
        "shorten_gap": False,
    }
    return make_config(**{**given, **settings})


def test_nothing_at_the_start_comes_from_the_target() -> None:
    config, white = config_of(curves=500), torch.ones(3)
    dark, bright = (Replacement(torch.full((60, 80, 3), value), config).first_paths(white) for value in (0.0, 1.0))
    assert torch.equal(dark.points, bright.points) and torch.equal(dark.color, bright.color)
    assert dark.color.min() >= 0.5 and dark.color.max() <= 1 / (1 + math.exp(-1))
    torch.testing.assert_close(dark.opacity, torch.full((500,), 1 / (1 + math.exp(-1))))
    size = dark.points.amax(1) - dark.points.amin(1)
    # Two per cent of each side; the outermost control points of a circle lie on its box.
    torch.testing.assert_close(size, torch.tensor([[1.6, 1.2]]).expand(500, 2), rtol=1e-4, atol=0)
    center = dark.points[:, ::3].mean(1)
    assert (center > 0).all() and (center < torch.tensor([80.0, 60.0])).all()
    torch.testing.assert_close(center.mean(0), torch.tensor([40.0, 30.0]), rtol=0.1, atol=0)


@pytest.mark.parametrize("z_order", ["creation", "area"])
def test_as_many_paths_are_added_as_were_removed(z_order: str) -> None:
    counts = []
    watch = Watch(lambda progress: counts.append(progress.curve_count))
    result = fit(picture(), config_of(z_order=z_order), watch.part())
    # Removals after 10 and 30 of 60 iterations; one after 50 would have no addition before 55.
    assert set(counts[:10]) == set(counts[20:30]) == set(counts[40:]) == {100}
    assert len(set(counts[10:20])) == len(set(counts[30:40])) == 1
    assert 0 < counts[10] < 100
    assert set(result.scene.generation.tolist()) == {0, 1, 2}


def test_added_paths_have_the_colours_of_their_places() -> None:
    target, config = picture(), config_of(iterations=1000, replace_gap=100)
    policy = Replacement(target, config)
    start = policy.first_paths(torch.ones(3))
    faint = torch.where(torch.arange(100) < 30, 0.1, 0.9)
    population = Population(replace(start, opacity=faint), config, 130.0)
    error = (target - target.mean((0, 1))).square().sum(-1)
    assert not policy.update(population, 50, 1000, None, lambda scene: error)
    assert policy.update(population, 100, 1000, None, lambda scene: error)
    assert 50 < len(population) <= 70
    assert policy.update(population, 200, 1000, None, lambda scene: error)
    assert not policy.update(population, 400, 1000, None, lambda scene: error)
    assert len(population) == 100
    new = population.scene.select(population.scene.generation == 1)
    columns, rows = new.points[:, ::3].mean(1).long().unbind(-1)
    torch.testing.assert_close(new.color, target[rows, columns], rtol=0, atol=1e-5)
    torch.testing.assert_close(new.opacity, torch.full((len(new),), 1 / (1 + math.exp(-1))))
    # When the regions are used up, the rest is placed anywhere.
    assert (error[rows, columns] >= 0.05).float().mean() > 0.8


def test_age_decides_and_not_the_z_order() -> None:
    """Of two similar paths the older one is removed, whether it is below or above the other."""
    assert alike_after_a_removal(oldest=0) == [1]
    assert alike_after_a_removal(oldest=1) == [0]


def alike_after_a_removal(oldest: int) -> list[int]:
    """Return the generations that remain of two similar paths, 0 and 1, of which 1 is above 0."""
    scene = replace(wide_pair(40.0), generation=torch.tensor([0, 1]))
    config = config_of(replace_gap=100, iterations=1000)
    population = Population(scene, config, 200.0)
    population.serial = torch.tensor([oldest, 1 - oldest])
    policy = Replacement(torch.zeros(HEIGHT, WIDTH, 3), config)
    assert policy.update(population, 100, 1000, None, lambda scene: torch.zeros(HEIGHT, WIDTH))
    return population.live.generation.tolist()


def test_seed_decides_and_threads_do_not() -> None:
    scenes = [fit(picture(), config_of(**settings)).scene for settings in ({}, {"threads": 2}, {"seed": 1})]
    assert torch.equal(scenes[0].points, scenes[1].points)
    assert not torch.equal(scenes[0].points, scenes[2].points)
