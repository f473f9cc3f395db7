"""Write a scene as the shortest SVG text that editors still open at its true size.

The coordinates are whole numbers in a viewBox that is finer than the pixels; ``width`` and ``height`` state the true
size. There are no line ends, layers, ids, title or settings. A form is a path where that is shorter. The most common
opacity is stated once, on the group of the paths. `warpvec.svg.read` reads such files back exactly.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator

import numpy as np

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
    opacity_attribute,
    paints_of,
    path_data,
    path_shape,
    runs_of,
    shape_element,
    strokes_of,
)

_GROUP = '<g fill-opacity=""></g>'
"""The text that states an opacity for all paths of a group, without its digits."""


def write_minified(
    scene: Scene, width: int, height: float, sides: tuple[str, str], *, precision: int = 0, keeps_layers: bool = False
) -> str:
    """Return the short SVG text of ``quantize(scene, precision)`` on a canvas of ``width`` x ``height`` user units.

    The text depends on the arguments alone.

    Args:
        scene: the paths, in user units.
        width, height: sides of the viewBox.
        sides: the attributes width and height, with their units if these are not pixels.
        precision: decimals of the coordinates.
        keeps_layers: write a group for each run of equal generation, without a name. Otherwise all paths are in one.

    Raises:
        ValueError: as `quantize`.
    """
    scene = quantize(scene, precision).cpu()
    fills, blurs, definitions = paints_of(scene, short_ids=True)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{sides[0]}" height="{sides[1]}"'
        f' viewBox="0 0 {width} {height}">',
        *definitions,
        *background_of(scene, width, height),
    ]
    looks = zip(fills, ticks_of(scene.opacity, OPAQUE).tolist(), strokes_of(scene, precision), blurs, strict=True)
    elements = list(zip(itertools.starmap(Look, looks), _shapes(scene, precision), strict=True))
    generation = scene.generation.numpy()
    for start, stop in runs_of(generation if keeps_layers else np.zeros_like(generation)):
        parts += _group(elements[start:stop], keeps_layers)
    return "".join([*parts, "</svg>"])


def _group(elements: list[tuple[Look, Shape]], is_layer: bool) -> Iterator[str]:
    """Yield the text of shapes, each given with its look."""
    common = _common_opacity([look.opacity for look, _ in elements if look.stroke is None])
    has_group = is_layer or common != OPAQUE
    if has_group:
        yield "<g>" if common == OPAQUE else f"<g{opacity_attribute(common)}>"
    for look, shape in elements:
        yield shape_element(look, shape, common)
    if has_group:
        yield "</g>"


def _common_opacity(opacity: list[int]) -> int:
    """Return the opacity in ticks that saves most as that of the group; opaque if none saves more than it costs."""
    counts = Counter(opacity)
    lengths = {ticks: len(opacity_attribute(ticks)) for ticks in counts}
    # Opaque paths say nothing without a group that does.
    gains = {t: counts[t] * lengths[t] - counts[OPAQUE] * lengths.get(OPAQUE, 0) - len(_GROUP) for t in counts}
    gains[OPAQUE] = 0
    return max(gains, key=lambda ticks: (gains[ticks], ticks))


def _shapes(scene: Scene, precision: int) -> list[Shape]:
    """Return the shape of each path: the shorter one of its form and, where it draws the same, its outline."""
    forms = scene.forms
    if forms is None:
        return list(map(path_shape, _data(scene, precision)))
    shapes = form_shapes(forms, precision)
    is_same = (forms.kind == RECT) & (forms.parameters[:, ANGLE] == 0.0)  # of others, the outline has other ticks
    others = (~forms.is_form | is_same).nonzero().flatten()
    for path, data in zip(others.tolist(), _data(scene.select(others).outlined(), precision), strict=True):
        shape = path_shape(data)
        shapes[path] = min(shapes.get(path, shape), shape, key=lambda each: len(each.element) + len(each.attributes))
    return [shapes[path] for path in range(len(scene))]


def _data(scene: Scene, precision: int) -> list[str]:
    """Return the ``d`` of each path. Paths of one loop of curves, closed by a line or not, are written all at once."""
    is_closing = closes_by_lines(scene)
    if is_closing is None:
        return path_data(scene, precision)
    ticks = ticks_of(scene.segments, 10**precision).numpy()
    first = scene.structure.loop_first_segment.numpy().astype(np.int64)
    return format_closed_curves(ticks, first, precision, is_closing)
