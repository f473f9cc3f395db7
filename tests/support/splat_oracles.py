"""The splat renderer beside its reference: scenes of any degree, both gradients, distances to what is cut off."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict

import pytest
import torch
from assertions import assert_grad_close, assert_grad_present, assert_same_direction
from oracles import GRADIENTS, adjoint, cotangent, render
from reference import splatting
from reference.splatting import Settings
from scenes import SceneTensors, circle, random_scene
from torch import Tensor

from warpvec.rendering.splat import SplatRenderer

BAND = 1e-9
"""Width of what float64 may decide otherwise than the reference, around each cut and clamp."""

SWITCHES = [(interior, covariance) for interior in (True, False) for covariance in (True, False)]
"""Interior gradient and covariance gradient, on or off."""

OPACITIES = [
    (0.0, 0.0, 0.0),
    (0.0035, 0.5, 0.0038),
    (1.0, 1.0, 1.0),
    (0.4, 1.0, 0.6),
    (1.0, 0.0, 0.005),
    (0.9995, 0.2, 0.3),
]
"""Opacities of three paths: dropped, clipped, in between."""

switches = pytest.mark.parametrize(("interior", "covariance"), SWITCHES)


def make_splat_renderer(
    scene: SceneTensors,
    settings: Settings,
    lane_width: int | None = 16,
    dtype: torch.dtype = torch.float64,
    *,
    threads: int = 2,
    device: str = "cpu",
    transmittance_min: float = 0.0,
) -> SplatRenderer:
    """A renderer for the scene's canvas; nothing hidden is skipped unless asked for."""
    return SplatRenderer(
        scene.height,
        scene.width,
        device=device,
        threads=threads,
        dtype=dtype,
        lane_width=lane_width,
        transmittance_min=transmittance_min,
        **asdict(settings),
    )


def loop_scene(seed: int, path_count: int, height: int, width: int, degree: int, pieces: int = 2) -> SceneTensors:
    """A random scene of closed loops of ``pieces`` Bezier curves of any degree."""
    scene = random_scene(seed, path_count, height, width)
    generator = torch.Generator().manual_seed(seed)
    count = degree * pieces
    angle = 2 * math.pi * torch.arange(count, dtype=torch.float64) / count
    noise = 0.4 * torch.randn(path_count, count, 2, generator=generator, dtype=torch.float64)
    center = scene.points.mean(1, keepdim=True)
    radius = (scene.points - center).norm(dim=-1).mean(1)[:, None, None]
    return scene._replace(points=center + radius * (torch.stack([angle.cos(), angle.sin()], -1) + noise))


