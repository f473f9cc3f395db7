"""Binning of Gaussians: each tile lists the paths that are visible in it, in order, and few others."""

from __future__ import annotations

from dataclasses import dataclass

import torch
import warp as wp
from backends import VECTOR, Backend
from oracles import precisions, render
from reference.splatting import Gaussians, Settings, gaussians, path_alpha
from scenes import SceneTensors, circle, degenerate_scene, random_scene
from splat_oracles import make_splat_renderer, off_the_band, reference_image, white
from sweep import sweep
from torch import Tensor

from warpvec.kernels.constants import PARTIAL, SPLAT_GROUP, TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.paper.stages.splat_binning import SplatBinning
from warpvec.paper.stages.splatting import Splatting
from warpvec.rendering.launch import Launcher, start_warp
from warpvec.rendering.stages.binning import TileGrid

SIZES = [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (33, 31), (16, 400), (130, 16)]

SMALL = Settings(samples=9, lines=2)


@dataclass(frozen=True)
class Found:
    """Results of the stage: the paths of each tile in order, the classes and slots of the pairs, and group boxes."""

    lists: list[list[int]]
    classes: set[int]
    slots: list[int]
    group_box: Tensor


def bin_paths(scene: SceneTensors, settings: Settings, backend: Backend, dtype: torch.dtype, threads: int = 2) -> Found:
    start_warp()
    lanes, launch = make_lanes(backend.lane_width, wp.dtype_from_torch(dtype)), Launcher(backend.device, threads)
    grid = TileGrid(scene.height, scene.width)
    splatting = Splatting(launch, lanes, settings.samples, settings.lines, settings.degree, True, False)
    points, opacity = (value.to(backend.device, dtype).contiguous() for value in (scene.points, scene.opacity))
    splatting.run(points, wp.from_torch(opacity.repeat_interleave(settings.lines + 2)))
    binning = SplatBinning(launch, lanes, grid, settings.samples)
    binning.bin_splats(splatting, len(scene.points))
    first, pairs = binning.tile_first_hit.numpy(), binning.hit_pair.numpy()
    path, slot, kind = (array.numpy() for array in (binning.pair_path, binning.pair_slot, binning.pair_class))
    hits = [pairs[first[tile] : first[tile + 1]].tolist() for tile in range(grid.count)]
    boxes = torch.from_numpy(binning.group_box.numpy().copy())
    rows = len(scene.points) * (settings.lines + 2)
    return Found(
        [[int(path[pair]) for pair in row] for row in hits],
        {int(kind[pair]) for row in hits for pair in row},
        [int(slot[pair]) for row in hits for pair in row],
        boxes[: rows * (binning.group_count + 1)].reshape(-1, settings.lines + 2, binning.group_count + 1, 4),
    )


