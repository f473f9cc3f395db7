"""Scenes and circles: shapes are checked, paths are selected, circles are round."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest
import torch
from curves import de_casteljau
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.bezier import bernstein
from warpvec.geometry.circles import circle_points, circle_sides
from warpvec.geometry.scene import Scene


def make_scene(count: int = 3, piece_count: int = 4, degree: int = 3, **fields: Tensor) -> Scene:
    tensors = {
        "points": torch.rand(count, degree * piece_count, 2),
        "color": torch.rand(count, 3),
        "opacity": torch.rand(count),
        "background": torch.rand(3),
        "generation": torch.arange(count),
    }
    return Scene.uniform(**{**tensors, **fields}, degree=degree)


@pytest.mark.parametrize(("count", "piece_count", "degree"), [(0, 4, 3), (1, 1, 1), (5, 7, 3), (5, 2, 5)])
def test_counts(count: int, piece_count: int, degree: int) -> None:
    scene = make_scene(count, piece_count, degree)
    assert len(scene) == count and scene.piece_count == piece_count and scene.degree == degree


def test_paths_are_cubic_unless_said() -> None:
    scene = make_scene()
    assert Scene.uniform(scene.points, scene.color, scene.opacity, scene.background, scene.generation).degree == 3


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


@pytest.mark.parametrize(("degree", "shape"), [(5, (3, 12, 2)), (5, (3, 0, 2)), (3, (3, 10, 2)), (4, (3, 6, 2))])
def test_points_that_are_no_whole_curves_are_named_with_the_degree(degree: int, shape: tuple[int, ...]) -> None:
    rule = (
        f"points must have shape [N, {degree} S, 2], S at least 1, for degree {degree}, got {list(shape)}; reshape it"
    )
    with pytest.raises(InputError) as caught:
        make_scene(degree=degree, points=torch.zeros(shape))
    assert str(caught.value).startswith(rule)


@pytest.mark.parametrize("degree", [0, -3])
def test_a_degree_is_positive(degree: int) -> None:
    scene = make_scene()
    with pytest.raises(InputError, match=f"degree must be at least 1, got {degree}"):
        Scene.uniform(scene.points, scene.color, scene.opacity, scene.background, scene.generation, degree)


def test_a_scene_does_not_change() -> None:
    scene = make_scene()
    with pytest.raises(FrozenInstanceError):
        scene.segments = torch.zeros(12, 3, 2)  # type: ignore[misc]


@pytest.mark.parametrize(
    "rows", [torch.tensor([2, 0]), torch.tensor([True, False, True]), torch.tensor([], dtype=torch.long)]
)
def test_select_takes_rows_of_every_field(rows: Tensor) -> None:
    scene = make_scene()
    picked = scene.select(rows)
    for name in ("points", "color", "opacity", "generation"):
        assert torch.equal(getattr(picked, name), getattr(scene, name)[rows])
    assert torch.equal(picked.background, scene.background)


def test_the_degree_goes_with_the_scene() -> None:
    scene = make_scene(degree=5, piece_count=2)
    others = [scene.select(torch.tensor([2, 0])), scene.scaled(2.0), scene.cpu(), scene.detach()]
    assert [other.degree for other in others] == [5] * 4


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


# Seen: 14.4 %, 3.25 %, 0.61 %, 0.058 % and 0.010 % of the radius.
@pytest.mark.parametrize(("degree", "error"), [(2, 0.15), (3, 0.033), (4, 0.0062), (5, 0.0006), (6, 0.00011)])
def test_sides_are_close_to_circles_and_even(degree: int, error: float) -> None:
    center = torch.tensor([[10.0, 20.0], [-3.0, 4.0]], dtype=torch.float64)
    radius = torch.tensor([5.0, 0.25], dtype=torch.float64)
    points = circle_sides(center, radius, degree)
    assert points.shape == (2, 2 * degree, 2) and points.dtype == torch.float64
    closed = torch.cat([points, points[:, :1]], 1)
    t = torch.linspace(0, 1, 501, dtype=torch.float64)
    for side in (0, 1):
        outline = de_casteljau(closed[:, side * degree : (side + 1) * degree + 1], t)
        unit = (outline - center[:, None]) / radius[:, None, None]
        assert (unit.norm(dim=-1) - 1).abs().max() < error
        even = torch.stack([(torch.pi * (side + t)).cos(), (torch.pi * (side + t)).sin()], -1)
        assert (unit - even).norm(dim=-1).max() < 2.2 * error


def test_no_other_inner_points_follow_the_circle_closer() -> None:
    points = circle_sides(torch.zeros(1, 2).double(), torch.ones(1).double(), 5)
    t = torch.linspace(0, 1, 1000, dtype=torch.float64)
    circle = torch.stack([(torch.pi * t).cos(), (torch.pi * t).sin()], -1)

    def squares(side: Tensor) -> float:
        return (de_casteljau(side, t) - circle).square().sum().item()

    side = points[:, :6]
    for j in range(1, 5):
        for axis in (0, 1):
            for step in (1e-4, -1e-4):
                moved = side.clone()
                moved[0, j, axis] += step
                assert squares(moved) > squares(side)


@pytest.mark.parametrize("degree", [1, 2, 5, 6])
def test_sides_start_and_end_opposite_on_the_circle_and_run_clockwise(degree: int) -> None:
    points = circle_sides(torch.tensor([[10.0, 20.0]]), torch.tensor([4.0]), degree)
    assert points.dtype == torch.float32
    assert points[0, 0].tolist() == [14.0, 20.0] and points[0, degree].tolist() == [6.0, 20.0]
    assert (points[0, 1:degree, 1] > 20).all() and (points[0, degree + 1 :, 1] < 20).all()


@pytest.mark.parametrize("degree", [1, 3, 5, 8])
def test_the_weights_of_control_points_are_those_of_repeated_interpolation(degree: int) -> None:
    points, t = torch.rand(1, degree + 1, 2, dtype=torch.float64), torch.linspace(0, 1, 21, dtype=torch.float64)
    torch.testing.assert_close(bernstein(degree, t) @ points, de_casteljau(points, t), rtol=0, atol=1e-15)
