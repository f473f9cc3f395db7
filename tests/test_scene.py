"""The scene: shapes are checked, rows are picked, circles are round."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest
import torch
from torch import Tensor

from warpvec.errors import InputError
from warpvec.scene import Scene, circle_points


def make_scene(count: int = 3, segment_count: int = 4, **fields: Tensor) -> Scene:
    tensors = {
        "points": torch.rand(count, 3 * segment_count, 2),
        "color": torch.rand(count, 3),
        "opacity": torch.rand(count),
        "background": torch.rand(3),
        "generation": torch.arange(count),
    }
    return Scene(**{**tensors, **fields})


@pytest.mark.parametrize("count", [0, 1, 5])
@pytest.mark.parametrize("segment_count", [2, 3, 4, 7])
def test_counts(count: int, segment_count: int) -> None:
    scene = make_scene(count, segment_count)
    assert len(scene) == count and scene.segment_count == segment_count


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("points", (3, 11, 2)),
        ("points", (3, 12, 3)),
        ("points", (36, 2)),
        ("color", (3, 4)),
        ("color", (2, 3)),
        ("opacity", (3, 1)),
        ("opacity", (4,)),
        ("background", (1, 3)),
        ("generation", (2,)),
    ],
)
def test_shapes_that_do_not_agree_are_named_in_one_line(name: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError) as caught:
        make_scene(**{name: torch.zeros(shape)})
    message = str(caught.value)
    assert message.startswith(f"{name} must have shape") and str(list(shape)) in message and "\n" not in message


def test_a_scene_does_not_change() -> None:
    scene = make_scene()
    with pytest.raises(FrozenInstanceError):
        scene.points = torch.zeros(3, 12, 2)  # type: ignore[misc]


@pytest.mark.parametrize(
    "rows", [torch.tensor([2, 0]), torch.tensor([True, False, True]), torch.tensor([], dtype=torch.long)]
)
def test_select_takes_rows_of_every_field(rows: Tensor) -> None:
    scene = make_scene()
    picked = scene.select(rows)
    for name in ("points", "color", "opacity", "generation"):
        assert torch.equal(getattr(picked, name), getattr(scene, name)[rows])
    assert torch.equal(picked.background, scene.background)


def test_scaled_moves_points_alone() -> None:
    scene = make_scene()
    larger = scene.scaled(2.5)
    assert torch.equal(larger.points, 2.5 * scene.points)
    assert torch.equal(larger.opacity, scene.opacity) and torch.equal(larger.color, scene.color)


def test_detach_leaves_autograd() -> None:
    scene = make_scene(points=torch.rand(3, 12, 2, requires_grad=True), background=torch.rand(3, requires_grad=True))
    outside = scene.detach()
    assert not outside.points.requires_grad and not outside.background.requires_grad
    assert torch.equal(outside.points, scene.points)


def test_cpu_keeps_values(device: str) -> None:
    there = {name: getattr(make_scene(), name).to(device) for name in ("points", "color", "opacity", "background")}
    scene = make_scene(**there, generation=torch.arange(3).to(device))
    here = scene.cpu()
    assert {getattr(here, name).device.type for name in (*there, "generation")} == {"cpu"}
    assert torch.equal(here.points, there["points"].cpu())


@pytest.mark.parametrize(("segment_count", "error"), [(2, 2e-2), (3, 2e-3), (4, 3e-4), (7, 1e-5)])
def test_circle_points_lie_on_circles(segment_count: int, error: float) -> None:
    center = torch.tensor([[10.0, 20.0], [-3.0, 4.0]], dtype=torch.float64)
    radius = torch.tensor([5.0, 0.25], dtype=torch.float64)
    points = circle_points(center, radius, segment_count)
    assert points.shape == (2, 3 * segment_count, 2) and points.dtype == torch.float64
    closed = torch.cat([points, points[:, :1]], 1)
    t = torch.linspace(0, 1, 50, dtype=torch.float64)[:, None]
    for s in range(0, 3 * segment_count, 3):
        a, b, c, d = closed[:, s : s + 4, None].unbind(1)
        curve = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
        distance = (curve - center[:, None]).norm(dim=-1) / radius[:, None]
        # The 4/3 tan rule touches the circle at the ends and in the middle, and is outside it in between.
        assert distance.min() > 1 - 1e-12 and distance.max() < 1 + error
        assert distance[:, [0, -1]].sub(1).abs().max() < 1e-12


def test_circles_run_clockwise_on_the_screen() -> None:
    anchors = circle_points(torch.zeros(1, 2), torch.ones(1), 4)[0, ::3]
    torch.testing.assert_close(
        anchors, torch.tensor([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]), rtol=0, atol=1e-6
    )
