"""Visible areas against supersampled masks; which paths are dropped, and how many renderings that takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scenes import blob_scene, circle, rectangle, with_points

from warpvec.fit.visibility import (
    CHANGE_MIN,
    RENDERINGS_MAX,
    canvas_areas,
    removal_changes,
    visible_areas,
    without_invisible,
)
from warpvec.geometry.circles import circle_points
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import LINEAR, RADIAL
from warpvec.geometry.scene import Scene
from warpvec.rendering.operator import render
from warpvec.svg.measure import draw
from warpvec.svg.quantize import quantize
from warpvec.svg.write import write_svg

HEIGHT, WIDTH = 40, 60
SAMPLES = 8


def _scene(*paths: torch.Tensor, opacity: list[float] | None = None) -> Scene:
    count = len(paths)
    return Scene.uniform(
        points=torch.stack(paths).float(),
        color=torch.rand(count, 3),
        opacity=torch.ones(count) if opacity is None else torch.tensor(opacity),
        background=torch.tensor([0.2, 0.4, 0.6]),
        generation=torch.zeros(count, dtype=torch.int64),
    )


def _blobs(seed: int, count: int) -> Scene:
    blobs = blob_scene(seed, count, HEIGHT, WIDTH)
    scene = _scene(*blobs.points)
    return replace(scene, color=blobs.color.float(), opacity=blobs.opacity.float())


def _outline(path: NDArray[np.float64]) -> list[tuple[float, float]]:
    """Return vertices along a closed path of cubics [P, 2], by Bernstein's formula."""
    t = np.linspace(0.0, 1.0, 40, endpoint=False)[:, None]
    pieces = [path[[k, k + 1, k + 2, (k + 3) % len(path)]] for k in range(0, len(path), 3)]
    curves = [(1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d for a, b, c, d in pieces]
    return [tuple(point) for point in np.concatenate(curves).tolist()]


def _masks(scene: Scene) -> NDArray[np.float64]:
    """Return the coverage [N, h, w] of the canvas by each path, from samples. Paths must not cross themselves."""
    masks = []
    for path in scene.points.double().numpy():
        large = Image.new("L", (WIDTH * SAMPLES, HEIGHT * SAMPLES))
        ImageDraw.Draw(large).polygon([(SAMPLES * x - 0.5, SAMPLES * y - 0.5) for x, y in _outline(path)], fill=1)
        samples = np.asarray(large, np.float64).reshape(HEIGHT, SAMPLES, WIDTH, SAMPLES)
        masks.append(samples.mean((1, 3)))
    return np.stack(masks)


@pytest.mark.parametrize("seed", range(4))
def test_areas_are_those_of_supersampled_masks(seed: int) -> None:
    scene = _blobs(seed, 12)
    masks, opacity = _masks(scene), scene.opacity.numpy().astype(np.float64)
    alphas = masks * opacity[:, None, None]
    above = np.stack([np.prod(1.0 - alphas[k + 1 :], axis=0) for k in range(len(alphas))])
    # The error of a mask's samples grows with the outline, which is some 80 px long.
    np.testing.assert_allclose(visible_areas(scene, HEIGHT, WIDTH), (alphas * above).sum((1, 2)), atol=1.5, rtol=0.01)
    np.testing.assert_allclose(canvas_areas(scene, HEIGHT, WIDTH), masks.sum((1, 2)), atol=1.5, rtol=0.01)


def test_areas_of_rectangles_are_exact() -> None:
    paths = (rectangle(2, 3, 12.5, 9), rectangle(-20, 30, 10, 80), rectangle(7, 3, 12, 20), rectangle(70, 0, 90, 9))
    scene = _scene(*paths, opacity=[0.5, 0.25, 0.5, 1.0])
    np.testing.assert_allclose(canvas_areas(scene, HEIGHT, WIDTH), [63.0, 100.0, 85.0, 0.0], rtol=1e-4)
    seen = [0.5 * (63.0 - 0.5 * 5 * 6), 0.25 * 100.0, 0.5 * 85.0, 0.0]
    np.testing.assert_allclose(visible_areas(scene, HEIGHT, WIDTH), seen, rtol=1e-4)


@pytest.mark.parametrize(("kind", "geometry"), [(LINEAR, (-90.0, 0.0, -80.0, 0.0)), (RADIAL, (30.0, 20.0, 9.0, 0.0))])
def test_areas_do_not_depend_on_the_paint(kind: int, geometry: tuple[float, ...]) -> None:
    """Beyond its end, where the shapes lie, the linear gradient shows its last colour alone."""
    scene = _blobs(3, 12)
    kinds, ends = torch.full((12,), kind, dtype=torch.int32), torch.tensor(geometry).expand(12, 4).contiguous()
    shaded = replace(scene, gradients=Gradients(kinds, ends, torch.rand(12, 3)))
    for measure in (visible_areas, canvas_areas):
        np.testing.assert_allclose(measure(shaded, HEIGHT, WIDTH), measure(scene, HEIGHT, WIDTH), rtol=1e-4, atol=1e-3)


def test_areas_of_no_paths_are_empty() -> None:
    scene = _blobs(0, 2).select(torch.zeros(2, dtype=torch.bool))
    assert canvas_areas(scene, HEIGHT, WIDTH).shape == visible_areas(scene, HEIGHT, WIDTH).shape == (0,)


# which paths are dropped


def _pixels(scene: Scene) -> bytes:
    return draw(write_svg(scene, WIDTH, HEIGHT), WIDTH, HEIGHT, transparent=scene.transparent).tobytes()


def _visible(scene: Scene) -> Scene:
    area, changes = visible_areas(scene, HEIGHT, WIDTH), removal_changes(scene, HEIGHT, WIDTH)
    return without_invisible(scene, area, changes, _pixels)


_LID = rectangle(10, 10, 30, 30)


@pytest.mark.parametrize("transparent", [False, True])
@pytest.mark.parametrize(
    ("path", "opacity", "stays"),
    [
        (circle(20, 20, 6), 1.0, False),  # under the lid
        (circle(20, 20, 13), 1.0, True),  # sticks out
        (circle(-50, 20, 20), 1.0, False),
        (circle(WIDTH + 0.02, 20, 0.015), 1.0, False),
        (circle(-5, 20, 5.4), 1.0, True),  # a sliver on the canvas
        (circle(45, 20, 6), 0.001, False),
        (circle(45, 20, 6), 0.01, True),  # two levels of 255
        (circle(45, 20, 0.05), 1.0, False),
        (circle(45.5, 20.5, 0.4), 1.0, True),
        (torch.full((12, 2), 45.0), 1.0, False),  # a point
    ],
)
def test_paths_that_are_hidden_off_the_canvas_or_transparent_are_dropped(
    path: torch.Tensor, opacity: float, stays: bool, transparent: bool
) -> None:
    scene = _scene(path, circle(40, 30, 5), _LID, opacity=[opacity, 0.7, 1.0])
    scene = replace(scene, color=torch.tensor([[1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    scene = replace(scene, transparent=transparent, background=torch.zeros(3) if transparent else scene.background)
    left = _visible(scene)
    assert len(left) == (3 if stays else 2)
    assert torch.equal(left.points, scene.points[0 if stays else 1 :])
    assert _pixels(left) == _pixels(scene)


@pytest.mark.parametrize("transparent", [False, True])
@pytest.mark.parametrize("radius", [0.5, 10.0, 18.0])
def test_paths_in_the_colour_below_them_are_dropped(radius: float, transparent: bool) -> None:
    scene = _scene(_LID, circle(20, 20, 13), circle(20, 20, 0.5 * radius), opacity=[1.0, 1.0, 0.6])
    color = torch.tensor([[1.0, 0.5, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    scene = replace(scene, color=color, transparent=transparent, background=torch.zeros(3))
    assert torch.equal(_visible(scene).points, scene.points[:2])


def test_a_palette_of_one_colour_leaves_no_path() -> None:
    """Viewers blend this colour with itself without a rounding error."""
    red = torch.tensor([1.0, 0.0, 0.0])
    scene = replace(_blobs(1, 40), color=red.expand(40, 3), background=red)
    assert len(_visible(scene)) == 0


def test_of_two_equal_paths_one_stays() -> None:
    """Either changes nothing alone, but both together do."""
    left = _visible(replace(_scene(_LID, _LID), color=torch.tensor([[1.0, 0.0, 0.0]] * 2)))
    assert len(left) == 1


@pytest.mark.parametrize("transparent", [False, True])
def test_changes_are_those_of_renderings_without_each_path(transparent: bool) -> None:
    scene = replace(_blobs(5, 12), transparent=transparent)
    changes = removal_changes(scene, HEIGHT, WIDTH)
    for row in range(12):
        rest = scene.select(torch.arange(12) != row)
        expected = torch.stack(
            [
                (render_scene(scene, matte) - render_scene(rest, matte)).square().sum()
                for matte in ((0.0, 1.0) if transparent else (None,))
            ]
        ).mean()
        torch.testing.assert_close(changes[row], expected, rtol=1e-3, atol=0.1 * CHANGE_MIN)


def render_scene(scene: Scene, matte: float | None) -> torch.Tensor:
    background = scene.background if matte is None else torch.full((3,), matte)
    return render(replace(scene, background=background), HEIGHT, WIDTH)


@pytest.mark.parametrize("seed", range(3))
def test_no_pixel_changes(seed: int) -> None:
    scene = _blobs(seed, 60)
    # Half of them are small, the others opaque, so that many are hidden or tiny.
    center = scene.points.mean(1, keepdim=True)
    small = torch.arange(60) % 2 == 0
    points = torch.where(small[:, None, None], center + 0.05 * (scene.points - center), scene.points)
    scene = quantize(replace(with_points(scene, points), opacity=torch.where(small, scene.opacity, 1.0)), 2)
    hidden = visible_areas(scene, HEIGHT, WIDTH) == 0.0
    left = _visible(scene)
    assert 0 < len(left) <= len(scene) - int(hidden.sum()) < len(scene)
    assert _pixels(left) == _pixels(scene)


# the number of renderings


def circles(count: int) -> Scene:
    center = torch.full((count, 2), 16.0)
    points = circle_points(center, torch.full((count,), 5.0), 4)
    color, opacity, generation = torch.rand(count, 3), torch.ones(count), torch.zeros(count).long()
    return Scene.uniform(points, color, opacity, torch.ones(3), generation)


def test_a_covered_disc_has_almost_no_visible_area() -> None:
    """Of two equal discs the upper one is fully visible, the lower one only through the upper one's soft edge."""
    area = visible_areas(circles(2), 32, 32)
    assert abs(float(area[1]) - 25 * torch.pi) < 0.1
    assert 0.0 < float(area[0]) < 0.1 * 25 * torch.pi


def test_paths_that_change_no_pixel_are_dropped() -> None:
    """Here a rendering depends on the twelve uppermost paths only."""
    scene = circles(16)
    area = torch.arange(16) * 0.05
    kept = without_invisible(scene, area, area, lambda some: bytes(str(some.color.tolist()[-12:]), "ascii"))
    assert torch.equal(kept.color, scene.color[4:])


def test_the_search_ends() -> None:
    """If every candidate changes a pixel, all stay, and not every one is drawn without."""
    scene, renderings = circles(1000), []

    def draw(some: Scene) -> bytes:
        renderings.append(len(some))
        return len(some).to_bytes(4, "big")

    assert len(without_invisible(scene, torch.linspace(0.001, 2.0, 1000), torch.linspace(0.0, 2.0, 1000), draw)) == 1000
    assert renderings[:2] == [1000, 500]
    assert len(renderings) == 1 + RENDERINGS_MAX
    renderings.clear()
    without_invisible(scene, torch.linspace(0.001, 2.0, 1000), torch.linspace(0.0, 2.0, 1000), draw, is_late=True)
    assert renderings == [1000, 500]


@pytest.mark.parametrize(("byte_count", "count"), [(12_000_000, 6), (36_000_000, 2), (192_000_000, 2)])
def test_large_photos_are_drawn_less_often(byte_count: int, count: int) -> None:
    """An image of 4 megapixels is drawn six times; larger ones once with all paths and once without the hidden ones."""
    renderings = []

    def draw(some: Scene) -> bytes:
        renderings.append(len(some))
        return len(renderings).to_bytes(1) + bytes(byte_count)  # every candidate changes the pixels

    hidden_but_one = torch.tensor([0.0] * 8 + [0.5])
    without_invisible(circles(9), hidden_but_one, torch.zeros(9), draw)
    assert len(renderings) == count
    assert renderings[:2] == [9, 1]


def test_visible_paths_are_not_tried() -> None:
    scene = circles(3)
    area = torch.tensor([5.0, 1.0, 2.0])
    assert without_invisible(scene, area, 2.0 * CHANGE_MIN * area, lambda _: b"never drawn") is scene
