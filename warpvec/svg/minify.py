"""Write a scene as the shortest SVG text that editors still open at its true size.

The coordinates are whole numbers in a viewBox that is finer than the pixels; ``width`` and ``height`` state the true
size. There are no line ends, layers, ids, title or settings. The most common opacity is stated once, on the group of
the paths. `warpvec.svg.read` reads such files back exactly.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from warpvec.geometry.scene import Scene
from warpvec.svg.path_data import format_closed_curves, format_number
from warpvec.svg.quantize import OPACITY_DECIMALS, quantize, ticks_of
from warpvec.svg.write import closes_by_lines, fills_of, hex_colors, path_data

_OPAQUE = 10**OPACITY_DECIMALS

_GROUP = ('<g fill-opacity="">', "</g>")
"""The text that states an opacity for all paths of a group, without its digits."""


def write_minified(
    scene: Scene, width: int, height: int, sides: tuple[str, str], *, precision: int = 0, keeps_layers: bool = False
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
    fills, definitions = fills_of(scene)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{sides[0]}" height="{sides[1]}"'
        f' viewBox="0 0 {width} {height}">',
        *definitions,
        *_background(scene, width, height),
    ]
    opacity = ticks_of(scene.opacity, _OPAQUE).tolist()
    data = _data(scene, precision)
    elements = list(zip(fills, opacity, data, strict=True))
    for start, stop in _layers(scene, keeps_layers):
        parts += _group(elements[start:stop], keeps_layers)
    return "".join([*parts, "</svg>"])


def _background(scene: Scene, width: int, height: int) -> Iterator[str]:
    if not scene.transparent:
        yield f'<rect width="{width}" height="{height}" fill="{hex_colors(scene.background[None])[0]}"/>'


def _layers(scene: Scene, keeps_layers: bool) -> Iterator[tuple[int, int]]:
    """Yield the range of paths of each group."""
    count = len(scene)
    inner: list[int] = (np.flatnonzero(np.diff(scene.generation.numpy())) + 1).tolist() if keeps_layers else []
    yield from (pairwise([0, *inner, count]) if count else ())


def _group(elements: list[tuple[str, int, str]], is_layer: bool) -> Iterator[str]:
    """Yield the text of paths, each given by its fill, its opacity in ticks and its data."""
    common = _common_opacity([opacity for _, opacity, _ in elements])
    has_group = is_layer or common != _OPAQUE
    if has_group:
        yield "<g>" if common == _OPAQUE else f'<g fill-opacity="{format_number(common, OPACITY_DECIMALS)}">'
    for fill, opacity, data in elements:
        own = "" if opacity == common else f' fill-opacity="{format_number(opacity, OPACITY_DECIMALS)}"'
        yield f'<path fill="{fill}"{own} d="{data}"/>'
    if has_group:
        yield "</g>"


def _common_opacity(opacity: list[int]) -> int:
    """Return the opacity in ticks that saves most as that of the group; opaque if none saves more than it costs."""
    counts = Counter(opacity)
    lengths = {ticks: len(f' fill-opacity="{format_number(ticks, OPACITY_DECIMALS)}"') for ticks in counts}
    group = sum(map(len, _GROUP))
    # Opaque paths say nothing without a group that does.
    gains = {t: counts[t] * lengths[t] - counts[_OPAQUE] * lengths.get(_OPAQUE, 0) - group for t in counts}
    gains[_OPAQUE] = 0
    return max(gains, key=lambda ticks: (gains[ticks], ticks))


def _data(scene: Scene, precision: int) -> list[str]:
    """Return the ``d`` of each path. Paths of one loop of curves, closed by a line or not, are written all at once."""
    is_closing = closes_by_lines(scene)
    if is_closing is None:
        return path_data(scene, precision)
    ticks = ticks_of(scene.segments, 10**precision).numpy()
    first = scene.structure.loop_first_segment.numpy().astype(np.int64)
    return format_closed_curves(ticks, first, precision, is_closing)
