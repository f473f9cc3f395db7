"""Compositing against closed forms, at sizes on either side of tile, pixel and chunk boundaries."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from backends import Backend
from oracles import cotangent, inputs, make_renderer, precisions, reference_image, render
from reference.compositing import composite
from scenes import SceneTensors, random_scene, rectangle
from sweep import sweep
from torch import Tensor

from warpvec.kernels.constants import TRANSMITTANCE_MIN
from warpvec.rendering.stages.binning import TileGrid
from warpvec.rendering.stages.compositing import from_tiles, to_tiles


def covers(count: int, height: int, width: int, opacity: float | None = None) -> SceneTensors:
    """Return a scene of paths that cover the whole canvas and extend far beyond it."""
    scene = random_scene(count, count, height, width)
    points = rectangle(-100, -100, width + 100, height + 100).expand(count, 12, 2).contiguous()
    return scene._replace(
        points=points, opacity=scene.opacity if opacity is None else torch.full_like(scene.opacity, opacity)
    )


def rounding(dtype: torch.dtype, path_count: int) -> float:
    """Return the tolerance: each path's blend rounds twice, and the paths above it only reduce that error."""
    return 2 * path_count * torch.finfo(dtype).eps


@sweep(("height", "width"), [(1, 1), (15, 17), (16, 16), (31, 33), (5, 130)])
def test_tiles_hold_the_image_column_by_column(height: int, width: int) -> None:
    grid, image = TileGrid(height, width), torch.rand(height, width, 3)
    tiles = to_tiles(image, grid)
    assert tiles.shape == (grid.count, 3, 16, 16) and tiles.is_contiguous()
    for row, column in [(0, 0), (height - 1, width - 1), (height // 2, width // 3)]:
        tile = row // 16 * grid.columns + column // 16
        assert torch.equal(tiles[tile, :, column % 16, row % 16], image[row, column])
    assert tiles.sum().item() == pytest.approx(image.sum().item(), rel=1e-5)
    assert torch.equal(from_tiles(tiles, grid), image)


@precisions
@sweep("path_count", [0, 1, 2, 5])
def test_whole_covers_blend_in_order(backend: Backend, dtype: torch.dtype, path_count: int) -> None:
    scene = covers(path_count, 18, 35)
    want = scene.background
    for color, opacity in zip(scene.color, scene.opacity, strict=True):
        want = opacity * color + (1 - opacity) * want
    image = render(scene, make_renderer(scene, backend, dtype)).double()
    torch.testing.assert_close(image, want.expand(18, 35, 3), rtol=0, atol=rounding(dtype, path_count + 1))


@sweep(("height", "width"), [(16, 16), (16, 16 * 63), (16, 16 * 64), (16, 16 * 65), (1100, 20), (17, 1037)])
def test_tiles_shared_among_threads_are_each_drawn_once(height: int, width: int, backend: Backend) -> None:
    scene = random_scene(width, 3, height, width)
    renderer = make_renderer(scene, backend, threads=3)
    image = render(scene, renderer)
    torch.testing.assert_close(image, reference_image(scene, renderer), rtol=0, atol=1e-12)


def test_later_paths_are_on_top_whatever_their_place(backend: Backend) -> None:
    scene = covers(3, 20, 20, opacity=1.0)
    for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
        swapped = scene._replace(color=scene.color[order])
        image = render(swapped, make_renderer(scene, backend))
        assert torch.equal(image, scene.color[order[-1]].expand(20, 20, 3))


@sweep("threshold", [0.0, TRANSMITTANCE_MIN])
def test_an_opaque_cover_hides_what_is_below(backend: Backend, threshold: float) -> None:
    under = random_scene(3, 40, 33, 50)
    cover = covers(1, 33, 50, opacity=1.0)
    both = join(under, cover)
    renderer = make_renderer(both, backend, torch.float32, transmittance_min=threshold)
    # C + 1 (c - C) is c up to rounding.
    want = cover.color[0].float().expand(33, 50, 3)
    torch.testing.assert_close(render(both, renderer), want, rtol=0, atol=rounding(torch.float32, 1))


@precisions
def test_the_default_threshold_changes_the_image_by_at_most_itself(backend: Backend, dtype: torch.dtype) -> None:
    # n covers of opacity 0.7 have the transmittance 0.3 ** n: the threshold stops after the eighth.
    assert 0.3**8 < TRANSMITTANCE_MIN < 0.3**7
    scene = join(random_scene(3, 10, 33, 50), covers(9, 33, 50, opacity=0.7))
    exact = render(scene, make_renderer(scene, backend, dtype))
    cut = render(scene, make_renderer(scene, backend, dtype, transmittance_min=TRANSMITTANCE_MIN))
    difference = (exact.double() - cut.double()).abs().max().item()
    assert 0 < difference <= TRANSMITTANCE_MIN


def test_partial_paths_never_count_as_hiding(backend: Backend) -> None:
    # The canvas is one tile. Opaque paths cover each of its halves, but none covers all of it.
    scene = random_scene(5, 30, 16, 16)
    right, left = rectangle(8, -5, 20, 20), rectangle(-5, -5, 8, 20)
    scene = scene._replace(points=torch.stack([right, left]).repeat_interleave(15, 0), opacity=torch.ones(30).double())
    image = render(scene, make_renderer(scene, backend, transmittance_min=TRANSMITTANCE_MIN))
    want = torch.cat([scene.color[-1].expand(16, 8, 3), scene.color[14].expand(16, 8, 3)], 1)
    torch.testing.assert_close(image, want, rtol=0, atol=1e-13)


@sweep("turns", [1, 2, -1])
def test_coverage_is_the_size_of_the_winding_and_at_most_one(backend: Backend, turns: int) -> None:
    # A rectangle run |turns| times covers its border pixels by min(|turns| / 4, 1).
    box = rectangle(2.75, 2.75, 12.25, 12.25)
    path = torch.cat([box] * abs(turns)) if turns > 0 else torch.cat([box[:1], box[1:].flip(0)])
    scene = random_scene(1, 1, 16, 16, 4)._replace(points=path[None])
    image = render(scene, make_renderer(scene, backend))
    mask = torch.zeros(16, 16, dtype=torch.float64)
    mask[2:13, 2:13] = 0.25 * abs(turns)
    mask[3:12, 3:12] = 1
    mask[2, [2, 12]] = mask[12, [2, 12]] = 0.0625 * abs(turns)
    want = composite(mask[None], scene.color, scene.opacity, scene.background)
    torch.testing.assert_close(image, want, rtol=0, atol=1e-14)


@precisions
def test_a_deep_stack(dtype: torch.dtype) -> None:
    scene = random_scene(9, 250, 16, 20)
    renderer = make_renderer(scene, dtype=dtype)
    image = render(scene, renderer).double()
    # With opacities of at least 0.2, errors far below fade out. Coverage is accurate to some tens of eps here.
    torch.testing.assert_close(image, reference_image(scene, renderer), rtol=0, atol=1e2 * torch.finfo(dtype).eps)


def test_inputs_need_not_be_contiguous() -> None:
    scene = random_scene(2, 6, 20, 30)
    renderer = make_renderer(scene)
    dense = inputs(scene, renderer)
    names = ("segments", "color", "opacity", "background")
    strided = replace(dense, **{n: torch.stack([getattr(dense, n)] * 2, -1)[..., 0] for n in names})
    assert not strided.segments.is_contiguous()
    assert torch.equal(renderer.render(strided), render(scene, renderer))
    adj_image = cotangent(scene).transpose(0, 1).contiguous().transpose(0, 1)
    got, want = renderer.adjoint(strided, adj_image), renderer.adjoint(strided, adj_image.contiguous())
    assert torch.equal(got.segments, want.segments) and torch.equal(got.color, want.color)


def join(lower: SceneTensors, upper: SceneTensors) -> SceneTensors:
    """Return the paths of both scenes, over the background of the lower one."""
    fields: list[Tensor] = [torch.cat([a, b]) for a, b in zip(lower[:3], upper[:3], strict=True)]
    return SceneTensors(*fields, lower.background, lower.height, lower.width)
