"""Turn the strokes of a scene into filled outlines, for what works with areas: fits of photos and cut parts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import ModuleType

import numpy as np
import torch

from warpvec.errors import InputError
from warpvec.geometry.loops import Outline, make_scene
from warpvec.geometry.scene import Scene
from warpvec.svg.foreign.shapes import Loop, Subpath
from warpvec.svg.foreign.skia import load_skia
from warpvec.svg.foreign.stroke import Stroke, outline

_UNITS_PER_PIXEL = 8.0
"""Resolution at which Skia makes outlines, which are within a quarter of a unit."""


def without_strokes(scene: Scene, name: str = "svg") -> Scene:
    """Return ``scene`` with its strokes as filled outlines; messages call the drawing ``name``.

    Raises:
        InputError: it has strokes, and skia-pathops is not installed.
    """
    if scene.strokes is None or not bool(scene.strokes.is_stroked.any()):
        return scene
    skia = load_skia()
    if skia is None:
        rule = "must have filled paths only, because skia-pathops, which outlines strokes, is not installed"
        raise InputError(name, rule, "strokes", "pip install 'warpvec[refine]'")
    parts = []
    for path, is_stroked in enumerate(scene.strokes.is_stroked.tolist()):
        one = scene.select(torch.tensor([path]))
        parts.append(_outlined(one, skia) if is_stroked else one)
    found = parts[0]
    for part in parts[1:]:
        found = found.joined(part)
    return replace(found, strokes=None)


def _outlined(one: Scene, skia: ModuleType) -> Scene:
    """Return the outline of a scene of one stroke."""
    assert one.strokes is not None
    width, cap, join, limit = (float(getattr(one.strokes, name)) for name in ("width", "cap", "join", "miter_limit"))
    loops = outline(_subpaths(one), Stroke(width, int(cap), int(join), limit, (), 0.0), _UNITS_PER_PIXEL, skia)
    points = np.concatenate([loop.points for loop in loops])
    counts, is_line = tuple(len(loop.is_line) for loop in loops), np.concatenate([loop.is_line for loop in loops])
    drawn = make_scene([Outline(points, (0.0, 0.0, 0.0), 1.0, 0, counts, is_line)], None).to(one.segments.device)
    values = {name: getattr(one, name) for name in ("color", "opacity", "background", "generation", "transparent")}
    segments = drawn.segments.to(one.segments.dtype)
    return Scene(segments, drawn.structure, **values, gradients=one.gradients)


def _subpaths(one: Scene) -> list[Subpath]:
    structure, rows, is_line = one.structure, one.segments.double().cpu().numpy(), one.structure.lines.cpu().numpy()
    is_open = [False] * structure.loop_count if structure.is_open is None else structure.is_open.tolist()
    found = []
    for (start, stop), opened in zip(pairwise(structure.loop_first_segment.tolist()), is_open, strict=True):
        loop = Loop(rows[start:stop].reshape(-1, 2), is_line[start:stop])
        if opened:
            found.append(Subpath(loop.points[:-2], loop.is_line[:-1], False))
        else:
            found.append(Subpath(np.concatenate([loop.points, loop.points[:1]]), loop.is_line, True))
    return found
