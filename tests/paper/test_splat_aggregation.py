"""Interior Gradient Aggregation as a quadrature: the gradients of a circle's Gaussians in a smooth field.

Equation 4 of Vector Scaffolding: moving a region over an error field e gains the integral of grad e over its area,
O(r^2) for radius r, and that of e along its boundary, O(r). The sums over the samples approximate both without weights
because a Gaussian's size follows its spacing. Where the Gaussians are narrower than a pixel the pixels alias; there the
circle is drawn at several places within a pixel and averaged.
"""

from __future__ import annotations

import math

import pytest
import torch
from assertions import assert_grad_close
from backends import Backend
from oracles import adjoint
from reference.splatting import Gaussians, Settings, gaussians, path_alpha, row_weights
from scenes import SceneTensors, circle
from splat_oracles import make_splat_renderer, white
from torch import Tensor

WAVELENGTH = 1200.0
"""Wavelength of the field in pixels: about ten times the largest circle."""


def circle_scene(radius: float, opacity: float, offset: tuple[float, float] = (0.0, 0.0)) -> SceneTensors:
    """Return a circle in the middle of a canvas that contains all of it."""
    size = int(2 * radius) + 16
    return white(circle(size / 2 + offset[0], size / 2 + offset[1], radius), opacity, size, size)


def field(scene: SceneTensors, phase: float) -> Tensor:
    """Return dL/d(coverage) [h, w]: a sine of x with ``phase`` in the middle of the canvas."""
    x = torch.arange(scene.width, dtype=torch.float64) + 0.5 - scene.width / 2
    return torch.sin(2 * math.pi * x / WAVELENGTH + phase).expand(scene.height, -1)


def center_adjoint(scene: SceneTensors, settings: Settings, phase: float) -> tuple[Tensor, Gaussians]:
    """Return dL/d(center) [rows, samples, 2] of the only path, by the reference, and the Gaussians."""
    found = gaussians(scene.points, settings)
    center = found.mean.clone().requires_grad_()
    layer = path_alpha(found._replace(mean=center), scene.opacity, scene.height, scene.width)[0]
    (adj_center,) = torch.autograd.grad((layer * field(scene, phase)).sum(), center)
    return adj_center[0], found


def inner_cells(settings: Settings) -> Tensor:
    """Select the middle half of the samples, on lines with weights from 1/4 to 3/4: none is near a clamp."""
    w, u = row_weights(settings.lines), torch.linspace(0.007, 0.993, settings.samples, dtype=torch.float64)
    return ((w - 0.5).abs() <= 0.25)[:, None] & ((u - 0.5).abs() <= 0.25)


def weights(radius: float, settings: Settings, opacity: float) -> Tensor:
    """Return the x gradient of each inner cell, divided by the field's slope there and by the cell's area."""
    scene = circle_scene(radius, opacity)
    adj_center, found = center_adjoint(scene, settings, 0.0)
    k = 2 * math.pi / WAVELENGTH
    slope = k * torch.cos(k * (found.mean[0, ..., 0] - scene.width / 2))
    # Standard deviations are two thirds of the distances to the neighbours.
    area = (1.5 * found.scale[0]).prod(-1)
    return (adj_center[..., 0] / (slope * area))[inner_cells(settings)]


CELLS = [(16, Settings(16, 10)), (32, Settings(16, 10)), (32, Settings(32, 20)), (64, Settings(32, 20))]
"""Radii and settings whose inner Gaussians are wide enough for pixel sums to approximate integrals: 1.4 to 3 px."""


@pytest.mark.parametrize(("radius", "settings"), CELLS)
def test_an_inner_gaussian_weighs_the_slope_by_the_area_of_its_cell(radius: float, settings: Settings) -> None:
    # At low opacity neighbours hardly cover each other: the ideal weight 2 pi (2/3)^2 0.05 loses 10 % to that and 28 %
    # to the cut.
    found = weights(radius, settings, 0.05)
    assert len(found) >= 16
    assert found.mean().item() == pytest.approx(0.0905, rel=0.02)
    assert found.std() < 0.1 * found.mean()


@pytest.mark.parametrize("opacity", [0.05, 0.3])
def test_twice_the_samples_and_lines_have_the_same_weight_per_area(opacity: float) -> None:
    # At opacity 0.3 neighbours cover each other, by amounts that vary with their spacing: 7 % on 10 lines.
    coarse, fine = (weights(48, settings, opacity).mean() for settings in (Settings(16, 10), Settings(32, 20)))
    assert fine.item() == pytest.approx(coarse.item(), rel=0.02 if opacity == 0.05 else 0.08)


def exponent(radii: list[int], sums: list[float]) -> float:
    """Return the slope of the least-squares line through log(sums) over log(radii)."""
    x, y = torch.tensor(radii).double().log(), torch.tensor(sums).double().log()
    return float(((x - x.mean()) * (y - y.mean())).sum() / (x - x.mean()).square().sum())


def averaged_center_adjoint(radius: float, settings: Settings, places: int, phase: float) -> Tensor:
    """Return dL/d(center), averaged over ``places`` by ``places`` positions of the circle within a pixel."""
    offsets = [(i / places, j / places) for i in range(places) for j in range(places)]
    found = [center_adjoint(circle_scene(radius, 0.3, offset), settings, phase)[0] for offset in offsets]
    return torch.stack(found).mean(0)


@pytest.mark.slow
def test_the_area_gradient_grows_as_r_squared_and_the_boundary_gradient_at_most_as_r() -> None:
    """Use 16 samples and 10 lines, whose Gaussians are wide, and a field that is nowhere zero on the circles.

    Area: the length of the sum over the lines, which pulls the path as a whole. (The sum of the lengths grows as r
    too, because the outermost lines, close to the boundary, see the step there.) Boundary: the sum of the lengths over
    both sides. Gaussians have no floor, as in the released code: on 128 samples many are narrower than a pixel.
    """
    radii, area, boundary = [8, 16, 32], [], []
    for radius, places in zip(radii, (2, 2, 1), strict=True):
        found = averaged_center_adjoint(radius, Settings(16, 10), places, math.pi / 4)
        area.append(found[1:-1].sum((0, 1)).norm().item())
        boundary.append(found[[0, -1]].norm(dim=-1).sum().item())
    assert exponent(radii, area) == pytest.approx(2.0, abs=0.15)
    # The soft inside edge widens with the largest circles and takes over some of the boundary gradient.
    assert 0.5 < exponent(radii, boundary) < 1.05
    ratio = [a / b for a, b in zip(area, boundary, strict=True)]
    assert exponent(radii, ratio) > 1.0 and ratio == sorted(ratio)


@pytest.mark.parametrize("radius", [8, 16, 24])
def test_the_renderer_passes_the_area_gradient_on_to_the_points(radius: float, backend: Backend) -> None:
    scene = circle_scene(radius, 0.3, (0.1, 0.2))
    settings = Settings()
    adj_image = field(scene, math.pi / 4)[..., None].expand(-1, -1, 3) / 3
    on, off = (
        adjoint(scene, make_splat_renderer(scene, switched, backend), adj_image).points[0]
        for switched in (settings, Settings(interior_gradient=False))
    )
    adj_center = center_adjoint(scene, settings, math.pi / 4)[0]
    # Moving a path moves all its centers equally. With the lines detached only the boundary's gradient is left.
    assert_grad_close((on - off).sum(0), adj_center[1:-1].sum((0, 1)), rtol=1e-9, atol=1e-11, name="area")
    assert_grad_close(off.sum(0), adj_center[[0, -1]].sum((0, 1)), rtol=1e-9, atol=1e-11, name="boundary")
