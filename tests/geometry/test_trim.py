"""Paths cut off at the edges of the canvas: the same picture inside, and no point outside."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from compound import split_into_loops
from numpy.typing import NDArray

from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene
from warpvec.geometry.trim import trim
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.resvg import rasterize
from warpvec.svg.write import write_svg

WIDTH, HEIGHT = 96, 64


def _scene(points: torch.Tensor) -> Scene:
    count = len(points)
    return Scene.uniform(
        points=points,
        color=torch.rand(count, 3),
        opacity=0.5 + 0.5 * torch.rand(count),
        background=torch.rand(3),
        generation=torch.arange(count) // 8,
    )


def _wild(count: int) -> Scene:
    """Tangled loops around points on and off the canvas."""
    center = torch.rand(count, 1, 2) * torch.tensor([1.4 * WIDTH, 1.4 * HEIGHT]) - 0.2 * torch.tensor([WIDTH, HEIGHT])
    return _scene(center + 20 * torch.randn(count, 12, 2))


def _wobbly(count: int) -> Scene:
    """Circles with a wobble, some of them partly or wholly off the canvas."""
    center = torch.rand(count, 2) * torch.tensor([1.3 * WIDTH, 1.3 * HEIGHT]) - 0.15 * torch.tensor([WIDTH, HEIGHT])
    points = circle_points(center, 4 + 12 * torch.rand(count), 4)
    return _scene(points + 1.5 * torch.randn(points.shape))


def _winding_numbers(points: torch.Tensor, at: NDArray[np.float64]) -> NDArray[np.int64]:
    """Winding numbers of a closed cubic path [3 S, 2], drawn as a fine polygon, around each point [K, 2]."""
    closed = np.concatenate([points.double().numpy(), points[:1].double().numpy()])
    t = np.linspace(0, 1, 200, endpoint=False)[:, None]
    cubics = (closed[k : k + 4] for k in range(0, len(points), 3))
    polygon = np.concatenate(
        [(1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d for a, b, c, d in cubics]
    )
    start, end = polygon[:, None], np.roll(polygon, -1, 0)[:, None]
    left = (end - start)[..., 0] * (at - start)[..., 1] - (at - start)[..., 0] * (end - start)[..., 1]
    up = (start[..., 1] <= at[:, 1]) & (end[..., 1] > at[:, 1]) & (left > 0)
    down = (start[..., 1] > at[:, 1]) & (end[..., 1] <= at[:, 1]) & (left < 0)
    return up.sum(0) - down.sum(0)


def _winding_number_sums(scene: Scene, at: NDArray[np.float64]) -> NDArray[np.int64]:
    """Winding numbers of a path of one or more loops."""
    (loops,) = split_into_loops(scene.segments, scene.structure)
    return sum((_winding_numbers(loop.flatten(0, 1), at) for loop in loops), np.zeros(len(at), np.int64))


def test_winding_numbers_inside_stay_and_points_are_inside() -> None:
    at = np.random.default_rng(0).random((300, 2)) * [WIDTH, HEIGHT]
    scene = _wild(30)
    for row in range(30):
        path = scene.select(torch.tensor([row]))
        trimmed = trim(path, HEIGHT, WIDTH)
        before = _winding_numbers(path.points[0], at)
        assert len(trimmed) or not before.any()
        if len(trimmed):
            np.testing.assert_array_equal(_winding_number_sums(trimmed, at), before)
            assert (trimmed.segments >= 0).all()
            assert (trimmed.segments <= torch.tensor([WIDTH, HEIGHT])).all()


# With two decimals handles have one, which moves an edge by up to 0.04 px or 10 levels; with three, by a tenth of that.
@pytest.mark.parametrize(("precision", "levels"), [(2, 10.0), (3, 3.5)])
def test_the_written_file_looks_the_same_and_keeps_to_the_canvas(precision: int, levels: float) -> None:
    def drawn(some: Scene) -> NDArray[np.float64]:
        # Eight times as large: resvg's own anti-aliasing tells equal edges apart by 30 levels of a pixel.
        text = write_svg(some, WIDTH, HEIGHT, precision=precision)
        return rasterize(text, 8 * WIDTH, 8 * HEIGHT).reshape(HEIGHT, 8, WIDTH, 8, 3).mean((1, 3))

    scene = quantize(_wobbly(60), precision)
    trimmed = trim(scene, HEIGHT, WIDTH)
    assert len(trimmed) < len(scene)
    assert np.abs(drawn(scene) - drawn(trimmed)).max() <= levels
    points = read_svg(write_svg(trimmed, WIDTH, HEIGHT, precision=precision).encode()).scene.segments
    assert points.min() >= -0.06
    assert (points.amax((0, 1)) <= torch.tensor([WIDTH, HEIGHT]) + 0.06).all()


def test_paths_inside_stay_and_paths_outside_go() -> None:
    center, radius = torch.tensor([[40.0, 30.0], [200.0, 30.0], [-9.0, 30.0]]), torch.tensor([8.0, 8.0, 8.0])
    scene = _scene(circle_points(center, radius, 4))
    trimmed = trim(scene, HEIGHT, WIDTH)
    assert len(trimmed) == 1
    assert torch.equal(trimmed.segments, scene.segments[:4])
    assert len(trim(scene.select(torch.tensor([1])), HEIGHT, WIDTH)) == 0
    assert len(trim(scene.select(torch.tensor([], dtype=torch.int64)), HEIGHT, WIDTH)) == 0


def test_a_path_that_covers_the_canvas_becomes_its_rectangle() -> None:
    scene = _scene(circle_points(torch.tensor([[48.0, 32.0]]), torch.tensor([500.0]), 4))
    trimmed = trim(scene, HEIGHT, WIDTH)
    corners = {tuple(point) for point in trimmed.segments[:, 0].tolist()}
    assert corners >= {(0.0, 0.0), (96.0, 0.0), (96.0, 64.0), (0.0, 64.0)}
    assert all(x in (0.0, 96.0) or y in (0.0, 64.0) for x, y in corners)


def test_an_edge_on_the_border_is_no_part_outside() -> None:
    corners = torch.tensor([[0.0, 0.0], [20.0, 0.0], [20.0, 10.0], [0.0, 10.0]])
    share = torch.tensor([0.0, 1 / 3, 2 / 3])[:, None]
    sides = [a + share * (b - a) for a, b in zip(corners, corners.roll(-1, 0), strict=True)]
    scene = _scene(torch.cat(sides)[None])
    assert torch.equal(trim(scene, HEIGHT, WIDTH).segments, scene.segments)
    outside = _scene(scene.points - torch.tensor([20.0, 0.0]))
    assert len(trim(outside, HEIGHT, WIDTH)) == 0
