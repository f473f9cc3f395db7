"""Seeded scenes in float64: random ones, a zoo of degenerate ones, and smooth blobs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

ZOO_HEIGHT, ZOO_WIDTH = 33, 50
"""Canvas of the zoo: 3 x 4 tiles of 16 px, the last ones cut, with a width that no vector length divides."""


def seeded(seed: int = 0) -> torch.Generator:
    """Return a generator of random numbers with this seed."""
    return torch.Generator().manual_seed(seed)


def with_points(scene: Scene, points: Tensor, degree: int | None = None) -> Scene:
    """Return a uniform scene with other control points [N, M S, 2], M of which are ``degree`` (default: the same)."""
    degree = scene.degree if degree is None else degree
    structure = Structure.uniform(points.shape[0], points.shape[1] // degree, points.device)
    return replace(scene, segments=points.reshape(-1, degree, 2), structure=structure)


class SceneTensors(NamedTuple):
    """The arguments of ``reference.render`` in its order, without the chord counts."""

    points: Tensor
    """Control points [N, 3 S, 2] in pixels."""
    color: Tensor
    """Fill [N, 3] in [0, 1]."""
    opacity: Tensor
    """Fill opacity [N] in [0, 1]."""
    background: Tensor
    """Background colour [3] in [0, 1]."""
    height: int
    width: int


class ZooCase(NamedTuple):
    """A named scene. ``differentiable`` is False if an edge lies on a pixel border or a winding is at a kink."""

    name: str
    scene: SceneTensors
    differentiable: bool = True

    def __str__(self) -> str:
        return self.name


def random_scene(seed: int, path_count: int, height: int, width: int, segment_count: int = 4) -> SceneTensors:
    """Return distorted circles of all sizes; some cross the border of the canvas, and many cross themselves."""
    generator = seeded(seed)
    size = torch.tensor([width, height], dtype=torch.float64)
    center = (1.2 * _uniform(generator, path_count, 1, 2) - 0.1) * size
    radius = (0.5 * max(height, width)) ** _uniform(generator, path_count, 1, 1)
    noise = 0.5 * torch.randn(path_count, 3 * segment_count, 2, generator=generator, dtype=torch.float64)
    return _dressed(center + radius * (_unit_loop(segment_count) + noise), height, width, generator)


def degenerate_scene(seed: int, path_count: int, height: int, width: int, segment_count: int = 4) -> SceneTensors:
    """Return a random scene with each path made degenerate in one of several ways, drawn at random."""
    scene = random_scene(seed, path_count, height, width, segment_count)
    draws = torch.randint(len(_DEGENERATIONS), (path_count,), generator=seeded(seed))
    rows = [_DEGENERATIONS[draw](path) for draw, path in zip(draws.tolist(), scene.points, strict=True)]
    return scene._replace(points=torch.stack(rows)) if rows else scene


def blob_scene(seed: int, path_count: int, height: int, width: int) -> SceneTensors:
    """Return smooth simple paths, star-shaped about their centre: their coverage is the same under any fill rule."""
    generator = seeded(seed)
    size = torch.tensor([width, height], dtype=torch.float64)
    center = _uniform(generator, path_count, 1, 2) * size
    largest = 0.25 * min(height, width)
    radius = 2.0 + (largest - 2.0) * _uniform(generator, path_count, 1, 1) ** 2
    # A factor per anchor, shared with its two handles, keeps the tangent there at a right angle to the radius.
    swell = (0.75 + 0.5 * _uniform(generator, path_count, 4, 1)).repeat_interleave(3, 1).roll(-1, 1)
    angle = 2 * math.pi * _uniform(generator, path_count)
    turn = torch.stack([angle.cos(), angle.sin(), -angle.sin(), angle.cos()], -1).reshape(-1, 2, 2)
    return _dressed(center + radius * swell * (_unit_loop(4) @ turn), height, width, generator)


def circle(x: float, y: float, radius: float, segment_count: int = 4, turns: int = 1) -> Tensor:
    """Return control points [3 S, 2] of a circle run ``turns`` times, clockwise on the screen if positive."""
    return torch.tensor([x, y], dtype=torch.float64) + radius * _unit_loop(segment_count, turns)


def straight(*vertices: tuple[float, float]) -> Tensor:
    """Return control points [3 S, 2] of the polygon with S vertices; chords at equal steps of t are equally long."""
    start = torch.tensor(vertices, dtype=torch.float64)
    third = (start.roll(-1, 0) - start) / 3
    return torch.stack([start, start + third, start + 2 * third], 1).reshape(-1, 2)


def rectangle(left: float, top: float, right: float, bottom: float) -> Tensor:
    """Return control points [12, 2] of an axis-aligned rectangle, clockwise on the screen."""
    return straight((left, top), (right, top), (right, bottom), (left, bottom))


def figure_eight(left: float, top: float, right: float, bottom: float) -> Tensor:
    """Return control points [12, 2] of a bow tie in that box: its left lobe has winding +1, its right lobe -1."""
    return straight((left, top), (right, bottom), (right, top), (left, bottom))


def _unit_loop(segment_count: int, turns: int = 1) -> Tensor:
    step = 2 * math.pi * turns / segment_count
    angle = torch.arange(segment_count, dtype=torch.float64) * step
    anchor = torch.stack([angle.cos(), angle.sin()], -1)
    # The classical handle of a circular arc: 4/3 tan(angle / 4) radii along the tangent.
    tangent = 4 / 3 * math.tan(step / 4) * torch.stack([-angle.sin(), angle.cos()], -1)
    return torch.stack([anchor, anchor + tangent, (anchor - tangent).roll(-1, 0)], 1).reshape(-1, 2)


def _uniform(generator: torch.Generator, *shape: int) -> Tensor:
    return torch.rand(*shape, generator=generator, dtype=torch.float64)


def _dressed(points: Tensor, height: int, width: int, generator: torch.Generator) -> SceneTensors:
    """Return ``points`` with random colours, opacities from 0.2 to 1, and a random background."""
    count = len(points)
    color, opacity = _uniform(generator, count, 3), 0.2 + 0.8 * _uniform(generator, count)
    return SceneTensors(points, color, opacity, _uniform(generator, 3), height, width)


def _collapse_segment(path: Tensor) -> Tensor:
    return torch.cat([path[:1].expand(3, 2), path[:1], path[4:]])


def _collapse_handles(path: Tensor) -> Tensor:
    return path[::3].repeat_interleave(3, 0)


def _collapse_all(path: Tensor) -> Tensor:
    return path[:1].expand_as(path).clone()


def _flatten_to_line(path: Tensor) -> Tensor:
    return torch.stack([path[:, 0], path[:1, 1].expand(len(path))], -1)


def _round_to_integers(path: Tensor) -> Tensor:
    return path.round()


def _round_to_halves(path: Tensor) -> Tensor:
    return path.floor() + 0.5


def _round_to_tiles(path: Tensor) -> Tensor:
    return 16 * (path / 16).round()


def _move_far_away(path: Tensor) -> Tensor:
    return path + 1e6


def _stretch(path: Tensor) -> Tensor:
    return 1e3 * path


def _shrink(path: Tensor) -> Tensor:
    return path[:1] + 1e-4 * (path - path[:1])


_DEGENERATIONS = (
    _collapse_segment, _collapse_handles, _collapse_all, _flatten_to_line, _round_to_integers,
    _round_to_halves, _round_to_tiles, _move_far_away, _stretch, _shrink,
)  # fmt: skip


def _zoo_scene(*paths: Tensor, opacity: tuple[float, ...] | None = None) -> SceneTensors:
    points = torch.stack(paths) if paths else torch.zeros(0, 12, 2, dtype=torch.float64)
    scene = _dressed(points, ZOO_HEIGHT, ZOO_WIDTH, seeded(len(paths)))
    if opacity is not None:
        scene = scene._replace(opacity=torch.tensor(opacity, dtype=torch.float64))
    return scene


def _wild_path(seed: int) -> Tensor:
    """Return a path of medium size within the canvas that crosses itself."""
    noise = torch.randn(12, 2, generator=seeded(seed), dtype=torch.float64)
    return circle(24.3, 16.7, 9.0) + 4.0 * noise


def _collapsed_cases() -> list[ZooCase]:
    wild = _wild_path(1)
    return [
        ZooCase("no_paths", _zoo_scene()),
        ZooCase("handles_on_anchors", _zoo_scene(_collapse_handles(wild))),
        ZooCase("zero_length_edges", _zoo_scene(_collapse_segment(wild))),
        ZooCase("all_points_equal", _zoo_scene(_collapse_all(wild), circle(24.0, 17.0, 5.3))),
        ZooCase("all_points_on_a_pixel_corner", _zoo_scene(circle(16.0, 16.0, 0.0)), differentiable=False),
        ZooCase("horizontal_line", _zoo_scene(_flatten_to_line(wild)), differentiable=False),
        ZooCase("slanted_line", _zoo_scene(straight((3.2, 4.1), (20.6, 17.3), (38.0, 30.5), (20.6, 17.3))), False),
        ZooCase("tiny", _zoo_scene(circle(7.4, 9.3, 0.01), circle(20.5, 9.5, 0.3))),
        ZooCase("tiny_across_a_tile_corner", _zoo_scene(circle(16.0, 16.003, 0.02), circle(31.99, 16.0, 1e-4))),
        ZooCase("cusp_and_loop_in_a_segment", _zoo_scene(_looped_segment())),
    ]


def _looped_segment() -> Tensor:
    path = circle(24.0, 17.0, 9.0)
    path[1], path[2] = torch.tensor([5.0, 30.0]), torch.tensor([45.0, 40.0])
    path[7], path[8] = path[9], path[6]
    return path


def _grid_cases() -> list[ZooCase]:
    wild = _wild_path(2)
    return [
        ZooCase("edges_on_pixel_borders", _zoo_scene(rectangle(5, 3, 21, 12)), differentiable=False),
        ZooCase("edges_on_tile_borders", _zoo_scene(rectangle(16, 0, 32, 16)), differentiable=False),
        ZooCase("edges_on_canvas_borders", _zoo_scene(rectangle(0, 0, ZOO_WIDTH, ZOO_HEIGHT)), differentiable=False),
        ZooCase("axis_aligned_off_the_grid", _zoo_scene(rectangle(5.25, 3.7, 37.1, 21.4))),
        ZooCase("integer_points", _zoo_scene(_round_to_integers(wild))),
        ZooCase("half_integer_points", _zoo_scene(_round_to_halves(wild))),
        ZooCase("tile_corner_points", _zoo_scene(straight((16, 0), (32, 16), (16, 32), (0, 16)))),
        ZooCase("through_pixel_corners", _zoo_scene(straight((0, 0), (32, 32), (30.3, 32.4), (0.2, 3.4)))),
    ]


def _placed_cases() -> list[ZooCase]:
    near, far = 8.3, 20.0
    right, below = ZOO_WIDTH + far, ZOO_HEIGHT + far
    return [
        ZooCase("off_left", _zoo_scene(circle(-far, 16.2, near))),
        ZooCase("off_right", _zoo_scene(circle(right, 16.2, near))),
        ZooCase("off_top", _zoo_scene(circle(24.4, -far, near))),
        ZooCase("off_bottom", _zoo_scene(circle(24.4, below, near))),
        ZooCase("across_each_side", _zoo_scene(*(circle(x, y, near) for x, y in _SIDES))),
        ZooCase("larger_than_the_canvas", _zoo_scene(circle(24.7, 16.1, 100.0), circle(24.7, 16.1, 26.0))),
        ZooCase("far_away", _zoo_scene(_move_far_away(circle(20.0, 20.0, near)), circle(20.0, 20.0, near))),
        ZooCase("huge", _zoo_scene(circle(1e3, 16.5, 1e3 - 20.3), straight(*_HUGE_CORNERS))),
    ]


_SIDES = ((-2.1, 15.6), (ZOO_WIDTH + 1.3, 15.6), (24.4, -3.7), (24.4, ZOO_HEIGHT + 0.6), (ZOO_WIDTH, ZOO_HEIGHT))
_HUGE_CORNERS = ((-1e6, 5.1), (1e6, -3.3), (3.7, 1e6), (-1e6, 1e5))


def _wound_cases() -> list[ZooCase]:
    eight = figure_eight(6.3, 5.2, 41.7, 27.9)
    return [
        ZooCase("figure_eight", _zoo_scene(eight)),
        ZooCase("figure_eight_reversed", _zoo_scene(eight.flip(0).roll(1, 0))),
        ZooCase("counter_clockwise", _zoo_scene(circle(24.2, 16.9, 9.1, turns=-1))),
        ZooCase("double_loop", _zoo_scene(circle(24.2, 16.9, 9.1, turns=2))),
        ZooCase("double_loop_reversed", _zoo_scene(circle(24.2, 16.9, 9.1, turns=-2))),
    ]


def _stacked_cases() -> list[ZooCase]:
    cover = circle(25.0, 16.0, 80.0)
    under, over = _wild_path(3), _wild_path(4)
    return [
        ZooCase("hidden", _zoo_scene(under, cover, over, opacity=(0.7, 1.0, 0.6))),
        ZooCase("opaque", _zoo_scene(under, over, opacity=(1.0, 1.0))),
        ZooCase("transparent", _zoo_scene(under, over, opacity=(0.0, 0.0))),
        ZooCase("transparent_and_opaque", _zoo_scene(under, cover, over, opacity=(1.0, 0.0, 1.0))),
        ZooCase("same_path_thrice", _zoo_scene(under, under, under, opacity=(0.3, 1.0, 0.5))),
    ]


ZOO = [*_collapsed_cases(), *_grid_cases(), *_placed_cases(), *_wound_cases(), *_stacked_cases()]
"""All cases; use as ``@sweep("case", ZOO)``."""
