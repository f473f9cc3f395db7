"""Compile the kernels before the first run, by running every kind of fit once on a few pixels."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import product

import numpy as np
import torch
from torch import Tensor

from warpvec.config.presets import make_config
from warpvec.config.rooms import rooms
from warpvec.fit.loop import fit
from warpvec.fit.similarity import Similarity
from warpvec.fit.target import Target
from warpvec.fit.visibility import visible_areas
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.choice import chosen_parts
from warpvec.flat.simplification.local_error import errors_near
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import LINEAR
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.geometry.strokes import Strokes
from warpvec.geometry.structure import Structure
from warpvec.polish.polish import polish
from warpvec.rendering.draw import draw_pixels
from warpvec.rendering.launch import resolve_device
from warpvec.rendering.operator import draw_adjoint, outline_slopes

# Long enough to use each kernel of a fit: steps, an inflation, and a recycling, which asks for removal costs.
_SHORT = {"curves": 4, "initial_curves": 2, "iterations": 8, "inflation_gap": 1, "time_budget": None}
_KINDS = (
    {"preset": "default", "recycle_gap": 1, "recycle_share": 0.5},
    {"preset": "default", "recycle_gap": 1, "recycle_share": 0.5, "gradients": 1.0},
    *(fit for room in rooms() for fit in room.short_fits),
)


def compile_kernels(device: str = "auto") -> float:
    """Compile and cache the kernels that fits on ``device`` use; return the seconds it took (few if already cached).

    The CPU's kernels are always among them: results are drawn, and searched for hidden paths, on the CPU.

    Raises:
        InputError: the device does not exist.
    """
    start = time.perf_counter()
    target = torch.linspace(0.0, 1.0, 16 * 16 * 3).reshape(16, 16, 3)
    for where, kind in product({resolve_device(device), "cpu"}, _KINDS):
        config = make_config(**{**_SHORT, **kind, "device": where})
        scene = fit(target, config).scene
        draw_pixels(scene, 16, 16, **config.render_settings)
        visible_areas(to_cubics(scene)[0], 16, 16)
    for where in {resolve_device(device), "cpu"}:
        stroke = _stroke().to(where)
        outline_slopes(stroke, 16, 16)
        for scene in (stroke, replace(stroke, softness=Softness(torch.ones(1, device=where)))):
            draw_adjoint(scene, torch.ones(16, 16, 3, device=where))
    Similarity(target, 1).shift(target, torch.ones(()))  # for which these fits are too short
    _fit_flat_art(target)
    return time.perf_counter() - start


def _fit_flat_art(target: Tensor) -> None:
    """Choose parts, fit two drawings exactly, one with a gradient, and look for their errors, as flat art does."""
    wave = np.array([[0.0, 0.0], [3.0, 9.0], [6.0, -9.0], [9.0, 0.0]])
    chosen_parts(Chain.of(np.stack([wave, wave + wave[3]]), is_closed=False), 0.1, 1.0)
    config, flat = make_config(device="cpu"), _stroke()
    ramp = Gradients(torch.tensor([LINEAR], dtype=torch.int32), torch.tensor([[0.0, 0.0, 9.0, 9.0]]), torch.ones(1, 3))
    for scene in (flat, replace(flat, strokes=None, gradients=ramp)):
        found = polish(Target(target, config, "cpu"), scene, config, iterations=2).scene
        errors_near(found.segments.double().numpy(), np.zeros((16, 16), np.float32))


def _stroke() -> Scene:
    """Return a drawing of one stroke, which no fit of a photo has."""
    rows = torch.tensor([[[2.0, 2.0], [4.0, 4.0], [6.0, 6.0]], [[8.0, 8.0], [6.0, 6.0], [4.0, 4.0]]])
    structure = Structure.of_loops([[2]], torch.tensor([True, True]), torch.tensor([True]))
    one, color = torch.ones(1), torch.zeros(1, 3)
    strokes = replace(Strokes.none(color), width=one)
    return Scene(rows, structure, color, one, torch.ones(3), torch.zeros(1, dtype=torch.int64), strokes=strokes)
