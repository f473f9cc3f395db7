"""Binning against brute force: the winding of every pixel determines the pairs and their classes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import torch
from backends import Backend
from oracles import Stages, precisions, run_stages
from reference.coverage import signed_coverage
from reference.flattening import flatten
from scenes import ZOO, SceneTensors, ZooCase, circle, degenerate_scene, random_scene, rectangle
from sweep import sweep
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.kernels.constants import COLUMN_GUARD, EMPTY, FULL, PARTIAL, TILE
from warpvec.rendering.capacity import Counts
from warpvec.rendering.exact import ExactRenderer

Maker = Callable[[int, int, int, int], SceneTensors]
SIZES = [(1, 1), (15, 16), (16, 17), (17, 15), (31, 33), (33, 31), (48, 50), (16, 130), (130, 16)]


def tiles_of(image: Tensor) -> Tensor:
    """Cut an image [h, w] into tiles [rows, columns, TILE, TILE], NaN beyond the canvas."""
    height, width = ((size + TILE - 1) // TILE * TILE for size in image.shape)
    padded = torch.full((height, width), torch.nan, dtype=image.dtype)
    padded[: image.shape[0], : image.shape[1]] = image
    return padded.reshape(height // TILE, TILE, width // TILE, TILE).transpose(1, 2)


def pair_classes(stages: Stages) -> dict[tuple[int, int], int]:
    """Return the class of each pair by path and tile; pairs are numbered path by path, row by row, left to right."""
    binning = stages.binning
    first, box = binning.path_first_pair.numpy(), binning.path_tile_box.numpy()
    classes = binning.pair_class.numpy()
    found = {}
    for path in range(len(stages.points)):
        left, top, right, bottom = box[path]
        tiles = [row * stages.grid.columns + column for row in range(top, bottom) for column in range(left, right)]
        assert len(tiles) == first[path + 1] - first[path]
        found |= {(path, tile): int(classes[first[path] + k]) for k, tile in enumerate(tiles)}
    return found


def check_classes(stages: Stages) -> None:
    """Check that full pairs have one constant winding, empty or missing ones zero, and partial ones an edge nearby."""
    found = pair_classes(stages)
    for path, polygon in enumerate(flatten(stages.points, stages.chord_counts)):
        tiles = tiles_of(signed_coverage(polygon, stages.grid.height, stages.grid.width)).flatten(0, 1)
        for tile, winding in enumerate(tiles):
            winding, pair_class = winding[winding.isfinite()], found.get((path, tile), EMPTY)
            if pair_class == PARTIAL:
                assert touches(polygon, tile, stages), f"path {path}, tile {tile} is partial, no edge is near"
            elif pair_class == FULL:
                assert winding.abs().min() > 0.5 and (winding - winding[0]).abs().max() < 1e-9
            else:
                assert winding.abs().max() < 1e-9, (
                    f"path {path}, tile {tile} was dropped, winding {winding.abs().max()}"
                )


def touches(polygon: Tensor, tile: int, stages: Stages) -> bool:
    """Return whether an edge meets the tile grown by the guard, by clipping to the box (Liang and Barsky)."""
    corner = torch.tensor([tile % stages.grid.columns, tile // stages.grid.columns], dtype=polygon.dtype) * TILE
    start, edge = polygon, polygon.roll(-1, 0) - polygon
    guard = 2 * COLUMN_GUARD + 2e-6 * edge[:, :1].abs()
    low, high = corner - guard - start, corner + TILE + guard - start
    step = torch.where(edge == 0, 1e-300, edge)
    enter, leave = torch.minimum(low / step, high / step), torch.maximum(low / step, high / step)
    return bool((enter.amax(1).clamp(min=0) <= leave.amin(1).clamp(max=1)).any())


def check_lists(stages: Stages) -> None:
    """Check that each tile lists its pairs that are not empty, each once, in the order of the paths."""
    found, first = pair_classes(stages), stages.binning.tile_first_hit.numpy()
    listed = [stages.hit(hit)[:2] for hit in range(first[0], first[stages.grid.count])]
    want = sorted((pair for pair, pair_class in found.items() if pair_class != EMPTY), key=lambda pair: pair[::-1])
    assert first[0] == 0 and listed == want
    for tile in range(stages.grid.count):
        assert all(pair[1] == tile for pair in listed[first[tile] : first[tile + 1]])


def check_slots(stages: Stages) -> None:
    """Check that partial pairs have the slots 0, 1, 2 ... in order."""
    binning = stages.binning
    partial = binning.pair_class.numpy()[: binning.pair_count] == PARTIAL
    slots = binning.pair_slot.numpy()[: binning.pair_count + 1]
    np.testing.assert_array_equal(slots, np.concatenate([[0], partial.cumsum()]))
    assert binning.slot_count == partial.sum()


@sweep(("height", "width"), SIZES)
@sweep("make", [random_scene, degenerate_scene])
def test_pairs_of_random_paths(make: Maker, height: int, width: int, backend: Backend) -> None:
    points = make(height + width, 12, height, width).points
    stages = run_stages(points, height, width, backend)
    check_classes(stages)
    check_lists(stages)
    check_slots(stages)


@sweep("case", ZOO)
@precisions
def test_pairs_of_the_zoo(case: ZooCase, dtype: torch.dtype) -> None:
    stages = run_stages(case.scene.points, case.scene.height, case.scene.width, dtype=dtype)
    check_classes(stages)
    check_lists(stages)
    check_slots(stages)


def test_classes_in_closed_form() -> None:
    # The square's borders are at 8 and 72: tiles 0 and 4 are cut, tiles 1 to 3 are inside.
    stages = run_stages(rectangle(8, 8, 72, 72)[None], 80, 80)
    classes = pair_classes(stages)
    grid = [[classes[0, 5 * row + column] for column in range(5)] for row in range(5)]
    edge, inner = [PARTIAL] * 5, [PARTIAL, FULL, FULL, FULL, PARTIAL]
    assert grid == [edge, inner, inner, inner, edge]


def test_a_ring_is_empty_inside_and_costs_no_list_entry() -> None:
    # The inner square winds the other way. A bridge, run once in each direction, joins it to the outer one.
    outer, inner = rectangle(4, 4, 92, 92), rectangle(28, 28, 68, 68)
    reverse = torch.cat([inner[:1], inner[1:].flip(0)])
    closing = torch.stack([outer[0], outer[0] + (inner[0] - outer[0]) / 3, outer[0] + 2 * (inner[0] - outer[0]) / 3])
    back = torch.stack([inner[0], inner[0] + (outer[0] - inner[0]) / 3, inner[0] + 2 * (outer[0] - inner[0]) / 3])
    stages = run_stages(torch.cat([outer, closing, reverse, back])[None], 96, 96)
    classes = pair_classes(stages)
    assert classes[0, 2 * 6 + 2] == EMPTY and classes[0, 6 + 1] == PARTIAL
    assert stages.binning.tile_first_hit.numpy()[36] == sum(value != EMPTY for value in classes.values())


@sweep("path_count", [0, 1, 2, 63, 64, 65])
def test_paths_shared_among_threads(path_count: int) -> None:
    points = random_scene(path_count, path_count, 40, 40).points
    stages = run_stages(points, 40, 40, threads=3)
    check_lists(stages)
    check_slots(stages)


def test_a_tall_canvas_is_shared_by_strips() -> None:
    points = circle(8.0, 1050.0, 1040.0)[None]
    stages = run_stages(points, 2100, 16, threads=3)
    assert stages.binning.strip_count > 128
    check_classes(stages)


@sweep("value", [torch.nan, torch.inf, -torch.inf, 1e8, -1e30, 3e38])
@sweep("point", [3, 4])
@precisions
def test_a_path_that_is_not_finite_or_out_of_range_has_no_pairs(value: float, point: int, dtype: torch.dtype) -> None:
    scene = random_scene(4, 3, 33, 50)
    points = scene.points.clone()
    points[1, point, 0] = value
    stages = run_stages(points, scene.height, scene.width, dtype=dtype)
    first_pair = stages.binning.path_first_pair.numpy()
    assert first_pair[1] == first_pair[2] < first_pair[3]
    check_lists(stages)


def test_buffers_follow_a_scene_that_grows_and_shrinks() -> None:
    stages = run_stages(random_scene(1, 1, 40, 40).points, 40, 40)
    for path_count in (1, 40, 3, 90, 0, 2):
        points = random_scene(path_count, path_count, 40, 40).points
        again = run_on(stages, points)
        check_classes(again)
        check_lists(again)
        check_slots(again)


def run_on(stages: Stages, points: Tensor) -> Stages:
    """Run the same stages on other paths."""
    structure = Structure.uniform(points.shape[0], points.shape[1] // 3)
    stages.flattening.run(points.reshape(-1, 3, 2).contiguous(), structure)
    stages.binning.run(stages.flattening, len(points))
    return Stages(points, stages.grid, stages.flattening, stages.binning, stages.coverage)


@sweep(("path_count", "pair_count"), [(65_536, "68,719,476,736"), (5_000, "5,242,880,000")])
def test_more_pairs_than_32_bits_count_are_refused(path_count: int, pair_count: str, device: str) -> None:
    """In 32 bits the first sum would be 0, and the second a number that looks possible."""
    renderer = ExactRenderer(16_384, 16_384, device=device)
    points = rectangle(-9, -9, 16_400, 16_400).float().to(renderer.device).repeat(path_count, 1, 1)
    color, opacity, background = (
        torch.zeros(size, device=renderer.device) for size in ((path_count, 3), path_count, 3)
    )
    with pytest.raises(InputError, match=f"scene is too large for the renderer .* needs {pair_count} of at most"):
        renderer.render(Scene.uniform(points, color, opacity, background, opacity.long()))


def test_a_capacity_is_refused_if_the_pairs_could_be_more_than_32_bits_count(device: str) -> None:
    """A step with a capacity cannot read its counts, so it cannot tell a sum that wrapped around."""
    renderer = ExactRenderer(16_384, 16_384, device=device)
    points = rectangle(5, 5, 9, 9).float().to(renderer.device).repeat(5_000, 1, 1)
    color, opacity, background = (torch.zeros(size, device=renderer.device) for size in ((5_000, 3), 5_000, 3))
    renderer.set_capacity(Counts(100_000, 100_000, 100_000, 100_000))
    with pytest.raises(InputError, match="scene is too large for the renderer"):
        renderer.render(Scene.uniform(points, color, opacity, background, opacity.long()))
