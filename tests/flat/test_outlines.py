"""Tests of warpvec.flat.layers.outlines: what a layer covers beneath others, and how simple its hidden borders are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from flat_regions import Shape, box, disc, regions_of, split_regions
from scipy import ndimage

from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.curves.contours import signed_area
from warpvec.flat.layers.outlines import outlines
from warpvec.flat.layers.stacking import StackedLayer, stack
from warpvec.flat.regions.regions import Regions
from warpvec.flat.scene_building import scene_of
from warpvec.flat.simplification.outline_samples import control_points, cubic_points
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg
from warpvec.watch.watch import Watch

RED, GREEN, BLUE, WHITE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.6, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0)
CLEAR = (0.0, 0.0, 0.0, 0.0)


def error_of_file(regions: Regions) -> float:
    """PSNR in dB of the file of the scene of ``regions`` against the picture that they state, over white."""
    height, width = regions.label.shape
    mixed = regions.mixed()
    picture = mixed[..., :3] + 1.0 - mixed[..., 3:]
    rendering = draw(write_svg(scene_of(regions), width, height), width, height)
    return psnr(rendering, picture.astype(np.float32))


def areas(regions: Regions) -> list[list[float]]:
    return [[signed_area(loop.points) for loop in outlines(regions, layer)] for layer in stack(regions)]


def test_shape_is_filled_beneath_what_lies_on_it() -> None:
    regions = regions_of([(box(10, 10, 80, 80), RED), (disc(40, 40, 12), BLUE)])
    lower, upper = areas(regions)
    assert np.abs(lower) == pytest.approx([4900.0], rel=1e-3)
    assert np.abs(upper) == pytest.approx([np.pi * 144], rel=5e-3)


def test_once_the_time_is_up_all_parts_are_outlined_as_far_as_they_show() -> None:
    regions = regions_of([(box(10, 70, 18, 86), RED), (box(10, 10, 80, 60), RED), (disc(40, 40, 12), BLUE)])
    layer = StackedLayer(((1,), (2,)), frozenset({3}))
    hidden, shown = (
        [signed_area(loop.points) for loop in outlines(regions, layer, Watch(time_budget=budget))]
        for budget in (None, 0.0)
    )
    assert np.abs(hidden) == pytest.approx([128.0, 3500.0], rel=5e-3)
    assert sorted(np.abs(shown)) == pytest.approx([128.0, np.pi * 144, 3500.0], rel=1e-2)


def test_hole_stays_open_through_all_layers() -> None:
    shapes = [(box(6, 6, 90, 90), RED), (disc(48, 48, 30), BLUE), (disc(48, 48, 14), CLEAR)]
    lower, upper = areas(regions_of(shapes))
    assert len(lower) == len(upper) == 2
    assert lower[0] * lower[1] < 0
    hole = min(map(abs, lower))
    # Beneath the upper one, its colour must not come close to the hole.
    assert np.pi * 15.5**2 < hole < np.pi * 29**2
    assert min(map(abs, upper)) == pytest.approx(np.pi * 14**2, rel=0.01)


def test_only_what_two_layers_would_have_a_hole_for_lies_on_top() -> None:
    ring = [(disc(48, 48, 40), RED), (disc(48, 48, 30), WHITE), (disc(48, 48, 20), BLUE)]
    badge = [(disc(48, 48, 40), RED), (disc(48, 48, 30), BLUE), (disc(48, 48, 20), WHITE)]
    assert [len(loops) for loops in areas(regions_of(ring, canvas=WHITE))] == [2, 1]
    assert [len(loops) for loops in areas(regions_of(badge, canvas=WHITE))] == [1, 1, 1]


def test_hidden_border_keeps_on_the_right_side_of_a_hole() -> None:
    # The straight way beneath the disc leaves out its hole. The loop around it, alone, would fill the hole.
    shapes = [(box(10, 40, 86, 90), RED), (disc(48, 40, 26), BLUE), (disc(48, 28, 6), WHITE)]
    assert error_of_file(regions_of(shapes, canvas=WHITE)) > 40.0


def test_hidden_border_is_simple_and_hidden() -> None:
    regions = regions_of([(box(10.3, 30.2, 60.4, 85.1), BLUE), (disc(60, 30, 20), RED)])
    scene = scene_of(regions)
    lower = scene.select(torch.tensor([0]))
    # The sides of the box, and at most two more lines beneath the disc, which hides a corner.
    assert len(lower.segments) <= 6
    assert lower.structure.is_line is not None
    assert lower.structure.is_line.all()
    nodes = lower.segments[:, 0].numpy()
    from_disc = np.hypot(nodes[:, 0] - 60, nodes[:, 1] - 30)
    assert (from_disc < 19).sum() >= 2
    assert not ((from_disc > 19) & (from_disc < 25)).any()


def test_neighbours_leave_no_seam_and_no_fringe() -> None:
    shapes = [(box(10.25, 10.5, 50.25, 80.5), BLUE), (box(50.25, 10.5, 86.5, 80.5), RED), (disc(50, 80, 12.4), GREEN)]
    assert error_of_file(regions_of(shapes)) > 42.0


def test_belt_is_drawn_on_one_body() -> None:
    regions = split_regions(regions_of([(box(30.25, 8.5, 66.5, 88.5), RED), (box(20.25, 40.25, 76.5, 56.5), BLUE)]))
    body, belt = areas(regions)
    assert len(body) == len(belt) == 1
    assert abs(body[0]) == pytest.approx(36.25 * 80.0, rel=0.06)
    assert error_of_file(regions) > 42.0


def test_opaque_canvas_is_the_background() -> None:
    scene = scene_of(regions_of([(disc(40, 40, 20), RED)], canvas=GREEN))
    assert not scene.transparent
    assert scene.background.tolist() == pytest.approx(GREEN[:3])
    assert len(scene) == 1
    assert scene_of(regions_of([(disc(40, 40, 20), RED)])).transparent


def test_picture_without_shapes_is_an_empty_scene() -> None:
    scene = scene_of(regions_of([], canvas=GREEN))
    assert len(scene) == 0
    assert scene.segments.shape == (0, 3, 2)


def test_shape_that_is_cut_off_ends_at_the_border() -> None:
    (found,) = outlines((regions := regions_of([(disc(0, 48, 30), RED)])), stack(regions)[0])
    assert found.points.min() == 0.0
    assert abs(signed_area(found.points)) == pytest.approx(np.pi * 450, rel=0.01)


def test_an_oblique_line_narrower_than_a_pixel_is_one_outline() -> None:
    # Where it crosses from one column to the next, it has less than half of each pixel.
    regions = regions_of([(lambda x, y: (np.abs(x - 20.2 - 0.11 * y) <= 0.44) & (y > 8) & (y < 88), RED)])
    (layer,) = stack(regions)
    assert len(outlines(regions, layer)) == 1
    # Of a noisy line, the finer grid would show the noise.
    assert all(outline.scale == 1.0 for outline in outlines(replace(regions, noise=0.01), layer))


def test_a_wide_soft_shape_is_outlined_as_others_are() -> None:
    regions = regions_of([(box(20.4, 20.4, 70.6, 70.6), RED)])
    share = ndimage.gaussian_filter((regions.label == 1).astype(np.float32), 12.0)
    label = (share >= 0.5).astype(np.int32)
    soft = replace(regions, label=label, other=1 - label, share=np.maximum(share, 1.0 - share))
    assert all(outline.scale == 1.0 for outline in outlines(soft, stack(soft)[0]))


def test_dots_of_a_few_pixels_are_round_in_a_small_picture() -> None:
    for x, y, radius in ((8.3, 7.6, 1.3), (10.0, 10.5, 1.6), (12.7, 11.2, 2.2)):
        scene = scene_of(regions_of([(disc(x, y, radius), RED)], 24, 24), DRAWING.small_tolerance, is_fine=True)
        points = cubic_points(control_points(scene), np.linspace(0.0, 1.0, 9)).reshape(-1, 2)
        assert np.abs(np.hypot(*(points - [x, y]).T) - radius).max() < 0.1  # without the finer grid 0.6


def level_line(left: float, right: float, y: float, radius: float) -> Shape:
    return lambda px, py: np.hypot(px - np.clip(px, left, right), py - y) <= radius


def test_ends_of_thin_lines_are_round_in_a_small_picture() -> None:
    for left, right, y, radius in ((5.3, 15.2, 6.6, 1.25), (4.1, 16.1, 8.9, 1.6)):
        regions = regions_of([(level_line(left, right, y, radius), RED)], 24, 24)
        scene = scene_of(regions, DRAWING.small_tolerance, is_fine=True)
        points = cubic_points(control_points(scene), np.linspace(0.0, 1.0, 9)).reshape(-1, 2)
        beside = np.stack([points[:, 0] - np.clip(points[:, 0], left, right), points[:, 1] - y], 1)
        assert np.abs(np.hypot(*beside.T) - radius).max() < 0.2  # without the finer grid 0.5


def test_a_side_that_the_end_of_a_small_picture_cuts_stays_straight() -> None:
    regions = regions_of([(box(-4.0, -4.0, 10.4, 30.0), RED)], 24, 24)
    (layer,) = stack(regions)
    (outline,) = outlines(regions, layer, is_fine=True)
    side = outline.points[(outline.points[:, 0] > 5.0) & (outline.points[:, 1] > 0.3) & (outline.points[:, 1] < 23.7)]
    assert np.abs(side[:, 0] - 10.4).max() < 0.1  # 0.2 with paper beyond the end
