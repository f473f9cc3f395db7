"""Say discs of a drawing by its pen: as dots of it, or as its circles."""

from __future__ import annotations

from functools import reduce
from itertools import pairwise

import numpy as np
import torch

from warpvec.arrays import Floats
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.form_candidates import Candidate
from warpvec.flat.strokes.line_fitting import Rows
from warpvec.flat.strokes.stroke import Stroke, stroke_scene
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.forms.form import FIRST, X, Y
from warpvec.geometry.forms.registry import CIRCLE
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.regrouping import regrouped
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import ROUND


def with_pen_dots(scene: Scene) -> Scene:
    """Return ``scene`` with strokes in place of discs of the same colour, so that a drawing has one pen.

    A disc as wide as the pen is a dot of it. One twice as wide is a circle of it, whose inner edge is its centre.
    """
    pens = _pens(scene)
    if not pens or scene.forms is None:
        return scene
    pen_of = {path: pen for path in range(len(scene)) if (pen := _pen_of(scene, path, pens)) is not None}
    if not pen_of:
        return scene
    parts, owner, boxes = [], list(range(len(scene))), path_boxes(scene).double().numpy()
    for path in range(len(scene)):
        one = scene.select(torch.tensor([path]))
        parts.append(_drawn_by(scene, one, pen_of[path]) if path in pen_of else one)
        if path in pen_of and parts[-1].forms is None and _may_join(scene, path, pen_of[path], boxes):
            owner[path] = pen_of[path]
    return _gathered(reduce(Scene.joined, parts), owner)


def _may_join(scene: Scene, path: int, pen: int, boxes: Floats) -> bool:
    """Return whether a dot may be drawn with its ``pen``: opaque, and with nothing between them that it touches."""
    if _has_form(scene, pen) or float(scene.opacity[path]) < 1.0 or scene.softness is not None:
        return False
    between = boxes[min(path, pen) + 1 : max(path, pen)]
    return not ((between[:, :2] <= boxes[path, 2:]) & (boxes[path, :2] <= between[:, 2:])).all(1).any()


def _pens(scene: Scene) -> list[int]:
    """Return the paths of ``scene`` that are strokes of a flat colour, those without a form first."""
    if scene.strokes is None:
        return []
    found = [path for path in scene.strokes.is_stroked.nonzero().flatten().tolist() if _is_flat(scene, path)]
    return sorted(found, key=lambda path: _has_form(scene, path))


def _is_flat(scene: Scene, path: int) -> bool:
    return scene.gradients is None or int(scene.gradients.kind[path]) == FLAT


def _has_form(scene: Scene, path: int) -> bool:
    return scene.forms is not None and bool(scene.forms.is_form[path])


def _pen_of(scene: Scene, path: int, pens: list[int]) -> int | None:
    """Return the pen that draws the disc ``path``; None if it is no disc, or none does."""
    assert scene.forms is not None and scene.strokes is not None
    if path in pens or int(scene.forms.kind[path]) != CIRCLE or not _is_flat(scene, path):
        return None
    look, size = _look(scene, path), 2.0 * float(scene.forms.parameters[path, FIRST])
    for pen in pens:
        width = float(scene.strokes.width[pen])
        is_dot = abs(size - width) <= STROKES.width_shared and int(scene.strokes.cap[pen]) == ROUND
        if look == _look(scene, pen) and (is_dot or abs(size - 2.0 * width) <= STROKES.width_shared):
            return pen
    return None


def _look(scene: Scene, path: int) -> tuple[float, ...]:
    return (*scene.color[path].tolist(), float(scene.opacity[path]))


def _drawn_by(scene: Scene, one: Scene, pen: int) -> Scene:
    """Return a scene of ``one`` disc, as a dot or a circle of the ``pen`` of another scene."""
    assert scene.strokes is not None and one.forms is not None
    width, cap, join = float(scene.strokes.width[pen]), int(scene.strokes.cap[pen]), int(scene.strokes.join[pen])
    parameters = one.forms.parameters[0].double().numpy().copy()
    if 2.0 * parameters[FIRST] < 1.5 * width:
        place = np.tile(parameters[[X, Y]], (2, 3, 1))
        return stroke_scene(one, Stroke([0], [Rows(place, np.ones(2, bool), True)], width, cap, join, [None]), [0])
    parameters[FIRST] = width / 2.0
    circle = Candidate(CIRCLE, parameters)
    rows = Rows(circle.curves, np.zeros(4, bool), False)
    return stroke_scene(one, Stroke([0], [rows], width, cap, join, [circle]), [0])


def _gathered(scene: Scene, owner: list[int]) -> Scene:
    """Return ``scene`` with the loops of each path in that of its ``owner``."""
    first = scene.structure.path_first_loop.tolist()
    loops: list[list[int]] = [[] for _ in owner]
    for (start, stop), path in zip(pairwise(first), owner, strict=True):
        loops[path] += range(start, stop)
    paths = [path for path, own in enumerate(loops) if own]
    return regrouped(scene, paths, [loops[path] for path in paths])
