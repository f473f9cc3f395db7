"""Coverage by Gaussians, seen as the image of a white path on black: closed forms, cuts, hidden paths."""

from __future__ import annotations

import torch
from backends import SCALAR, Backend
from oracles import precisions, render
from reference.splatting import Settings, gaussians, path_alpha, peak
from scenes import SceneTensors, circle, random_scene, straight
from splat_oracles import loop_scene, make_splat_renderer, off_the_band, white, white_wild, wild_path
from sweep import sweep
from torch import Tensor

SIZES = [(1, 1), (15, 17), (16, 16), (17, 15), (31, 33), (33, 31), (16, 130), (130, 16)]

SMALL = Settings(samples=5, lines=2)

EXACT = 1e-12
"""Tolerance in float64 for values of order 1; the worst error seen is below 1e-13."""


def coverage(
    scene: SceneTensors, settings: Settings, backend: Backend, dtype: torch.dtype = torch.float64, cut: float = 0.0
) -> Tensor:
    """Return the renderer's coverage [h, w] in float64."""
    image = render(scene, make_splat_renderer(scene, settings, backend, dtype, transmittance_min=cut)).double()
    assert torch.equal(image[..., 0], image[..., 1]) and torch.equal(image[..., 0], image[..., 2])
    return image[..., 0]


def expected(scene: SceneTensors, settings: Settings) -> Tensor:
    return path_alpha(gaussians(scene.points, settings), scene.opacity, scene.height, scene.width)[0]


@sweep(("height", "width"), SIZES)
def test_a_path_at_every_border(height: int, width: int, backend: Backend) -> None:
    scene = off_the_band(SMALL, white_wild, height, height, width, 0.7)
    want = expected(scene, SMALL)
    assert want.max() > 0.3
    torch.testing.assert_close(coverage(scene, SMALL, backend), want, rtol=0, atol=EXACT)


@sweep("opacity", [0.0, 0.0035, 0.0045, 0.03, 0.5, 0.998, 1.0])
def test_a_path_of_any_opacity(opacity: float, backend: Backend) -> None:
    scene = white(loop_scene(2, 1, 33, 50, 5).points[0], opacity, 33, 50)
    settings = Settings(17, 5, 5)
    want = expected(scene, settings)
    torch.testing.assert_close(coverage(scene, settings, backend), want, rtol=0, atol=EXACT)
    assert (want.max() > 0) == (opacity >= 1 / 255)


@sweep("opacity", [0.0039, 0.004, 0.3, 0.9989, 0.9991, 1.0])
@precisions
def test_a_point_in_closed_form(opacity: float, backend: Backend, dtype: torch.dtype) -> None:
    # 5 Gaussians on each of the 2 sides (standard deviations 0.3 and 0.75) and on each of the 2 lines (0.25).
    scene = white(circle(15.5, 16.5, 0.0), opacity, 33, 40)
    y, x = torch.meshgrid(torch.arange(33.0).double() - 16, torch.arange(40.0).double() - 15, indexing="ij")
    side = opacity * torch.exp(-0.5 * ((x / 0.3) ** 2 + (y / 0.75) ** 2))
    line = opacity * torch.exp(-0.5 * (x**2 + y**2) / 0.25**2)
    side, line = (torch.where(alpha < 1 / 255, 0.0, alpha).clamp(max=0.999) for alpha in (side, line))
    want = 1 - (1 - side) ** 10 * (1 - line) ** 10
    atol = 1e-12 if dtype == torch.float64 else 3e-6
    torch.testing.assert_close(coverage(scene, SMALL, backend, dtype), want, rtol=0, atol=atol)


def test_a_turned_or_mirrored_path_covers_the_turned_or_mirrored_pixels(backend: Backend) -> None:
    path = off_the_band(SMALL, white_wild, 5, 37, 37, 0.7).points[0]
    x, y = path.unbind(-1)
    before = coverage(white(path, 0.7, 37, 37), SMALL, backend)
    turned = coverage(white(torch.stack([37 - y, x], -1), 0.7, 37, 37), SMALL, backend)
    mirrored = coverage(white(torch.stack([37 - x, y], -1), 0.7, 37, 37), SMALL, backend)
    torch.testing.assert_close(turned, before.rot90(-1), rtol=0, atol=1e-11)
    torch.testing.assert_close(mirrored, before.flip(1), rtol=0, atol=1e-11)
    assert (before - before.flip(1)).abs().max() > 0.1


