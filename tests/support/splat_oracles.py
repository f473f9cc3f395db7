"""Run the splat renderer and its float64 reference on the same scene, and keep scenes away from thresholds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict

import torch
from assertions import assert_grad_close, assert_grad_present, assert_same_direction
from backends import VECTOR, Backend
from oracles import GRADIENTS, adjoint, cotangent, render
from reference import splatting
from reference.splatting import Settings
from scenes import SceneTensors, circle, random_scene
from sweep import sweep
from torch import Tensor

from warpvec.paper.splat import SplatRenderer

BAND = 1e-9
"""Distance from a cut or a clamp within which rounding may make the renderer and the reference decide differently."""

SWITCHES = [(interior, covariance) for interior in (True, False) for covariance in (True, False)]
"""Whether the interior gradient and the covariance gradient are on."""

OPACITIES = [
    (0.0, 0.0, 0.0),
    (0.0035, 0.5, 0.0038),
    (1.0, 1.0, 1.0),
    (0.4, 1.0, 0.6),
    (1.0, 0.0, 0.005),
    (0.9995, 0.2, 0.3),
]
"""Opacities of three paths: dropped, clipped, and in between."""

switches = sweep(("interior", "covariance"), SWITCHES)


def make_splat_renderer(
    scene: SceneTensors,
    settings: Settings,
    backend: Backend = VECTOR,
    dtype: torch.dtype = torch.float64,
    *,
    threads: int = 2,
    transmittance_min: float = 0.0,
    released_adjoint: bool = False,
) -> SplatRenderer:
    """Make a renderer for the scene's canvas; with the default ``transmittance_min`` it skips no hidden path."""
    return SplatRenderer(
        scene.height,
        scene.width,
        device=backend.device,
        threads=threads,
        dtype=dtype,
        lane_width=backend.lane_width,
        transmittance_min=transmittance_min,
        released_adjoint=released_adjoint,
        **asdict(settings),
    )


def loop_scene(seed: int, path_count: int, height: int, width: int, degree: int, pieces: int = 2) -> SceneTensors:
    """Return a random scene of closed loops of ``pieces`` Bezier curves of any degree."""
    scene = random_scene(seed, path_count, height, width)
    generator = torch.Generator().manual_seed(seed)
    count = degree * pieces
    angle = 2 * math.pi * torch.arange(count, dtype=torch.float64) / count
    noise = 0.4 * torch.randn(path_count, count, 2, generator=generator, dtype=torch.float64)
    center = scene.points.mean(1, keepdim=True)
    radius = (scene.points - center).norm(dim=-1).mean(1)[:, None, None]
    return scene._replace(points=center + radius * (torch.stack([angle.cos(), angle.sin()], -1) + noise))


