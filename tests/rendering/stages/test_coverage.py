"""The winding of the pixels of partial pairs, against the clipping reference, closed forms and the total area."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from backends import VECTOR, Backend
from oracles import Stages, precisions, run_stages
from reference.coverage import signed_coverage
from reference.flattening import flatten
from scenes import ZOO, ZooCase, circle, degenerate_scene, figure_eight, random_scene, rectangle, straight
from sweep import sweep
from torch import Tensor

from warpvec.kernels.constants import TILE

SIZES = [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (33, 31), (16, 130), (130, 16)]

EXACT = 1e-12
"""Tolerance for some hundred float64 operations on numbers of canvas size. The worst error seen is 5e-15, except for
paths of 1e6 px, where the reference itself has an error of 2e-11."""


def windings(stages: Stages) -> tuple[Tensor, Tensor]:
    """Return the windings of the kernels and of the reference, at the pixels of partial pairs on the canvas."""
    polygons = flatten(stages.points, stages.chord_counts)
    got = stages.winding()
    want = [in_tiles(signed_coverage(p, stages.grid.height, stages.grid.width), stages) for p in polygons]
    known = got.isfinite() & torch.stack(want).isfinite()
    return got[known].double(), torch.stack(want)[known]


def in_tiles(image: Tensor, stages: Stages) -> Tensor:
    """Cut [h, w] into [tiles, TILE, TILE], NaN beyond the canvas."""
    grid = stages.grid
    padded = torch.full((grid.rows * TILE, grid.columns * TILE), torch.nan, dtype=image.dtype)
    padded[: grid.height, : grid.width] = image
    return padded.reshape(grid.rows, TILE, grid.columns, TILE).transpose(1, 2).reshape(-1, TILE, TILE)


def winding_of(path: Tensor, height: int = 16, width: int = 16, backend: Backend = VECTOR) -> Tensor:
    """Return the winding [h, w] of a path that is partial in all of its tiles."""
    stages = run_stages(path[None], height, width, backend)
    tiles = stages.winding()[0].nan_to_num()
    image = tiles.reshape(stages.grid.rows, stages.grid.columns, TILE, TILE).transpose(1, 2)
    return image.reshape(stages.grid.rows * TILE, -1)[:height, :width]


@sweep(("height", "width"), SIZES)
@sweep("make", [random_scene, degenerate_scene])
def test_winding_of_random_paths(make: object, height: int, width: int, backend: Backend) -> None:
    stages = run_stages(make(height * width, 9, height, width).points, height, width, backend)
    got, want = windings(stages)
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)


@sweep("segment_count", [2, 3, 4, 7])
def test_winding_of_any_number_of_segments(segment_count: int, backend: Backend) -> None:
    got, want = windings(run_stages(random_scene(8, 20, 40, 50, segment_count).points, 40, 50, backend))
    assert len(got) > 1000
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)


@sweep("case", [case for case in ZOO if len(case.scene.points)])
@precisions
def test_winding_of_the_zoo(case: ZooCase, backend: Backend, dtype: torch.dtype) -> None:
    points = case.scene.points.to(dtype).double()
    stages = run_stages(points, case.scene.height, case.scene.width, backend, dtype)
    got, want = windings(stages)
    # Rounding moves an edge by eps times its coordinates; a few such errors add up at the rows and columns it crosses.
    reach = points.abs().max().item() + case.scene.width
    torch.testing.assert_close(got, want, rtol=0, atol=4 * torch.finfo(dtype).eps * reach)


def test_winding_of_rectangles_is_the_product_of_overlaps(backend: Backend) -> None:
    generator = np.random.default_rng(1)
    for _ in range(20):
        left, top = generator.uniform(-3, 20, 2)
        right, bottom = generator.uniform(20, 35, 2)
        got = winding_of(rectangle(left, top, right, bottom), 32, 32, backend)
        column, row = np.arange(32), np.arange(32)
        across = np.clip(np.minimum(right, column + 1) - np.maximum(left, column), 0, 1)
        down = np.clip(np.minimum(bottom, row + 1) - np.maximum(top, row), 0, 1)
        whole = [tile_is_whole(tile, left, top, right, bottom) for tile in range(4)]
        want = down[:, None] * across
        for tile in np.flatnonzero(whole):
            want[16 * (tile // 2) : 16 * (tile // 2) + 16, 16 * (tile % 2) : 16 * (tile % 2) + 16] = 0
        np.testing.assert_allclose(got.numpy(), want, atol=1e-14)


def tile_is_whole(tile: int, left: float, top: float, right: float, bottom: float) -> bool:
    """Return whether the edges are farther from the tile than the guard: it is then full and stores no winding."""
    x, y, guard = 16 * (tile % 2), 16 * (tile // 2), 1 / 32
    return left < x - guard and top < y and right > x + 16 + guard and bottom > y + 16


def test_a_diagonal_halves_its_pixels(backend: Backend) -> None:
    got = winding_of(straight((0, 0), (16, 16), (0, 16)), backend=backend)
    torch.testing.assert_close(
        got, torch.ones(16, 16).tril(-1).double() + 0.5 * torch.eye(16).double(), rtol=0, atol=1e-14
    )


@sweep("turns", [-2, -1, 1, 2])
def test_the_sign_is_that_of_the_turn_and_the_sum_is_the_area(backend: Backend, turns: int) -> None:
    path = circle(8.3, 7.9, 6.7, 4 * abs(turns), turns)
    stages = run_stages(path[None], 16, 16, backend)
    vertices, following = stages.vertices, stages.vertices.roll(-1, 0)
    area = 0.5 * (vertices[:, 0] * following[:, 1] - vertices[:, 1] * following[:, 0]).sum()
    winding = stages.winding()[0, 0]
    assert winding[8, 8].item() == pytest.approx(turns, abs=1e-14)
    assert winding.sum().item() == pytest.approx(area.item(), abs=1e-11)
    assert abs(area.item()) == pytest.approx(abs(turns) * torch.pi * 6.7**2, rel=0.02)


def test_lobes_of_a_figure_eight_have_opposite_signs_and_cancel_where_they_meet(backend: Backend) -> None:
    winding = winding_of(figure_eight(1.5, 3.5, 14.5, 12.5), backend=backend)
    # The lobes cross at (8, 8), a pixel corner. Moved by half a pixel, they cross at a pixel centre, and that pixel's
    # mean winding is zero.
    assert winding[7, 3] == pytest.approx(1) and winding[7, 12] == pytest.approx(-1)
    moved = winding_of(figure_eight(2.0, 4.0, 15.0, 13.0), backend=backend)
    assert moved[8, 8].item() == pytest.approx(0, abs=1e-14)


def test_what_lies_left_of_the_canvas_or_box_covers_what_is_right_of_it(backend: Backend) -> None:
    got = winding_of(straight((-500.0, 3.0), (9.5, 3.0), (9.5, 12.5), (-2000.0, 12.5)), backend=backend)
    want = torch.zeros(16, 16, dtype=torch.float64)
    want[3:12, :9], want[12, :9], want[3:12, 9], want[12, 9] = 1, 0.5, 0.5, 0.25
    torch.testing.assert_close(got, want, rtol=0, atol=1e-11)


@sweep("threads", [1, 3])
def test_strips_shared_among_threads(threads: int) -> None:
    stages = run_stages(random_scene(6, 65, 100, 40).points, 100, 40, threads=threads)
    assert stages.binning.strip_count > 128
    got, want = windings(stages)
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)


def test_the_extra_column_of_a_slot_takes_what_passes_to_the_next_tile(backend: Backend) -> None:
    # The edges run from a tile's last pixel columns into the next tile's first ones.
    points = straight((14.2, 1.1), (17.9, 9.7), (14.3, 30.2))[None]
    stages = run_stages(points, 32, 48, backend)
    got, want = windings(stages)
    torch.testing.assert_close(got, want, rtol=0, atol=EXACT)
