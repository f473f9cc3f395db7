"""Write a scene as the shortest SVG text that editors still open at its true size.

The coordinates are whole numbers in a viewBox that is finer than the pixels; ``width`` and ``height`` state the true
size. There are no line ends, layers, ids, title or settings. A form is a path where that is shorter. The most common
opacity is stated once, on the group of the paths. `warpvec.svg.read` reads such files back exactly.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

import numpy as np
import torch

from warpvec.geometry.forms.form import ANGLE
from warpvec.geometry.forms.registry import RECT
from warpvec.geometry.scene import Scene
from warpvec.svg.form_elements import Shape, form_shapes
from warpvec.svg.path_data import format_closed_curves
from warpvec.svg.quantize import quantize, ticks_of
from warpvec.svg.write import (
    OPAQUE,
    Look,
    background_of,
    closes_by_lines,
    looks_of,
    opacity_attribute,
    path_data,
    path_shape,
    runs_of,
    shape_element,
)

_GROUP = '<g fill-opacity=""></g>'
"""The text that states an opacity for all paths of a group, without its digits."""

_GAIN_MIN = 0.01
"""Least share of the file that a group must save: paper.js and other programs ignore the opacity of a group."""


def write_minified(
    scene: Scene,
    width: int,
    height: float,
    sides: tuple[str, str],
    *,
    precision: int = 0,
    keeps_layers: bool = False,
    has_groups: bool = True,
    has_arcs: bool = True,
    profile: str = "",
    closes_exactly: bool = False,
) -> str:
    """Return the short SVG text of ``quantize(scene, precision)`` on a canvas of ``width`` x ``height`` user units.

    The text depends on the arguments alone.

    Args:
        scene: the paths, in user units.
        width, height: sides of the viewBox.
        sides: the attributes width and height, with their units if these are not pixels.
        precision: decimals of the coordinates.
        keeps_layers: write a group for each run of equal generation, without a name. Otherwise all paths are in one.
        has_groups: whether a group may state the opacity of its paths.
        has_arcs, profile, closes_exactly: as `warpvec.svg.write.write_svg` has them.

    Raises:
        ValueError: as `quantize`.
    """
    scene = quantize(scene, precision).cpu()
    generation = scene.generation.numpy()
    groups = list(runs_of(generation if keeps_layers else np.zeros_like(generation)))
    shapes = _shapes(scene, precision, has_arcs, closes_exactly)
    least = _GAIN_MIN * sum(len(shape.attributes) for shape in shapes) if has_groups else math.inf
    common = [_common_opacity(scene.select(torch.arange(*each)), least) for each in groups]
    stated = {path for ticks, group in zip(common, groups, strict=True) if ticks != OPAQUE for path in range(*group)}
    looks, definitions = looks_of(scene, precision, short_ids=True, keeps_opacity=stated)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{sides[0]}" height="{sides[1]}"'
        f' viewBox="0 0 {width} {height}"{profile}>',
        *definitions,
        *background_of(scene, width, height),
    ]
    elements = list(zip(looks, shapes, strict=True))
    for ticks, (start, stop) in zip(common, groups, strict=True):
        parts += _group(elements[start:stop], ticks, keeps_layers)
    return "".join([*parts, "</svg>"])


def _group(elements: list[tuple[Look, Shape]], common: int, is_layer: bool) -> Iterator[str]:
    """Yield the text of shapes, each given with its look; ``common`` is the opacity in ticks that a group states."""
    has_group = is_layer or common != OPAQUE
    if has_group:
        yield "<g>" if common == OPAQUE else f"<g{opacity_attribute(common)}>"
    for look, shape in elements:
        yield shape_element(look, shape, common)
    if has_group:
        yield "</g>"


def _common_opacity(scene: Scene, least: float) -> int:
    """Return the opacity in ticks that saves most as that of the group; opaque if none saves ``least`` bytes.

    No path states its opacity as 1 against its group: some programs keep that of the group.
    """
    opacity = ticks_of(scene.opacity, OPAQUE)
    if scene.strokes is not None:
        opacity = opacity[~scene.strokes.is_stroked]
    counts = Counter(opacity.tolist())
    if OPAQUE in counts:
        return OPAQUE
    gains = {ticks: count * len(opacity_attribute(ticks)) - len(_GROUP) for ticks, count in counts.items()}
    gains = {ticks: gain for ticks, gain in gains.items() if gain >= least} | {OPAQUE: 0}
    return max(gains, key=lambda ticks: (gains[ticks], ticks))


def _shapes(scene: Scene, precision: int, has_arcs: bool, closes_exactly: bool) -> list[Shape]:
    """Return the shape of each path: its form, or its outline where an outline is shorter and draws the same."""
    forms = scene.forms
    if forms is None:
        return list(map(path_shape, _data(scene, precision, has_arcs, closes_exactly)))
    shapes = form_shapes(forms, precision)
    is_same = (forms.kind == RECT) & (forms.parameters[:, ANGLE] == 0.0)  # of others, the outline has other ticks
    others = (~forms.is_form | is_same).nonzero().flatten()
    outlines = _data(scene.select(others).outlined(), precision, has_arcs, closes_exactly)
    for path, data in zip(others.tolist(), outlines, strict=True):
        shape = path_shape(data)
        shapes[path] = min(shapes.get(path, shape), shape, key=lambda each: len(each.element) + len(each.attributes))
    return [shapes[path] for path in range(len(scene))]


def _data(scene: Scene, precision: int, has_arcs: bool, closes_exactly: bool) -> list[str]:
    """Return the ``d`` of each path. Paths of one loop of curves, closed by a line or not, are written all at once."""
    is_closing = closes_by_lines(scene)
    if is_closing is None or (closes_exactly and precision > 0):
        return path_data(scene, precision, has_arcs, closes_exactly)
    ticks = ticks_of(scene.segments, 10**precision).numpy()
    first = scene.structure.loop_first_segment.numpy().astype(np.int64)
    return format_closed_curves(ticks, first, precision, is_closing)