def wild_path(seed: int, height: int, width: int) -> Tensor:
    """Control points [12, 2] of a path that crosses itself, around the middle of the canvas."""
    size = max(height, width)
    noise = torch.randn(12, 2, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return circle(0.5 * width + 0.3, 0.5 * height - 0.2, 0.3 * size) + 0.1 * size * noise


def white(path: Tensor, opacity: float, height: int, width: int) -> SceneTensors:
    """One white path [P, 2] on black."""
    return SceneTensors(
        path[None],
        torch.ones(1, 3, dtype=torch.float64),
        torch.tensor([opacity], dtype=torch.float64),
        torch.zeros(3, dtype=torch.float64),
        height,
        width,
    )


def white_wild(seed: int, height: int, width: int, opacity: float) -> SceneTensors:
    """One wild path, white on black."""
    return white(wild_path(seed, height, width), opacity, height, width)


def faint(scene: SceneTensors, factor: float = 0.3) -> SceneTensors:
    """The scene with lower opacities, so that more of a path's Gaussians, and of the paths below, show."""
    return scene._replace(opacity=factor * scene.opacity)


def with_switches(settings: Settings, interior: bool, covariance: bool) -> Settings:
    """The settings with other switches."""
    return Settings(settings.samples, settings.lines, settings.degree, interior, covariance)


def in_the_middle(seed: int, path_count: int, height: int, width: int) -> SceneTensors:
    """A random scene whose paths are all on the canvas, and none of which hides the others."""
    scene = random_scene(seed, path_count, height, width)
    middle = scene.points.mean(1, keepdim=True)
    shift = 0.5 * (torch.tensor([width, height], dtype=torch.float64) - middle)
    return faint(scene._replace(points=scene.points + shift))


def layered(seed: int, height: int, width: int, *opacity: float) -> SceneTensors:
    """Paths on the canvas, of these opacities from the bottom to the top."""
    scene = in_the_middle(seed, len(opacity), height, width)
    return scene._replace(opacity=torch.tensor(opacity, dtype=torch.float64))


def reference_image(scene: SceneTensors, settings: Settings) -> Tensor:
    return splatting.render(*scene, settings)


def reference_gradients(scene: SceneTensors, settings: Settings, adj_image: Tensor) -> dict[str, Tensor]:
    """dL/d(each input) by autograd through the reference."""
    leaves = [tensor.clone().requires_grad_() for tensor in scene[:4]]
    image = splatting.render(*leaves, scene.height, scene.width, settings)
    gradients = torch.autograd.grad((image * adj_image).sum(), leaves, materialize_grads=True)
    return dict(zip(GRADIENTS, gradients, strict=True))


def decisions(scene: SceneTensors, settings: Settings) -> Tensor:
    """What is dropped, clipped or clamped, as one flat mask: the image is smooth while it stays the same."""
    found = splatting.gaussians(scene.points, settings)
    low, high = splatting.scale_limits(settings.lines + 2)
    masks = [(found.free_scale < low).flatten(), (found.free_scale > high).flatten()]
    for row in range(len(scene.points)):
        peak = splatting.peak(found, row, scene.opacity, scene.height, scene.width).flatten()
        masks += [peak < splatting.ALPHA_MIN, peak > splatting.ALPHA_MAX]
    return torch.cat(masks)


def least_margin(scene: SceneTensors, settings: Settings) -> float:
    """Distance of the alpha or standard deviation that is nearest to a cut, a clip or a clamp, from it."""
    found = splatting.gaussians(scene.points, settings)
    distances = [(found.free_scale - limit).abs().flatten() for limit in splatting.scale_limits(settings.lines + 2)]
    distances.append((splatting.tangents(found.mean).norm(dim=-1) - splatting.TANGENT_MIN).abs().flatten())
    for row in range(len(scene.points)):
        peak = splatting.peak(found, row, scene.opacity, scene.height, scene.width).flatten()
        distances += [(peak - splatting.ALPHA_MIN).abs(), (peak - splatting.ALPHA_MAX).abs()]
    return min((float(distance.min()) for distance in distances if distance.numel()), default=math.inf)


def off_the_band(settings: Settings, make: Callable[..., SceneTensors], seed: int, *rest: float) -> SceneTensors:
    """``make(seed, *rest)``, or the same from a later seed, with no value near a threshold."""
    for attempt in range(seed, seed + 5000, 1000):
        scene = make(attempt, *rest)
        if least_margin(scene, settings) > BAND:
            return scene
    raise AssertionError(f"each of five scenes from seed {seed} on has a value within {BAND:.0e} of its threshold")


def check_image(scene: SceneTensors, settings: Settings, renderer: SplatRenderer, atol: float) -> None:
    assert_off_the_band(scene, settings)
    torch.testing.assert_close(render(scene, renderer), reference_image(scene, settings), rtol=0, atol=atol)


def check_gradients(scene: SceneTensors, settings: Settings, renderer: SplatRenderer, rtol: float) -> None:
    assert_off_the_band(scene, settings)
    adj_image = cotangent(scene)
    got, want = adjoint(scene, renderer, adj_image), reference_gradients(scene, settings, adj_image)
    for name in GRADIENTS:
        # Nearly cancelled sums keep the rounding of their addends, of the size of 1.
        assert_grad_close(getattr(got, name), want[name], rtol=rtol, atol=1e-12, name=name)
        assert_grad_present(getattr(got, name), want[name], name, floor=max(1e-6, 10 * rtol))
        if want[name].numel():
            assert_same_direction(getattr(got, name), want[name], 1 - rtol, name)


def assert_off_the_band(scene: SceneTensors, settings: Settings) -> None:
    """No value of the scene is so near a threshold that rounding decides it: take another seed if one is."""
    margin = least_margin(scene, settings)
    assert margin > BAND, f"a value is {margin:.1e} from its threshold: the scene needs another seed"
