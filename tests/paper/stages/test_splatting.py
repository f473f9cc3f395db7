"""Placing Gaussians: their positions and sizes, and the gradients that they pass to the control points."""

from __future__ import annotations

import torch
import warp as wp
from assertions import assert_grad_close
from backends import Backend
from oracles import adjoint, cotangent, precisions
from reference.compositing import composite
from reference.splatting import Gaussians, Settings, gaussians, path_alpha, row_weights
from scenes import SceneTensors, circle, degenerate_scene, random_scene
from splat_oracles import check_gradients, loop_scene, make_splat_renderer, off_the_band, switches
from sweep import sweep
from torch import Tensor

from warpvec.kernels.constants import COORDINATE_MAX
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.splatting import PLANES
from warpvec.paper.stages.splatting import Splatting
from warpvec.rendering.launch import Launcher, start_warp

COUNTS = [(2, 1), (3, 2), (4, 5), (15, 1), (16, 2), (17, 5), (33, 1)]
SHAPES = [(3, 2), (3, 3), (3, 4), (3, 5), (2, 2), (5, 2), (1, 6)]
"""Degree and number of pieces."""


def place(
    points: Tensor, settings: Settings, backend: Backend, dtype: torch.dtype = torch.float64, opacity: float = 0.8
) -> Tensor:
    """Return the planes [N, rows, PLANES, padded samples] of the Gaussians of ``points`` [N, P, 2], in float64."""
    start_warp()
    lanes, device = make_lanes(backend.lane_width, wp.dtype_from_torch(dtype)), backend.device
    switches = (settings.interior_gradient, settings.covariance_gradient)
    stage = Splatting(Launcher(device, 2), lanes, settings.samples, settings.lines, settings.degree, *switches)
    rows = wp.full(len(points) * (settings.lines + 2), opacity, dtype=lanes.dtype, device=device)
    stage.run(points.to(device, dtype).contiguous(), rows)
    shape = (len(points), settings.lines + 2, PLANES, stage.sample_stride)
    values = torch.from_numpy(stage.splats.numpy()[: shape[0] * shape[1] * shape[2] * shape[3]].copy())
    return values.reshape(shape).double()


def expected_planes(found: Gaussians, opacity: float = 0.8) -> Tensor:
    """Return the reference's [N, rows, PLANES, samples]: center, inverse covariance, half the visible box."""
    inverse = found.frame / found.scale[..., None, :] ** 2 @ found.frame.mT
    spread = torch.diagonal(found.covariance, dim1=-2, dim2=-1)
    reach = (2 * torch.tensor(255 * opacity, dtype=torch.float64).log() * spread).sqrt()
    values = [*found.mean.unbind(-1), inverse[..., 0, 0], inverse[..., 0, 1], inverse[..., 1, 1], *reach.unbind(-1)]
    return torch.stack(values, 2)


def check(points: Tensor, settings: Settings, backend: Backend, rtol: float = 1e-10, atol: float = 1e-9) -> None:
    got = place(points, settings, backend)[..., : settings.samples]
    torch.testing.assert_close(got, expected_planes(gaussians(points, settings)), rtol=rtol, atol=atol)


@sweep(("samples", "lines"), COUNTS)
def test_gaussians_of_any_number_of_samples_and_lines(samples: int, lines: int, backend: Backend) -> None:
    check(random_scene(samples, 3, 40, 50).points, Settings(samples, lines), backend)


@sweep(("degree", "pieces"), SHAPES)
def test_gaussians_of_any_degree_and_number_of_pieces(degree: int, pieces: int, backend: Backend) -> None:
    # With 15 samples, one is at the anchor between two pieces of a side.
    check(loop_scene(degree, 3, 40, 50, degree, pieces).points, Settings(15, 3, degree), backend)


def test_the_default_numbers_of_samples_and_lines(backend: Backend) -> None:
    check(random_scene(1, 2, 40, 50).points, Settings(), backend)


@sweep("seed", range(4))
def test_gaussians_of_degenerate_paths(seed: int, backend: Backend) -> None:
    # The tolerances allow for rounding of paths at 1e6 px, whose inverse covariances are up to 1e4.
    check(degenerate_scene(seed, 9, 40, 50).points, Settings(9, 3), backend, 1e-7, 1e-4)


def test_single_precision(backend: Backend) -> None:
    points = random_scene(2, 5, 400, 500).points
    got = place(points, Settings(20, 7), backend, torch.float32)[..., :20]
    # A centre at 500 px is accurate to 3e-5 px, and so the inverse square of a spacing of 0.1 px to some 5e-3.
    torch.testing.assert_close(got, expected_planes(gaussians(points, Settings(20, 7))), rtol=5e-3, atol=1e-3)


