"""Write a scene as SVG text, which states exactly the scene that `warpvec.svg.quantize` returns."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from warpvec import __version__
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.svg.path_data import format_curves, format_number, format_path
from warpvec.svg.quantize import COLOR_LEVELS, GRADIENT_DECIMALS, OPACITY_DECIMALS, quantize, ticks_of

# XML 1.0 forbids these characters even escaped, and file names may contain them.
_ILLEGAL_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_svg(
    scene: Scene,
    width: int,
    height: int,
    *,
    precision: int = 2,
    opacity_decimals: int = OPACITY_DECIMALS,
    title: str | None = None,
    metadata: dict[str, Any] | None = None,
    sides: tuple[str, str] | None = None,
    layer_names: Mapping[int, str] | None = None,
) -> str:
    """Return the SVG text of ``quantize(scene)`` on a canvas of ``width`` x ``height`` user units.

    The text has a background rectangle unless the scene is transparent, then one group per run of equal generation (a
    layer in Inkscape, a named group in other editors), with one path per line. Cubics of no length are left out, such
    as those that pad a path to the segment count of another. Gradients stand before the background. ``metadata`` is
    stored as JSON with the version of warpvec; None leaves out that element. ``sides`` are the attributes width and
    height with their units, None for pixels. ``layer_names`` maps a generation to its name; a name must not occur
    twice. The text depends on the arguments alone: it has no dates and no file paths.

    Raises:
        ValueError: as `quantize`, or ``metadata`` cannot be written as JSON.
    """
    scene = quantize(scene, precision, opacity_decimals).cpu()
    fills, definitions = fills_of(scene)
    sides = sides or (str(width), str(height))
    elements = _path_elements(scene, precision, opacity_decimals, fills)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
        f' width="{sides[0]}" height="{sides[1]}" viewBox="0 0 {width} {height}">',
        *_description(title, metadata),
        *definitions,
        *_background(scene, width, height),
        *_layers(scene.generation.numpy(), elements, layer_names or {}),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _description(title: str | None, metadata: dict[str, Any] | None) -> Iterator[str]:
    if title is not None:
        yield f"<title>{_xml_text(title)}</title>"
    if metadata is not None:
        origin = {"generator": f"warpvec {__version__}", **metadata}
        yield f"<metadata>{_xml_text(json.dumps(origin, allow_nan=False))}</metadata>"


def _xml_text(text: str) -> str:
    return escape(_ILLEGAL_IN_XML.sub("\N{REPLACEMENT CHARACTER}", text))


def _background(scene: Scene, width: int, height: int) -> Iterator[str]:
    if not scene.transparent:
        fill = hex_colors(scene.background[None])[0]
        yield f'<rect id="background" width="{width}" height="{height}" fill="{fill}"/>'


def _layers(generation: NDArray[np.int64], elements: list[str], names: Mapping[int, str]) -> Iterator[str]:
    """Yield ``elements`` in one group per run of equal generation; the running number keeps ids unique."""
    starts = np.flatnonzero(np.diff(generation, prepend=generation[:1] - 1)).tolist()
    stops = (np.flatnonzero(np.diff(generation, append=generation[-1:] + 1)) + 1).tolist()
    for number, (start, stop) in enumerate(zip(starts, stops, strict=True), 1):
        level = int(generation[start])
        plural = "path" if stop - start == 1 else "paths"
        label = names.get(level, f"Layer {number}: generation {level}, {stop - start} {plural}")
        identifier = layer_id(names[level]) if level in names else f"layer-{number}-generation-{level}"
        yield f'<g id="{identifier}" inkscape:groupmode="layer" inkscape:label={quoteattr(label)}>'
        yield from elements[start:stop]
        yield "</g>"


def layer_id(name: str) -> str:
    """Return the id of a layer called ``name``: its letters and digits, with hyphens between."""
    return re.sub(r"[^a-zA-Z0-9]+", "-", name).strip("-")


def _path_elements(scene: Scene, precision: int, opacity_decimals: int, fills: list[str]) -> list[str]:
    data = path_data(scene, precision)
    opaque = 10**opacity_decimals
    opacity = ticks_of(scene.opacity, opaque).tolist()
    return [
        f'<path fill="{fill}"{_opacity_attribute(ticks, opacity_decimals) if ticks < opaque else ""} d="{d}"/>'
        for fill, ticks, d in zip(fills, opacity, data, strict=True)
    ]


def path_data(scene: Scene, precision: int) -> list[str]:
    """Return the ``d`` of each path.

    The choice between the two forms depends only on what a reader of the file finds as well, so that a file that is
    read and written again has the same bytes: not on rows of no length, which are left out.
    """
    ticks, structure = ticks_of(scene.segments, 10**precision).numpy(), scene.structure
    is_line = np.zeros(len(ticks), np.bool_) if structure.is_line is None else structure.is_line.numpy()
    has_lines = bool(_drawn_lines(ticks, structure).any())
    if structure.loop_count == len(scene) and not has_lines:
        return format_curves(ticks, structure.loop_first_segment.numpy().astype(np.int64), precision)
    rows, loops = structure.loop_first_segment.tolist(), structure.path_first_loop.tolist()
    parts = [(ticks[start:stop], is_line[start:stop]) for start, stop in pairwise(rows)]
    return [format_path(parts[start:stop], precision) for start, stop in pairwise(loops)]


def closes_by_lines(scene: Scene) -> NDArray[np.bool_] | None:
    """Return the rows [R] that are the line which closes a path; None if a path has several loops or other lines.

    ``scene`` has whole numbers of ticks, as those of its file.
    """
    structure = scene.structure
    if structure.loop_count != len(scene):
        return None
    is_line = np.zeros(len(scene.segments), np.bool_) if structure.is_line is None else structure.is_line.numpy()
    is_last = np.zeros_like(is_line)
    is_last[structure.loop_first_segment.numpy()[1:] - 1] = True
    return None if (is_line & ~is_last).any() else is_line & is_last


def _drawn_lines(ticks: NDArray[np.int64], structure: Structure) -> NDArray[np.bool_]:
    """Return the rows [R] that are lines of some length."""
    if structure.is_line is None:
        return np.zeros(len(ticks), np.bool_)
    ends = ticks[structure.segment_next.numpy(), 0]
    return structure.is_line.numpy() & (ends != ticks[:, 0]).any(1)


def _opacity_attribute(ticks: int, decimals: int) -> str:
    return f' fill-opacity="{format_number(ticks, decimals)}"'


def fills_of(scene: Scene) -> tuple[list[str], list[str]]:
    """Return the ``fill`` of each path, and the lines that define its gradients; equal gradients are one."""
    fills = hex_colors(scene.color)
    if scene.gradients is None:
        return fills, []
    gradients, names = scene.gradients, dict[str, str]()
    ends, places = hex_colors(gradients.end_color), ticks_of(gradients.geometry, 10**GRADIENT_DECIMALS).tolist()
    for row, kind in enumerate(gradients.kind.tolist()):
        if kind != FLAT:
            text = _gradient(kind, places[row], fills[row], ends[row])
            fills[row] = f"url(#{names.setdefault(text, f'g{len(names) + 1}')})"
    lines = [text.replace(" ", f' id="{name}" ', 1) for text, name in names.items()]
    return fills, ["<defs>", *lines, "</defs>"]


def _gradient(kind: int, geometry: list[int], start: str, end: str) -> str:
    paint = kind_of(kind)
    attributes = paint.attributes([format_number(ticks, GRADIENT_DECIMALS) for ticks in geometry])
    places = (f'{side}="{text}"' for side, text in attributes.items())
    stops = f'<stop stop-color="{start}"/><stop offset="1" stop-color="{end}"/>'
    return f'<{paint.element} gradientUnits="userSpaceOnUse" {" ".join(places)}>{stops}</{paint.element}>'


def hex_colors(color: Tensor) -> list[str]:
    """Return ``#rrggbb``, or ``#rgb`` if that is the same colour, for each row of ``color`` [N, 3]."""
    names = (bytes(levels).hex() for levels in ticks_of(color, COLOR_LEVELS).tolist())
    return ["#" + (name[::2] if name[::2] == name[1::2] else name) for name in names]
