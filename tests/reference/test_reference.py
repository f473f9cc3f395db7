"""The reference against closed forms, brute force and finite differences."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
import torch
from assertions import assert_grad_close, assert_grad_present, finite_difference
from reference_cases import EXACT, polygon_of, shoelace
from scenes import (
    ZOO,
    SceneTensors,
    ZooCase,
    blob_scene,
    circle,
    degenerate_scene,
    figure_eight,
    random_scene,
    rectangle,
)
from sweep import sweep
from torch import Tensor

from reference import coverage_stack, mean_squared_error, removal_cost, render
from reference.compositing import composite
from reference.coverage import coverage, signed_coverage, supersampled_coverage, supersampled_winding, winding_number
from reference.flattening import flatten, uniform_counts

DIFFERENTIABLE = [case for case in ZOO if case.differentiable and len(case.scene.points)]


def gradient(f: Callable[[Tensor], Tensor], x: Tensor) -> Tensor:
    leaf = x.clone().requires_grad_()
    return torch.autograd.grad(f(leaf), leaf)[0]


def weighted_sum(points: Tensor, scene: SceneTensors) -> Tensor:
    """Return a weighted sum of all pixels and channels of the scene as a function of its points."""
    generator = torch.Generator().manual_seed(1)
    weight = torch.randn(scene.height, scene.width, 3, generator=generator, dtype=torch.float64)
    return (render(points, *scene[1:], uniform_counts(points, 4)) * weight).sum()


def random_polygon(seed: int, vertex_count: int, height: int, width: int) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    size = torch.tensor([width, height], dtype=torch.float64)
    return torch.rand(vertex_count, 2, generator=generator, dtype=torch.float64) * size


# Coverage against closed forms


@pytest.mark.parametrize("box", [(2.25, 1.5, 7.75, 5.125), (3.2, 2.3, 3.9, 2.6), (-4.0, -1.0, 2.5, 30.0), (1, 1, 4, 3)])
def test_rectangle_is_the_product_of_its_overlaps(box: tuple[float, float, float, float]) -> None:
    left, top, right, bottom = box
    x, y = torch.arange(9, dtype=torch.float64), torch.arange(7, dtype=torch.float64)
    across = ((x + 1).clamp(max=right) - x.clamp(min=left)).clamp(min=0)
    down = ((y + 1).clamp(max=bottom) - y.clamp(min=top)).clamp(min=0)
    signed = signed_coverage(polygon_of(rectangle(*box), 3), 7, 9)
    torch.testing.assert_close(signed, down[:, None] * across, rtol=0, atol=EXACT)


def test_triangle_under_a_slope_of_one_half() -> None:
    signed = signed_coverage(torch.tensor([[0.0, 0.0], [4.0, 0.0], [0.0, 2.0]], dtype=torch.float64), 2, 4)
    want = torch.tensor([[1.0, 1.0, 0.75, 0.25], [0.75, 0.25, 0.0, 0.0]], dtype=torch.float64)
    torch.testing.assert_close(signed, want, rtol=0, atol=EXACT)


def test_triangle_inside_one_pixel() -> None:
    triangle = torch.tensor([[1.2, 2.1], [1.9, 2.3], [1.4, 2.8]], dtype=torch.float64)
    want = torch.zeros(4, 3, dtype=torch.float64)
    want[2, 1] = 0.5 * (0.7 * 0.7 - 0.2 * 0.2)
    torch.testing.assert_close(signed_coverage(triangle, 4, 3), want, rtol=0, atol=EXACT)


def test_disc_has_the_area_of_its_polygon_and_nearly_of_the_circle() -> None:
    radius, vertex_count = 7.3, 50
    angle = torch.arange(vertex_count, dtype=torch.float64) * 2 * math.pi / vertex_count
    regular = torch.tensor([9.1, 10.2]) + radius * torch.stack([angle.cos(), angle.sin()], -1)
    area = signed_coverage(regular, 20, 18).sum().item()
    assert area == pytest.approx(vertex_count / 2 * radius**2 * math.sin(2 * math.pi / vertex_count), rel=EXACT)
    smooth = signed_coverage(polygon_of(circle(9.1, 10.2, radius), 64), 20, 18).sum().item()
    # Four cubics exceed the circle by up to 2.7e-4 of the radius.
    assert smooth == pytest.approx(math.pi * radius**2, rel=4e-4)


@pytest.mark.parametrize("seed", range(5))
def test_pixels_sum_to_the_shoelace_area(seed: int) -> None:
    polygon = random_polygon(seed, 11, 17, 33)
    torch.testing.assert_close(signed_coverage(polygon, 17, 33).sum(), shoelace(polygon), rtol=0, atol=EXACT)


# Coverage of self-intersecting paths


def test_figure_eight_has_lobes_of_both_signs_and_fills_both() -> None:
    polygon = polygon_of(figure_eight(1.0, 1.0, 13.0, 7.0))
    signed = signed_coverage(polygon, 8, 14)
    torch.testing.assert_close(signed, -signed.flip(1), rtol=0, atol=EXACT)
    assert signed[4, 1].item() == pytest.approx(1.0)
    assert coverage(signed).sum().item() == pytest.approx(36.0)
    torch.testing.assert_close(coverage(signed), supersampled_coverage(polygon, 8, 14), rtol=0, atol=0.01)


def test_double_wound_square_is_filled_once() -> None:
    square = rectangle(1.25, 1.0, 4.0, 4.0)[::3]
    signed = signed_coverage(torch.cat([square, square]), 5, 5)
    assert signed[2, 2].item() == pytest.approx(2.0)
    assert signed[2, 1].item() == pytest.approx(1.5)
    assert coverage(signed)[1:4, 1:4].eq(1.0).all()


@pytest.mark.parametrize("seed", range(3))
def test_signed_coverage_is_the_mean_winding_number_of_wild_polygons(seed: int) -> None:
    polygon = random_polygon(seed, 9, 7, 9) * 1.3 - 1.0
    sampled = supersampled_winding(polygon, 7, 9).mean(-1)
    # With 64 x 64 samples an edge along the grid has an error of up to 1/128, others far less; 9e-4 was seen.
    torch.testing.assert_close(signed_coverage(polygon, 7, 9), sampled, rtol=0, atol=3e-3)


@pytest.mark.parametrize("seed", range(3))
def test_coverage_of_simple_paths_is_the_non_zero_area(seed: int) -> None:
    scene = blob_scene(seed, 2, 10, 12)
    for polygon in flatten(scene.points, uniform_counts(scene.points, 4)):
        exact = coverage(signed_coverage(polygon, 10, 12))
        torch.testing.assert_close(exact, supersampled_coverage(polygon, 10, 12), rtol=0, atol=0.01)


def test_supersampling_counts_the_samples_of_a_rectangle() -> None:
    sampled = supersampled_coverage(polygon_of(rectangle(0.5, 0.25, 2.0, 1.0)), 2, 3, sample_count=4)
    want = torch.tensor([[0.375, 0.75, 0.0], [0.0, 0.0, 0.0]], dtype=torch.float64)
    torch.testing.assert_close(sampled, want, rtol=0, atol=0)


def test_winding_number_counts_turns_with_their_sign() -> None:
    point = torch.tensor([[5.0, 5.0], [9.5, 5.0], [20.0, 5.0]], dtype=torch.float64)
    for turns in (1, -1, 2, -3):
        polygon = polygon_of(circle(5.0, 5.0, 3.0, segment_count=8, turns=turns), 4)
        assert winding_number(polygon, point).tolist() == [turns, 0, 0]


# Gradients


def test_coverage_gradient_conventions() -> None:
    signed = torch.tensor([-1.5, -1.0, -0.25, 0.0, 0.25, 1.0, 1.5], dtype=torch.float64)
    assert gradient(lambda s: coverage(s).sum(), signed).tolist() == [0, -1, -1, 0, 1, 1, 0]


def test_moving_a_side_of_a_rectangle_changes_the_pixels_under_it() -> None:
    got = gradient(lambda polygon: signed_coverage(polygon, 6, 8)[2, 5], polygon_of(rectangle(2.25, 1.5, 5.75, 4.5)))
    # The right side runs from y = 1.5 to 4.5; the middle of row 2 is a third of the way down.
    want = torch.zeros(4, 2, dtype=torch.float64)
    want[1, 0], want[2, 0] = 2 / 3, 1 / 3
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)


@pytest.mark.parametrize("seed", range(4))
def test_signed_coverage_passes_gradcheck(seed: int) -> None:
    polygon = (random_polygon(seed, 7, 5, 6) * 1.4 - 1.0).requires_grad_()
    assert torch.autograd.gradcheck(lambda vertices: signed_coverage(vertices, 5, 6), polygon)


def test_render_passes_gradcheck_in_every_argument() -> None:
    scene = random_scene(5, 3, 5, 6, segment_count=2)
    leaves = tuple(tensor.clone().requires_grad_() for tensor in scene[:4])
    counts = uniform_counts(scene.points, 3)
    assert torch.autograd.gradcheck(lambda *tensors: render(*tensors, 5, 6, counts), leaves)


@sweep("case", ZOO)
def test_zoo_images_are_colours_and_gradients_finite(case: ZooCase) -> None:
    scene = case.scene
    image = render(*scene, uniform_counts(scene.points, 4))
    assert image.shape == (scene.height, scene.width, 3)
    assert image.min() >= -EXACT
    assert image.max() <= 1 + EXACT
    if len(scene.points):
        assert gradient(lambda points: weighted_sum(points, scene), scene.points).isfinite().all()


@pytest.mark.slow
@sweep("case", DIFFERENTIABLE)
def test_zoo_gradients_agree_with_finite_differences(case: ZooCase) -> None:
    scene = case.scene
    entries = torch.randperm(scene.points.numel())[:12].tolist()
    eps = 1e-6
    got = gradient(lambda points: weighted_sum(points, scene), scene.points).flatten()[entries]
    want = finite_difference(lambda points: weighted_sum(points, scene), scene.points, eps, entries)
    # The gradient is continuous but not smooth at pixel borders: errors of 2e-6 per entry there, 5e-8 elsewhere.
    assert_grad_close(got, want, rtol=1e-5, atol=1e-6, name=case.name)


@pytest.mark.parametrize("seed", range(3))
def test_degenerate_scenes_stay_finite(seed: int) -> None:
    scene = degenerate_scene(seed, 20, 17, 33)
    assert weighted_sum(scene.points, scene).isfinite()
    assert gradient(lambda points: weighted_sum(points, scene), scene.points).isfinite().all()


# Compositing and removal costs


def test_compositing_paints_later_paths_on_top() -> None:
    layer = torch.tensor([[[1.0, 0.5]], [[0.0, 1.0]]], dtype=torch.float64)
    color = torch.tensor([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], dtype=torch.float64)
    opacity = torch.tensor([1.0, 0.5], dtype=torch.float64)
    image = composite(layer, color, opacity, torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64))
    want = torch.tensor([[[1.0, 0.0, 0.0], [0.25, 0.5, 0.25]]], dtype=torch.float64)
    torch.testing.assert_close(image, want, rtol=0, atol=EXACT)


def test_no_paths_leave_the_background() -> None:
    scene = next(case.scene for case in ZOO if case.name == "no_paths")
    image = render(*scene, uniform_counts(scene.points, 4))
    assert image.eq(scene.background).all()


def test_removal_cost_of_one_pixel_by_hand() -> None:
    points = rectangle(-1.0, -1.0, 2.0, 2.0)[None].repeat(2, 1, 1)
    color, background = torch.tensor([[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]]).double(), torch.full((3,), 0.5).double()
    opacity, target = torch.tensor([1.0, 0.5]).double(), torch.full((1, 1, 3), 0.75).double()
    got = removal_cost(points, color, opacity, background, target, uniform_counts(points, 1))
    # Drawn: 0.5. Without row 0: 0.25. Without row 1: 1.
    want = torch.tensor([0.5**2 - 0.25**2, 0.25**2 - 0.25**2]).double()
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)


def test_removal_cost_is_the_quadratic_in_the_opacity() -> None:
    scene = random_scene(7, 5, 17, 20)
    counts = uniform_counts(scene.points, 6)
    target = torch.rand(17, 20, 3, dtype=torch.float64)
    stack = coverage_stack(scene.points, counts, 17, 20)

    def loss(opacity: Tensor) -> Tensor:
        return mean_squared_error(composite(stack, scene.color, opacity, scene.background), target)

    # The loss is a parabola in one opacity: two derivatives at o determine its value at 0.
    first = torch.autograd.functional.jacobian(loss, scene.opacity)
    second = torch.autograd.functional.hessian(loss, scene.opacity).diagonal()
    want = -scene.opacity * first + 0.5 * scene.opacity**2 * second
    got = removal_cost(*scene[:4], target, counts)
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)
    assert_grad_present(got[:, None], want[:, None], "removal_cost", min_ratio=0.999)


# Scenes


def test_scenes_depend_on_their_seed_alone() -> None:
    for make in (random_scene, degenerate_scene, blob_scene):
        first, again, other = make(3, 6, 20, 30), make(3, 6, 20, 30), make(4, 6, 20, 30)
        assert all(torch.equal(a, b) for a, b in zip(first[:4], again[:4], strict=True))
        assert not torch.equal(first.points, other.points)
        assert first.points.dtype == torch.float64


@pytest.mark.parametrize("seed", range(5))
def test_blobs_are_smooth_and_turn_once_about_a_point_inside(seed: int) -> None:
    scene = blob_scene(seed, 20, 64, 64)
    anchor, leaving, arriving = scene.points[:, ::3], scene.points[:, 1::3], scene.points[:, 2::3].roll(1, 1)
    torch.testing.assert_close(leaving + arriving, 2 * anchor)
    for polygon in flatten(scene.points, uniform_counts(scene.points, 16)):
        spoke = polygon - polygon[::16].mean(0)
        following = spoke.roll(-1, 0)
        cross = spoke[:, 0] * following[:, 1] - spoke[:, 1] * following[:, 0]
        turn = torch.atan2(cross, (spoke * following).sum(1))
        assert cross.min() > 0
        assert turn.sum().item() == pytest.approx(2 * math.pi)
