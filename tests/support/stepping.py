"""Paths that move in place, and steps of them that can be recorded as graphs, on the CPU too."""

from __future__ import annotations

from dataclasses import replace

import torch
from oracles import GRADIENTS, inputs, target_image
from scenes import SceneTensors

from warpvec.geometry.scene import Scene
from warpvec.paper import splat
from warpvec.rendering import exact
from warpvec.rendering.graph import RecordedStep
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer

KINDS = ("exact", "splat")


def renderer_of(kind: str, scene: SceneTensors, device: str = "cpu") -> TileRenderer:
    """Make a renderer whose launches can be recorded on the CPU too: with scalar lanes and one thread."""
    shared = {"lane_width": 1, "threads": 1, "transmittance_min": 1e-4, "device": device}
    if kind == "exact":
        return exact.ExactRenderer(scene.height, scene.width, **shared)
    return splat.SplatRenderer(scene.height, scene.width, samples=9, lines=3, **shared)


class Moving:
    """Paths that move in place, with a recorded step and one that is never recorded."""

    def __init__(self, kind: str, scene: SceneTensors, device: str = "cpu") -> None:
        self.renderer, self.plain = renderer_of(kind, scene, device), renderer_of(kind, scene, device)
        self.recorded = RecordedStep(self.renderer, record=True)
        self.target = self.renderer.prepare_target(target_image(scene))
        self.scene = inputs(scene, self.renderer)

    def move(self, distance: float = 0.7) -> None:
        self.scene.segments.add_(distance)
        self.scene.color.mul_(0.99)

    def step(self, want_removal_cost: bool = False) -> Adjoints:
        return self.recorded.take(self.scene, self.target, want_removal_cost)

    def want(self, want_removal_cost: bool = False) -> Adjoints:
        return self.plain.fit_step(self.scene, self.target, want_removal_cost)

    def check_step(self) -> None:
        check_equal(self.step(), self.want())
        self.move()


def copied(scene: Scene) -> Scene:
    """Return ``scene`` in memory of its own."""
    return replace(scene, **{name: getattr(scene, name).clone() for name in ("segments", *GRADIENTS[1:])})


def check_equal(got: Adjoints, want: Adjoints) -> None:
    for name in ("segments", *GRADIENTS[1:], "loss"):
        assert torch.equal(getattr(got, name), getattr(want, name)), name
    assert (got.removal_cost is None) == (want.removal_cost is None)
    assert want.removal_cost is None or torch.equal(got.removal_cost, want.removal_cost)
