"""From the regions of a picture to a scene of clean paths."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.flat.curves.curve_fitting import TOLERANCE, fit_loops
from warpvec.flat.layers.outlines import outlines
from warpvec.flat.layers.stacking import Layer, stack
from warpvec.flat.regions.regions import Regions
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

LAYERS_MIN = 16
"""Layers that are drawn even if the time is over: with none, nothing would be seen."""


def scene_of(
    regions: Regions, tolerance: float = TOLERANCE, join: bool = False, is_over: Callable[[], bool] = bool
) -> Scene:
    """Return the drawing of ``regions``: a path for each layer, on the canvas's paint or none.

    Args:
        regions: regions of a picture.
        tolerance: largest distance in pixels between the outlines in the picture and the curves.
        join: make one path of the shapes of one paint, as `stack` does.
        is_over: says whether the layers so far must do, the lowest first.
    """
    layers: list[Layer] = []
    loops: list[list[NDArray[np.float64]]] = []
    for layer in stack(regions, join):
        if is_over() and len(layers) >= LAYERS_MIN:
            break
        found = outlines(regions, layer)
        if found:
            layers.append(layer)
            loops.append(found)
    fits = fit_loops([loop for found in loops for loop in found], tolerance)
    counts = np.cumsum([0, *(len(found) for found in loops)])
    per_layer = [[len(fits[k][0]) for k in range(a, b)] for a, b in pairwise(counts)]
    segments = np.concatenate([segments for segments, _ in fits]) if fits else np.zeros((0, 3, 2))
    is_line = np.concatenate([mask for _, mask in fits]) if fits else np.zeros(0, bool)
    structure = Structure.of_loops(per_layer, torch.from_numpy(is_line) if is_line.any() else None)
    return _painted(regions, layers, torch.from_numpy(segments).float(), structure)


def _painted(regions: Regions, layers: Sequence[Layer], segments: torch.Tensor, structure: Structure) -> Scene:
    rows = [layer.members[0] for layer in layers]
    color, opacity, geometry, end_color = (
        torch.from_numpy(values[rows]).float()
        for values in (regions.color, regions.opacity, regions.geometry, regions.end_color)
    )
    kind = torch.from_numpy(regions.kind[rows]).int()
    gradients = Gradients(kind, geometry, end_color) if bool(kind.any()) else None
    canvas = regions.canvas
    is_opaque = canvas is not None and regions.opacity[canvas] > 0
    background = torch.from_numpy(regions.color[canvas]).float() if is_opaque else torch.zeros(3)
    generation = torch.zeros(len(rows), dtype=torch.int64)
    return Scene(segments, structure, color, opacity, background, generation, not is_opaque, gradients)