def wild_path(seed: int, height: int, width: int) -> Tensor:
    """Return control points [12, 2] of a path that crosses itself, around the middle of the canvas."""
    size = max(height, width)
    noise = torch.randn(12, 2, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return circle(0.5 * width + 0.3, 0.5 * height - 0.2, 0.3 * size) + 0.1 * size * noise


def white(path: Tensor, opacity: float, height: int, width: int) -> SceneTensors:
    """Return a scene of one white path [P, 2] on black."""
    return SceneTensors(
        path[None],
        torch.ones(1, 3, dtype=torch.float64),
        torch.tensor([opacity], dtype=torch.float64),
        torch.zeros(3, dtype=torch.float64),
        height,
        width,
    )


def white_wild(seed: int, height: int, width: int, opacity: float) -> SceneTensors:
    """Return a scene of one wild path, white on black."""
    return white(wild_path(seed, height, width), opacity, height, width)


def faint(scene: SceneTensors, factor: float = 0.3) -> SceneTensors:
    """Return the scene with lower opacities, so that more Gaussians and more of the paths below are visible."""
    return scene._replace(opacity=factor * scene.opacity)


def with_switches(settings: Settings, interior: bool, covariance: bool) -> Settings:
    """Return the settings with other switches."""
    return Settings(settings.samples, settings.lines, settings.degree, interior, covariance)


def in_the_middle(seed: int, path_count: int, height: int, width: int) -> SceneTensors:
    """Return a random scene with all paths on the canvas and none hidden."""
    scene = random_scene(seed, path_count, height, width)
    middle = scene.points.mean(1, keepdim=True)
    shift = 0.5 * (torch.tensor([width, height], dtype=torch.float64) - middle)
    return faint(scene._replace(points=scene.points + shift))


def layered(seed: int, height: int, width: int, *opacity: float) -> SceneTensors:
    """Return a scene of paths on the canvas with these opacities, from bottom to top."""
    scene = in_the_middle(seed, len(opacity), height, width)
    return scene._replace(opacity=torch.tensor(opacity, dtype=torch.float64))


def reference_image(scene: SceneTensors, settings: Settings) -> Tensor:
    return splatting.render(*scene, settings)


def reference_gradients(scene: SceneTensors, settings: Settings, adj_image: Tensor) -> dict[str, Tensor]:
    """Return dL/d(each input) by autograd through the reference."""
    leaves = [tensor.clone().requires_grad_() for tensor in scene[:4]]
    image = splatting.render(*leaves, scene.height, scene.width, settings)
    gradients = torch.autograd.grad((image * adj_image).sum(), leaves, materialize_grads=True)
    return dict(zip(GRADIENTS, gradients, strict=True))


def decisions(scene: SceneTensors, settings: Settings) -> Tensor:
    """Return which values are dropped, clipped or clamped, as a flat mask; while it is constant the image is smooth."""
    found = splatting.gaussians(scene.points, settings)
    low, high = splatting.scale_limits(settings.lines + 2)
    inside = found.free_scale[:, 1:-1]
    masks = [(found.free_scale < low).flatten(), (found.free_scale > high).flatten()]
    masks += [(inside[..., 1] < splatting.THIN_SIGMA).flatten(), (splatting.limited(inside) < inside).flatten()]
    for row in range(len(scene.points)):
        peak = splatting.peak(found, row, scene.opacity, scene.height, scene.width).flatten()
        masks += [peak < splatting.ALPHA_MIN, peak > splatting.ALPHA_MAX]
    return torch.cat(masks)


def min_margin(scene: SceneTensors, settings: Settings) -> float:
    """Return the smallest distance of an alpha or a standard deviation from a cut, a clip or a clamp."""
    found = splatting.gaussians(scene.points, settings)
    distances = [(found.free_scale - limit).abs().flatten() for limit in splatting.scale_limits(settings.lines + 2)]
    inside = found.free_scale[:, 1:-1]
    distances += [(inside[..., 1] - splatting.THIN_SIGMA).abs().flatten()]
    seen = inside[inside.amax(-1) > splatting.INTERIOR_SIGMA_MIN]  # the floor hides what the ratio decides for others
    distances += [(seen[:, side] - splatting.THIN_RATIO * seen[:, 1 - side]).abs() for side in (0, 1)]
    distances.append((splatting.tangents(found.mean).norm(dim=-1) - splatting.TANGENT_MIN).abs().flatten())
    for row in range(len(scene.points)):
        peak = splatting.peak(found, row, scene.opacity, scene.height, scene.width).flatten()
        distances += [(peak - splatting.ALPHA_MIN).abs(), (peak - splatting.ALPHA_MAX).abs()]
    return min((float(distance.min()) for distance in distances if distance.numel()), default=math.inf)


def off_the_band(settings: Settings, make: Callable[..., SceneTensors], seed: int, *rest: float) -> SceneTensors:
    """Return ``make(seed, *rest)``, with a later seed if a value is near a threshold."""
    for attempt in range(seed, seed + 5000, 1000):
        scene = make(attempt, *rest)
        if min_margin(scene, settings) > BAND:
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
        # Sums that nearly cancel keep the rounding error of their addends, which are of order 1.
        assert_grad_close(getattr(got, name), want[name], rtol=rtol, atol=1e-12, name=name)
        assert_grad_present(getattr(got, name), want[name], name, floor=max(1e-6, 10 * rtol))
        if want[name].numel():
            assert_same_direction(getattr(got, name), want[name], 1 - rtol, name)


def assert_off_the_band(scene: SceneTensors, settings: Settings) -> None:
    """Fail if a value of the scene is so near a threshold that rounding decides; the test then needs another seed."""
    margin = min_margin(scene, settings)
    assert margin > BAND, f"a value is {margin:.1e} from its threshold: the scene needs another seed"
