"""Edit a drawing: recolour, delete, move and simplify its paths, or cut it out. Each function returns a new drawing.

>>> result = warpvec.vectorize("logo.png")                                           # doctest: +SKIP
>>> drawing = warpvec.edit.recolour(result.drawing, "#2e9b4f", "orange")             # doctest: +SKIP
>>> result.with_drawing(warpvec.edit.cut_out(drawing)).save("logo.dxf")              # doctest: +SKIP

Paths are counted from the lowest, which is 0, as in ``drawing.scene``. Lengths are in pixels of the picture.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np
import torch
from torch import Tensor

from warpvec.checks import show
from warpvec.config.fit_config import SETTINGS
from warpvec.config.palette import parse_palette
from warpvec.drawing.drawing import Drawing
from warpvec.errors import InputError
from warpvec.flat.color_layers.layering import color_name, layered
from warpvec.flat.cutting.simple_outlines import with_simple_outlines
from warpvec.geometry.fewer_nodes import with_fewer_nodes
from warpvec.geometry.scene import Scene
from warpvec.modes.flat import without_overlaps
from warpvec.svg.stroke_outlines import without_strokes
from warpvec.svg.write import hex_colors
from warpvec.watch.watch import UNWATCHED, Watch

__all__ = ["cut_out", "delete", "move", "recolour", "simplify"]

Paths = int | Iterable[int]
"""A path, or several."""


def recolour(drawing: Drawing, old: str, new: str) -> Drawing:
    """Return ``drawing`` with the colour ``new`` wherever a fill, a stroke, a stop or the background is ``old``.

    Args:
        drawing: the drawing.
        old, new: names or codes of colours, such as "teal" or "#2e9b4f".

    Raises:
        InputError: one is no colour, or no path has the colour ``old``.
    """
    before, after = _color(old, "old"), torch.tensor(_levels(_color(new, "new"))) / 255.0
    scene, found = drawing.scene, list[bool]()

    def changed(colors: Tensor) -> Tensor:
        rows = colors.reshape(-1, 3)
        is_old = torch.tensor([each == before for each in hex_colors(rows)], dtype=torch.bool)
        found.append(bool(is_old.any()))
        return torch.where(is_old[:, None], after.to(rows), rows).reshape(colors.shape)

    gradients = scene.gradients
    if gradients is not None:
        stops = gradients.stops
        stops = stops and replace(stops, inner_color=changed(stops.inner_color))
        gradients = replace(gradients, end_color=changed(gradients.end_color), stops=stops)
    background = scene.background if scene.transparent else changed(scene.background)
    scene = replace(scene, color=changed(scene.color), gradients=gradients, background=background)
    if not any(found):
        raise InputError("old", "must be a colour of the drawing", before, f"it has {_listed(drawing)}")
    return _renamed(_with_scene(drawing, scene), before, after)


def _renamed(drawing: Drawing, before: str, after: Tensor) -> Drawing:
    """Return ``drawing`` with the name of the colour ``after`` for layers that are called after the code ``before``."""
    name, known = color_name(after.double().numpy()), drawing.encoding.layer_names
    names = known and {level: re.sub(rf"^[a-z ]+ {before}", name, each) for level, each in known.items()}
    return replace(drawing, encoding=replace(drawing.encoding, layer_names=names))


def delete(drawing: Drawing, paths: Paths) -> Drawing:
    """Return ``drawing`` without ``paths``.

    Raises:
        InputError: there is no such path.
    """
    rows = _rows(drawing, paths)
    return _with_scene(drawing, drawing.scene.select((~rows).nonzero().flatten()))


def move(drawing: Drawing, paths: Paths, right: float, down: float) -> Drawing:
    """Return ``drawing`` with ``paths``, and their gradients, moved by so many pixels.

    Raises:
        InputError: there is no such path, or a distance is not finite.
    """
    for name, value in (("right", right), ("down", down)):
        if not np.isfinite(value):
            raise InputError(name, "must be a finite number of pixels", repr(value))
    rows, scene = _rows(drawing, paths), drawing.scene
    return _with_scene(drawing, _merged(scene, scene.moved(right, down), rows))


def simplify(drawing: Drawing, paths: Paths, tolerance: float = 0.5) -> Drawing:
    """Return ``drawing`` with fewer nodes in ``paths``, whose outlines move by at most about ``tolerance`` pixels.

    Forms and corners stay.

    Raises:
        InputError: there is no such path, or the tolerance is not above 0 and finite.
    """
    if not 0.0 < tolerance < float("inf"):
        raise InputError("tolerance", "must be above 0 and finite", repr(tolerance), "0.5 is half a pixel")
    rows, scene = _rows(drawing, paths), drawing.scene.cpu()
    own = [scene.select(torch.tensor([row])) for row in range(len(scene))]
    is_form = torch.zeros(len(scene), dtype=torch.bool) if scene.forms is None else scene.forms.is_form
    changed = (rows & ~is_form).tolist()
    parts = [
        with_fewer_nodes(one, tolerance) if is_changed else one for one, is_changed in zip(own, changed, strict=True)
    ]
    return _with_scene(drawing, reduce(Scene.joined, parts))


def cut_out(drawing: Drawing, watch: Watch = UNWATCHED) -> Drawing:
    """Return ``drawing`` without overlaps, for cutting: neighbours share the very same edge.

    Strokes become their outlines. What is white on a white background is left out; see
    `warpvec.flat.cutting.cutout.cut_out`.

    Args:
        drawing: the drawing.
        watch: the watch over the run.
    """
    encoding = replace(drawing.encoding, keeps_paths=True, closes_exactly=True)
    picture = encoding.picture
    whole = without_strokes(drawing.scene.cpu().outlined()).scaled(*picture.reduction)
    scene, left_out = without_overlaps(whole, encoding, watch)
    scene, names = layered(scene, *picture.reduced_size, joins_shades=False)
    metadata = encoding.metadata and {**encoding.metadata, "cutout": True}
    settings = encoding.settings
    if settings.mode in SETTINGS["cutout"].modes:  # refined drawings have that of photos
        settings = replace(settings, cutout=True)
    more: dict[str, Any] = {"layer_names": names, "simplify": with_simple_outlines}
    return Drawing.of(scene, replace(encoding, settings=settings, metadata=metadata, **more), "cpu", left_out=left_out)


def _color(given: str, name: str) -> str:
    """Return "#rrggbb" of a name or code of a colour."""
    try:
        found = parse_palette(given)
    except InputError:
        found = ""
    if found.count("#") != 1:
        raise InputError(name, "must be a colour", show(given), "give one such as teal or #2e9b4f")
    return found


def _levels(code: str) -> list[int]:
    return [int(code[place : place + 2], 16) for place in (1, 3, 5)]


def _listed(drawing: Drawing) -> str:
    return ", ".join(dict.fromkeys(hex_colors(drawing.scene.color)))


def _rows(drawing: Drawing, paths: Paths) -> Tensor:
    """Return the mask [N] of ``paths``."""
    count = len(drawing.scene)
    places = [paths] if isinstance(paths, int) else list(paths)
    for place in places:
        if not (isinstance(place, int) and 0 <= place < count):
            raise InputError("paths", f"must be from 0 to {count - 1}", repr(place), "count from the lowest path, 0")
    mask = torch.zeros(count, dtype=torch.bool)
    mask[places] = True
    return mask


def _merged(scene: Scene, other: Scene, rows: Tensor) -> Scene:
    """Return ``scene`` with the paths ``rows`` (a mask) of an ``other`` one of as many paths in place of its own."""
    count = len(scene)
    return scene.joined(other).select(torch.arange(count) + count * rows)


def _with_scene(drawing: Drawing, scene: Scene) -> Drawing:
    """Return ``drawing`` with another ``scene``, in pixels of the picture; all its paths stay."""
    encoding = replace(drawing.encoding, keeps_paths=True)
    fitted = scene.scaled(*encoding.picture.reduction)
    made = Drawing.of(fitted, encoding, drawing.device)
    return replace(
        drawing, fitted=fitted, scene=made.scene, encoding=encoding, conversion_px=made.conversion_px, given=None
    )
