"""Bring the shapes of a drawing and the shadow below them together.

The ground that a drawing painted above its shadow becomes a gap. The shadow gets the outlines of the shapes that cast
it, moved: the fit of a free outline would take up what is unclear at their edges.

With the exact coverage of the shapes, offset, blur and colour of the shadow follow from the picture by the fit of
`warpvec.flat.softness.shadow_fitting`, and the shapes by another fit of the drawing above that shadow.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from warpvec.arrays import Floats
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.shadows import Shadow
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.forms.registry import ELLIPSE, form_of
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.geometry.structure import Structure
from warpvec.rendering.draw import draw_exactly


def paths_below(scene: Scene, shadow: Shadow, threads: int | None) -> int:
    """Return how many paths of ``scene`` lie below the ``shadow``: its ground, and what is below that.

    None do if the ground is the page, or transparent.
    """
    ground = shadow.ground
    if len(ground.color) > 3:
        return 0
    if ground.is_flat and ground.region.all():
        color = torch.from_numpy(ground.color / 255.0).float()
        is_page = not scene.transparent and _is_near(scene.background, color)
        return 0 if is_page or not len(scene) or not _is_near(scene.color[0], color) else 1
    height, width = ground.is_seen.shape
    left, top, right, bottom = path_boxes(scene).double().unbind(1)
    is_large = (right - left) * (bottom - top) >= SOFTNESS.below_share * float(ground.is_seen.sum())
    for k in reversed(is_large.nonzero().flatten().tolist()):
        cover = coverage(scene.select(torch.tensor([k])), height, width, threads)
        if float(cover[ground.is_seen].mean()) > SOFTNESS.below_share:
            return int(k) + 1
    return 0


def soft_copy(path: Scene, shadow: Shadow) -> Scene:
    """Return one ``path`` without a gradient, moved, blurred and painted as the ``shadow``."""
    color, opacity = shadow.paint
    return replace(
        path.moved(*shadow.look.offset),
        color=torch.from_numpy(color).float()[None],
        opacity=torch.tensor([opacity], dtype=torch.float32),
        softness=Softness(torch.tensor([shadow.look.sigma], dtype=torch.float32)),
    )


def spot_path(shadow: Shadow, scene: Scene) -> Scene | None:
    """Return the soft spot ``shadow`` as a path over the background of ``scene``; None if shapes cast it."""
    if shadow.spot is None:
        return None
    parameters, (color, opacity) = torch.from_numpy(shadow.spot)[None], shadow.paint
    one = Scene.uniform(
        form_of(ELLIPSE).segments(parameters).float().flatten(1, 2), torch.from_numpy(color).float()[None],
        torch.tensor([opacity], dtype=torch.float32), scene.background, scene.generation.new_zeros(1),
        transparent=scene.transparent,
    )  # fmt: skip
    one = replace(one, softness=Softness(torch.tensor([shadow.look.sigma], dtype=torch.float32)))
    return one.with_forms(Forms(torch.tensor([ELLIPSE], dtype=torch.int32), parameters.float()))


def as_one(shapes: Scene, paths: list[int]) -> Scene:
    """Return some paths without gradients as one; a single one keeps its form."""
    chosen = replace(shapes.select(torch.tensor(paths)), gradients=None, softness=None)
    return chosen if len(paths) == 1 else joined_outlines(chosen)


def joined_outlines(parts: Scene) -> Scene:
    """Return the outlines of all paths of ``parts`` as the loops of one path."""
    structure = parts.structure
    counts = structure.loop_first_segment.diff().tolist()
    whole = Structure.of_loops([counts], structure.is_line, structure.is_open)
    rest = {name: getattr(parts, name)[:1] for name in ("color", "opacity", "generation")}
    return replace(parts, structure=whole, gradients=None, strokes=None, forms=None, softness=None, **rest)


def coverage(paths: Scene, height: int, width: int, threads: int | None) -> Floats:
    """Return how much of each pixel the ``paths`` of a scene cover together [h, w]."""
    white = replace(
        paths, color=torch.ones_like(paths.color), opacity=torch.ones_like(paths.opacity), gradients=None,
        softness=None, background=torch.zeros_like(paths.background), transparent=False,
    )  # fmt: skip
    found: Floats = draw_exactly(white, height, width, threads)[..., 0].astype(np.float64)
    return found


def _is_near(color: Tensor, other: Tensor) -> bool:
    return bool(np.abs((color - other).numpy()).max() <= SOFTNESS.alike / 255.0 + math.ulp(1.0))
