"""Paths that move in their memory, and steps of theirs that graphs of the CPU can record."""

from __future__ import annotations

import torch
from oracles import GRADIENTS, inputs, target_image
from scenes import SceneTensors

from warpvec.rendering import exact, splat
from warpvec.rendering.graph import RecordedStep
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer

KINDS = ("exact", "splat")


def renderer_of(kind: str, scene: SceneTensors, device: str = "cpu") -> TileRenderer:
    """One whose launches a graph can record on the CPU too: with scalar lanes, as on a GPU, and one thread."""
    shared = {"lane_width": 1, "threads": 1, "transmittance_min": 1e-4, "device": device}
    if kind == "exact":
        return exact.ExactRenderer(scene.height, scene.width, **shared)
    return splat.SplatRenderer(scene.height, scene.width, samples=9, lines=3, **shared)


class Moving:
    """Paths that move in their memory, and their step beside one that is never recorded."""

    def __init__(self, kind: str, scene: SceneTensors, device: str = "cpu") -> None:
        self.renderer, self.plain = renderer_of(kind, scene, device), renderer_of(kind, scene, device)
        self.repeated = RecordedStep(self.renderer, record=True)
        self.target = self.renderer.prepare_target(target_image(scene))
        self.values = [value.clone() for value in inputs(scene, self.renderer)]

    def move(self, distance: float = 0.7) -> None:
        self.values[0] += distance
        self.values[1].mul_(0.99)

    def step(self, removal_cost: bool = False) -> Adjoints:
        return self.repeated.take(*self.values, self.target, removal_cost)

    def want(self, removal_cost: bool = False) -> Adjoints:
        return self.plain.fit_step(*self.values, self.target, removal_cost)

    def check_step(self, removal_cost: bool = False) -> None:
        check_equal(self.step(removal_cost), self.want(removal_cost))
        self.move()


def check_equal(got: Adjoints, want: Adjoints) -> None:
    for name in (*GRADIENTS, "loss"):
        assert torch.equal(getattr(got, name), getattr(want, name)), name
    assert (got.removal_cost is None) == (want.removal_cost is None)
    assert want.removal_cost is None or torch.equal(got.removal_cost, want.removal_cost)