def tile_any(mask: Tensor) -> Tensor:
    """Return which tiles [N, tiles] have a True among their pixels of ``mask`` [N, h, w]."""
    count, height, width = mask.shape
    rows, columns = -(-height // TILE), -(-width // TILE)
    padded = torch.zeros(count, rows * TILE, columns * TILE, dtype=torch.bool)
    padded[:, :height, :width] = mask
    return padded.reshape(count, rows, TILE, columns, TILE).any(4).any(2).flatten(1)


def shown(scene: SceneTensors, settings: Settings) -> Tensor:
    """Return which tiles [N, tiles] each path is visible in, by the reference."""
    return tile_any(path_alpha(gaussians(scene.points, settings), scene.opacity, scene.height, scene.width) > 0)


def boxed(scene: SceneTensors, settings: Settings) -> Tensor:
    """Return which tiles [N, tiles] the box of a group of Gaussians reaches, by the reference."""
    left, top, right, bottom = group_boxes(gaussians(scene.points, settings), scene).unbind(-1)
    x, y = torch.arange(scene.width) + 0.5, torch.arange(scene.height) + 0.5
    within_x = (left[..., None] <= x) & (x <= right[..., None])
    within_y = (top[..., None] <= y) & (y <= bottom[..., None])
    covered = within_y[..., :, None] & within_x[..., None, :]
    return tile_any(covered.flatten(1, 2).any(1))


def group_boxes(found: Gaussians, scene: SceneTensors) -> Tensor:
    """Return left, top, right, bottom [N, rows, groups, 4] px of the area where a group may be visible."""
    spread = torch.diagonal(found.covariance, dim1=-2, dim2=-1)
    reach = (2 * (255 * scene.opacity).log().clamp(min=0)[:, None, None, None] * spread).sqrt()
    ends = [(found.mean - reach).split(SPLAT_GROUP, 2), (found.mean + reach).split(SPLAT_GROUP, 2)]
    low = torch.stack([part.amin(2) for part in ends[0]], 2)
    high = torch.stack([part.amax(2) for part in ends[1]], 2)
    return torch.cat([low, high], -1)


@sweep(("height", "width"), SIZES)
@precisions
def test_a_tile_lists_what_shows_in_it_in_order(height: int, width: int, backend: Backend, dtype: torch.dtype) -> None:
    scene = off_the_band(SMALL, random_scene, height, 12, height, width)
    found, visible, near = bin_paths(scene, SMALL, backend, dtype), shown(scene, SMALL), boxed(scene, SMALL)
    for tile, paths in enumerate(found.lists):
        assert paths == sorted(set(paths))
        assert set(visible[:, tile].nonzero().flatten().tolist()) <= set(paths)
        assert set(paths) <= set(near[:, tile].nonzero().flatten().tolist())
    assert found.classes <= {PARTIAL}
    assert len(set(found.slots)) == len(found.slots)
    assert visible.any()


@sweep("seed", range(3))
def test_degenerate_paths(seed: int, backend: Backend) -> None:
    scene = off_the_band(SMALL, degenerate_scene, seed, 20, 33, 50)
    found, visible = bin_paths(scene, SMALL, backend, torch.float64), shown(scene, SMALL)
    for tile, paths in enumerate(found.lists):
        assert set(visible[:, tile].nonzero().flatten().tolist()) <= set(paths)


@sweep("path_count", [0, 1, 2, 63, 64, 65])
def test_any_number_of_paths(path_count: int) -> None:
    scene = random_scene(path_count, path_count, 33, 31)
    found, visible = bin_paths(scene, SMALL, VECTOR, torch.float32, threads=3), shown(scene, SMALL)
    assert sum(map(len, found.lists)) >= visible.sum()
    for tile, paths in enumerate(found.lists):
        assert set(visible[:, tile].nonzero().flatten().tolist()) <= set(paths)


def test_boxes_of_groups_hold_the_pixels_their_gaussians_reach(backend: Backend) -> None:
    scene = random_scene(4, 6, 33, 50)
    got = bin_paths(scene, Settings(20, 2), backend, torch.float64).group_box
    boxes = group_boxes(gaussians(scene.points, Settings(20, 2)), scene)
    # Pixel centres are at j + 0.5: the first one at or after the low end, one past the last at or before the high end.
    size = torch.tensor([50, 33])
    low = (boxes[..., :2] - 0.5).ceil().clamp(min=0).minimum(size)
    high = ((boxes[..., 2:] - 0.5).floor() + 1).clamp(min=0).minimum(size)
    none = (low >= high).any(-1, keepdim=True)
    want = torch.cat([torch.where(none, size, low), torch.where(none, 0, high)], -1).int()
    assert torch.equal(got[:, :, :-1], want)
    assert torch.equal(got[:, :, -1, :2], want[..., :2].amin(2)) and torch.equal(
        got[:, :, -1, 2:], want[..., 2:].amax(2)
    )
    assert not none.all() and none.any()


@sweep("x", [13.2, 15.2, 16.0, 16.8, 18.9])
@sweep("y", [13.2, 15.2, 16.0, 18.9])
def test_a_dot_near_a_tile_corner(x: float, y: float, backend: Backend) -> None:
    # Standard deviations of at most 0.75 px (y) and 0.3 px (x): the dot reaches 2.5 px up and down, 1 px sideways.
    scene = white(circle(x, y, 0.01), 0.9, 33, 40)
    found = bin_paths(scene, SMALL, backend, torch.float64)
    want = shown(scene, SMALL)[0]
    assert [bool(paths) for paths in found.lists] == want.tolist()
    got = render(scene, make_splat_renderer(scene, SMALL, backend))
    torch.testing.assert_close(got, reference_image(scene, SMALL), rtol=0, atol=1e-12)


def test_invisible_paths_are_in_no_list(backend: Backend) -> None:
    points = torch.stack(
        [
            circle(20.0, 16.0, 5.0),  # of an opacity that is dropped
            circle(-40.0, 16.0, 5.0),
            circle(20.0, 80.0, 5.0),
            circle(1e30, 16.0, 5.0),
            torch.full((12, 2), torch.nan, dtype=torch.float64),
        ]
    )
    scene = random_scene(1, 5, 33, 40)._replace(points=points)
    scene = scene._replace(opacity=torch.tensor([0.0, 1, 1, 1, 1], dtype=torch.float64))
    found = bin_paths(scene, SMALL, backend, torch.float64)
    assert not any(set(paths) & {1, 2, 3, 4} for paths in found.lists)
    assert torch.equal(render(scene, make_splat_renderer(scene, SMALL, backend)), scene.background.expand(33, 40, 3))


def test_strips_shared_among_threads_give_the_same_lists() -> None:
    scene = random_scene(5, 60, 100, 70)
    runs = [bin_paths(scene, SMALL, VECTOR, torch.float32, threads) for threads in (1, 2, 3)]
    assert runs[0].lists == runs[1].lists == runs[2].lists and runs[0].slots == runs[1].slots == runs[2].slots
