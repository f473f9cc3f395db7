"""Gradients for the paths that gain most: the gain against brute force, and how many a fit gives."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from logo import logo
from scenes import blob_scene
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.loop import fit
from warpvec.fit.ramps import Ramps, best_ramps, with_ramps
from warpvec.fit.target import Target
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, LINEAR
from warpvec.geometry.scene import Scene
from warpvec.watch.watch import Watch

HEIGHT, WIDTH, COUNT = 40, 56, 9


def scene_of_blobs(transparent: bool) -> Scene:
    tensors = blob_scene(3, COUNT, HEIGHT, WIDTH)
    points, color, opacity, background = (tensor.float() for tensor in tensors[:4])
    color, opacity[2::3] = 0.35 + 0.3 * color, 1.0
    background = background * 0.0 if transparent else background
    generation = torch.zeros(COUNT, dtype=torch.int64)
    return Scene.uniform(points, color, opacity, background, generation, transparent=transparent)


def shaded(transparent: bool) -> Tensor:
    """Return a picture [h, w, 3 or 4] that is brighter towards some sides, with noise."""
    y, x = torch.meshgrid(torch.linspace(0, 1, HEIGHT), torch.linspace(0, 1, WIDTH), indexing="ij")
    image = torch.stack([x, 1 - y, 0.5 * (x * y) + 0.25, 0.3 + 0.7 * y], -1) + 0.05 * torch.rand(HEIGHT, WIDTH, 4)
    return image.clamp(0.0, 1.0)[..., : 4 if transparent else 3]


@pytest.fixture(params=[False, True], ids=["opaque", "transparent"])
def subject(request: pytest.FixtureRequest) -> tuple[Scene, Target]:
    config = make_config(threads=1, device="cpu")
    return scene_of_blobs(request.param), Target(shaded(request.param), config, "cpu")


def error(target: Target, scene: Scene) -> float:
    """Return the mean squared error over all channels, in float64 from the picture of each pixel."""
    return float(target.squared_error(scene).double().sum()) * target.error_scale


def endless(scene: Scene, rows: list[int], ramps: Ramps) -> Scene:
    """Return ``scene`` with the ramps of ``rows`` drawn so long that no pixel lies beyond their ends."""
    first, last = ramps.geometry[:, :2], ramps.geometry[:, 2:]
    middle, half = (first + last) / 2, (last - first) / 2
    factor = 4.0 * (HEIGHT + WIDTH) / half.norm(dim=1, keepdim=True)
    chosen = torch.zeros(COUNT, dtype=torch.bool)
    chosen[rows] = True
    change = torch.where(chosen[:, None], ramps.change * factor, 0.0)
    geometry = torch.cat([middle - factor * half, middle + factor * half], 1)
    kind = torch.where(chosen, LINEAR, FLAT).int()
    gradients = Gradients(kind, geometry, scene.color + change)
    return replace(scene, color=scene.color - change, gradients=gradients)


def test_a_path_gains_at_least_what_was_predicted(subject: tuple[Scene, Target]) -> None:
    scene, target = subject
    ramps, before = best_ramps(scene, target), error(target, scene)
    gains = torch.tensor([before - error(target, endless(scene, [row], ramps)) for row in range(COUNT)])
    assert (gains >= ramps.gain - 1e-6 * before).all()
    assert (ramps.gain > 1e-7 * before).all() and (ramps.gain > 1e-4 * before).any()
    # The last path is opaque and on top: the bound has no slack but at its edge.
    assert gains[-1] < 1.3 * ramps.gain[-1]


def test_all_paths_together_gain_at_least_the_sum(subject: tuple[Scene, Target]) -> None:
    scene, target = subject
    ramps, before = best_ramps(scene, target), error(target, scene)
    total = float(ramps.gain.sum())
    assert before - error(target, endless(scene, list(range(COUNT)), ramps)) >= total - 1e-6 * before
    # The gradients that a fit makes end within the paths, and in colours that can be shown.
    painted = with_ramps(scene, torch.arange(COUNT), ramps)
    assert painted.gradients.end_color.amin() >= 0.0 and painted.color.amax() <= 1.0
    assert before - error(target, painted) > 0.7 * total


def visible_shares(scene: Scene, target: Target) -> Tensor:
    """Return the visible share of each path in each pixel [N, h, w], by drawing it white and all else black."""
    layers = []
    for row in range(COUNT):
        color = torch.zeros(COUNT, 3)
        color[row] = 1.0
        layers.append(target._renderer.render(replace(scene, color=color, background=torch.zeros(3)))[..., 0])
    return torch.stack(layers).double()


def test_no_direction_gains_more(subject: tuple[Scene, Target]) -> None:
    """Brute force: for each of many directions, the best slope by least squares over the pixels."""
    scene, target = subject
    shares, residual = visible_shares(scene, target), target._residual(scene).double()
    y, x = torch.meshgrid(torch.arange(HEIGHT) + 0.5, torch.arange(WIDTH) + 0.5, indexing="ij")
    ramps = best_ramps(scene, target)
    for row in range(COUNT):
        w = shares[row]
        best = 0.0
        for angle in torch.linspace(0.0, math.pi, 181)[:-1].tolist():
            ramp = x * math.cos(angle) + y * math.sin(angle)
            ramp = ramp - (w * ramp).sum() / w.sum()
            pull = (residual * (w * ramp)[..., None]).sum((0, 1))
            best = max(best, float(pull.square().sum() / (4.0 * target.error_scale * (w * ramp * ramp).sum())))
        assert best * (1.0 - 1e-3) <= ramps.gain[row] <= best * (1.0 + 1e-3), row


def test_a_hidden_path_gains_nothing() -> None:
    scene = scene_of_blobs(False)
    opacity = scene.opacity.clone()
    opacity[2] = 0.0
    ramps = best_ramps(replace(scene, opacity=opacity), Target(shaded(False), make_config(threads=1), "cpu"))
    assert ramps.gain[2] == 0.0 and ramps.gain.isfinite().all()


QUICK: dict[str, Any] = {"curves": 20, "initial_curves": 5, "inflation_gap": 3, "iterations": 40, "device": "cpu"}


def gradient_count(settings: dict[str, Any], image: Tensor) -> int:
    scene = fit(image, make_config(**{**QUICK, "threads": 1, **settings})).scene
    assert len(scene) == 20
    return 0 if scene.gradients is None else int((scene.gradients.kind != FLAT).sum())


@pytest.mark.parametrize(
    ("settings", "count"),
    [
        ({"gradients": 0.3}, 6),
        ({"gradients": 7.0}, 7),
        ({"gradients": 1.0}, 20),
        ({"gradients": 500.0}, 20),
        ({"gradients": 1.0, "iterations": 2, "initial_curves": 20}, 20),
        ({}, 0),
        ({"gradients": 0.3, "opacity": "opaque"}, 6),
        ({"gradients": 0.3, "lod": True}, 6),
        ({"gradients": 0.3, "z_order": "area", "recycle_gap": 2}, 6),
        ({"gradients": 0.3, "recycle_gap": 3, "recycle_share": 0.9, "recycle_until": 1.0}, 6),
        ({"gradients": 0.3, "color_parameter": "logit"}, 6),
    ],
)
def test_a_fit_gives_as_many_paths_a_gradient_as_were_asked_for(settings: dict[str, Any], count: int) -> None:
    assert gradient_count(settings, shaded(False)) == count


@pytest.mark.parametrize("lod", [False, True])
def test_a_transparent_picture_gets_gradients_too(lod: bool) -> None:
    pixels = torch.from_numpy(logo()[::2, ::2].astype(np.float32) / 255.0)
    assert gradient_count({"gradients": 0.25, "lod": lod}, pixels) == 5


def test_a_shaded_picture_is_fitted_better_with_gradients() -> None:
    losses = [
        fit(shaded(False), make_config(**QUICK, threads=1, gradients=share)).history[-1]["psnr"] for share in (0.0, 1.0)
    ]
    assert losses[1] > losses[0] + 0.5


@pytest.mark.parametrize("settings", [{"colors": 4}, {"palette": "#000,#fff"}, {"renderer": "splat"}])
def test_gradients_are_refused_where_fills_must_be_flat(settings: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="^gradients must be 0 with") as caught:
        FitConfig(gradients=0.5, **settings)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("stop", [7, 8, 9, 33])
def test_an_interrupted_fit_returns_a_scene_that_can_be_drawn(stop: int) -> None:
    """Gradients are chosen after iterations 8 and 32."""

    def interrupt(progress: Any) -> None:
        if progress.iteration == stop:
            raise KeyboardInterrupt

    target = Target(shaded(False), make_config(threads=1), "cpu")
    result = fit(shaded(False), make_config(**QUICK, threads=1, gradients=1.0), Watch(interrupt).part())
    assert result.interrupted and result.iterations == stop
    assert math.isfinite(error(target, result.scene))
    assert stop > 8 or result.scene.gradients is None


def test_auto_gives_gradients_where_they_pay_and_nowhere_else() -> None:
    x = torch.linspace(0.1, 0.9, WIDTH)[None, :, None].expand(HEIGHT, WIDTH, 3).contiguous()
    config = FitConfig(curves=6, iterations=60, threads=1, gradients="auto")
    smooth = fit(x, config).scene
    assert smooth.gradients is not None and int((smooth.gradients.kind == LINEAR).sum()) > 0
    plain = fit((x > 0.5).float(), config).scene
    assert plain.gradients is None


def test_gradients_are_a_number_or_auto() -> None:
    with pytest.raises(InputError, match="gradients must be"):
        FitConfig(gradients="many")