@precisions
def test_padding_and_what_is_not_finite_are_invisible(backend: Backend, dtype: torch.dtype) -> None:
    points = random_scene(3, 4, 40, 50).points
    points[1, 4, 1], points[3, 0, 0] = torch.nan, torch.inf
    planes = place(points, Settings(5, 2), backend, dtype)
    assert (planes[:, :, 5:, 5:] < 0).all()
    assert not (planes[[1, 3], :, 5:] >= 0).any()
    assert (planes[[0, 2], :, 5:, :5] > 0).all()


@precisions
def test_centers_beyond_the_farthest_coordinate_are_invisible(backend: Backend, dtype: torch.dtype) -> None:
    near, far = circle(20.0, 20.0, 5.0), circle(2 * COORDINATE_MAX, 20.0, 5.0)
    planes = place(torch.stack([near, far]), Settings(5, 2), backend, dtype)[..., :5]
    assert (planes[0, :, 5:] > 0).all() and (planes[1, :, 5:] < 0).all()


# Adjoints of positions and covariances


@sweep(("samples", "lines"), COUNTS)
def test_adjoint_of_any_number_of_samples_and_lines(samples: int, lines: int, backend: Backend) -> None:
    settings = Settings(samples, lines, covariance_gradient=True)
    scene = off_the_band(settings, random_scene, samples, 3, 20, 24)
    check_gradients(scene, settings, make_splat_renderer(scene, settings, backend), 1e-10)


@sweep(("degree", "pieces"), SHAPES)
@switches
def test_adjoint_of_any_degree_and_number_of_pieces(degree: int, pieces: int, interior: bool, covariance: bool) -> None:
    settings = Settings(9, 2, degree, interior, covariance)
    scene = off_the_band(settings, loop_scene, degree, 4, 20, 24, degree, pieces)
    check_gradients(scene, settings, make_splat_renderer(scene, settings), 1e-10)


def point_adjoint(scene: SceneTensors, settings: Settings, backend: Backend) -> Tensor:
    return adjoint(scene, make_splat_renderer(scene, settings, backend), cotangent(scene)).points


def test_interior_on_minus_off_is_what_the_lines_pass_to_the_points(backend: Backend) -> None:
    scene = off_the_band(Settings(9, 4), random_scene, 4, 2, 30, 34)
    on, off = (point_adjoint(scene, Settings(9, 4, interior_gradient=state), backend) for state in (True, False))
    adj_mean, mean, points = mean_adjoint(scene, Settings(9, 4))
    (want,) = torch.autograd.grad((mean[:, 1:-1] * adj_mean[:, 1:-1]).sum(), points)
    assert_grad_close(on - off, want, rtol=1e-11, atol=1e-13, name="lines")
    # Moving a path moves all its Gaussians equally.
    torch.testing.assert_close((on - off).sum(1), adj_mean[:, 1:-1].sum((1, 2)), rtol=1e-10, atol=1e-12)
    torch.testing.assert_close(off.sum(1), adj_mean[:, [0, -1]].sum((1, 2)), rtol=1e-10, atol=1e-12)


def mean_adjoint(scene: SceneTensors, settings: Settings) -> tuple[Tensor, Tensor, Tensor]:
    """Return dL/d(each center) [N, rows, samples, 2] by the reference, the centers, and the points they depend on."""
    points = scene.points.clone().requires_grad_()
    found = gaussians(points, settings)
    center = found.mean.detach().requires_grad_()
    layers = path_alpha(found._replace(mean=center), scene.opacity, scene.height, scene.width)
    image = composite(layers, scene.color, torch.ones_like(scene.opacity), scene.background)
    (adj_mean,) = torch.autograd.grad((image * cotangent(scene)).sum(), center)
    return adj_mean, found.mean, points


@sweep("lines", [1, 2, 5])
def test_the_two_sides_share_a_line_by_its_weight(lines: int, backend: Backend) -> None:
    # Both sides end at the middle anchor, at u = 1; a handle belongs to one side only.
    scene = random_scene(5, 1, 24, 24, 2)._replace(points=circle(12.3, 11.8, 7.0, 2)[None])
    settings = Settings(6, lines)
    got = point_adjoint(scene, settings, backend)[0]
    adj_mean = mean_adjoint(scene, settings)[0][0]
    u = torch.linspace(0.007, 0.993, 6, dtype=torch.float64)
    weight = row_weights(lines)
    handle = (3 * u * (1 - u) ** 2)[:, None]
    for point, share in ((1, 1 - weight), (5, weight)):
        want = (share[:, None, None] * handle * adj_mean).sum((0, 1))
        torch.testing.assert_close(got[point], want, rtol=1e-10, atol=1e-12)