def test_what_is_dropped_is_dropped_per_gaussian(backend: Backend) -> None:
    # Twelve alphas of 0.9 / 255 at one pixel would add up to 0.04.
    settings = Settings(2, 4)
    scene = white(circle(5.5, 4.5, 0.0), 0.9 / 255, 9, 11)
    assert not coverage(scene, settings, backend).any()
    assert coverage(scene._replace(opacity=scene.opacity / 0.81), settings, backend).max() > 0.03


def test_everything_within_reach_is_drawn_up_to_the_cut(backend: Backend) -> None:
    # The smallest alpha drawn and the largest one dropped are close to 1 / 255, on either side.
    scene = white(straight((20.3, 20.2), (50.1, 32.7), (45.2, 40.8), (28.9, 38.1)), 0.3, 60, 70)
    values = peak(gaussians(scene.points, Settings(4, 1)), 0, scene.opacity, 60, 70).flatten(0, 1)
    single = (values >= 1 / 255).sum(0) == 1
    assert single.sum() > 20
    got = coverage(scene, Settings(4, 1), backend)
    torch.testing.assert_close(got[single], values.amax(0)[single].clamp(max=0.999), rtol=0, atol=EXACT)
    none = (values < 1 / 255).all(0)
    assert none.sum() > 20 and not got[none].any()


@precisions
def test_stacked_gaussians_come_near_to_one_and_no_further(backend: Backend, dtype: torch.dtype) -> None:
    scene = white(circle(24.0, 16.0, 3.0), 1.0, 33, 50)
    got = coverage(scene, Settings(), backend, dtype)
    assert got.max() <= 1.0 and got[16, 24] > 0.98
    assert got.min() == 0.0


def test_single_precision(backend: Backend) -> None:
    scene, settings = white_wild(3, 60, 70, 0.6), Settings(20, 9)
    error = (coverage(scene, settings, backend, torch.float32) - expected(scene, settings)).abs()
    # An alpha that rounding moves across the cut changes by 1 / 255.
    assert error.max() < 1.1 / 255
    assert (error > 2e-5).double().mean() < 2e-3


def test_thin_gaussians_in_single_precision(backend: Backend) -> None:
    # 300 px long and 0.75 px wide: the quadratic form is a difference of large numbers.
    path = straight((-400.0, -290.0), (800.0, 640.0), (810.0, 640.0), (-390.0, -290.0))
    scene = white(path, 0.8, 60, 70)
    settings = Settings(5, 2)
    error = (coverage(scene, settings, backend, torch.float32) - expected(scene, settings)).abs()
    assert error.max() < 1.1 / 255
    assert (error > 1e-4).double().mean() < 2e-2


def test_what_lies_behind_a_covered_tile_is_skipped(backend: Backend) -> None:
    # Three covers reduce the transmittance below 1e-4 in the left tile, and hardly in the right. Scalar lanes on the
    # CPU see one pixel and not its tile, so they skip nothing.
    below, cover = wild_path(8, 16, 32), circle(8.0, 8.0, 14.0)
    scene = random_scene(9, 4, 16, 32)._replace(points=torch.stack([below, cover, cover, cover]))
    scene = scene._replace(opacity=torch.ones(4, dtype=torch.float64))
    settings = Settings(32, 20)
    alone = path_alpha(gaussians(scene.points, settings), scene.opacity, 16, 32)
    left_over = (1 - alone[1:]).prod(0)
    assert (left_over[:, :16] < 1e-4).all() and (left_over[:, 16:] > 0.5).any()
    assert (alone[0, :, :16] > 0.1).any() and (alone[0, :, 16:] > 0.1).any()
    full, cut = (
        render(scene, make_splat_renderer(scene, settings, backend, transmittance_min=least)) for least in (0, 1e-4)
    )
    torch.testing.assert_close(cut, full, rtol=0, atol=1e-4)
    assert torch.equal(cut[:, 16:], full[:, 16:])
    assert torch.equal(cut[:, :16], full[:, :16]) == (backend == SCALAR)
