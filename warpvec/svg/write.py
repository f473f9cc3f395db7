"""Write a scene as SVG text, which states exactly the scene that `warpvec.svg.quantize` returns."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Mapping
from hashlib import sha256
from itertools import pairwise
from typing import Any, NamedTuple
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec import __version__
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX
from warpvec.geometry.strokes import BUTT, CAPS, JOINS, MITER, MITER_LIMIT
from warpvec.svg.blurs import blurs_of
from warpvec.svg.dashes import dashes_of, paths_of_lines
from warpvec.svg.form_elements import Shape, form_shapes
from warpvec.svg.path_data import Loop, decimals_of, format_curves, format_number, format_path
from warpvec.svg.quantize import (
    COLOR_LEVELS,
    GRADIENT_DECIMALS,
    MITER_DECIMALS,
    OFFSET_DECIMALS,
    OPACITY_DECIMALS,
    STOP_OPACITY_DECIMALS,
    quantize,
    ticks_of,
    width_decimals,
)

OPAQUE = 10**OPACITY_DECIMALS
"""The opacity 1 in ticks, units of the last decimal."""

# XML 1.0 forbids these characters even escaped, and file names may contain them.
_ILLEGAL_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_svg(
    scene: Scene,
    width: float,
    height: float,
    *,
    precision: int = 2,
    title: str | None = None,
    metadata: dict[str, Any] | None = None,
    sides: tuple[str, str] | None = None,
    layer_names: Mapping[int, str] | None = None,
    has_arcs: bool = True,
    has_dashes: bool = False,
    profile: str = "",
    closes_exactly: bool = False,
) -> str:
    """Return the SVG text of ``quantize(scene)`` on a canvas of ``width`` x ``height`` user units.

    The text has a background rectangle unless the scene is transparent, then one group per run of equal generation (a
    layer in Inkscape, a named group in other editors), with one path or form per line. The name of a layer begins with
    its number, by which programs of plotters choose a pen. Cubics of no length are left out, such as those that pad a
    path to the segment count of another. Gradients stand before the background.
    ``metadata`` is stored as JSON with the version of warpvec; None leaves out that element. ``sides`` are the
    attributes width and height with their units, None for pixels. ``layer_names`` maps a generation to its name; a name
    must not occur twice. Without ``has_arcs`` arcs are stated as cubics. With ``has_dashes`` equal lines that
    follow each other on one line are a dashed line. ``profile`` are more attributes of the root,
    with a space before each. With ``closes_exactly`` loops of fills come back to their start also where a reader's sums
    are rounded; see `warpvec.svg.path_data`. The text depends on the arguments alone: it has no dates and no file
    paths.

    Raises:
        ValueError: as `quantize`, or ``metadata`` cannot be written as JSON.
    """
    scene = quantize(scene, precision).cpu()
    looks, definitions = looks_of(scene, precision)
    sides = sides or (str(width), str(height))
    elements = list(map(shape_element, looks, shapes_of(scene, precision, has_arcs, has_dashes, closes_exactly)))
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
        f' width="{sides[0]}" height="{sides[1]}" viewBox="0 0 {width} {height}"{profile}>',
        *_description(title, metadata),
        *definitions,
        *background_of(scene, width, height, ' id="background"'),
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


def background_of(scene: Scene, width: float, height: float, identifier: str = "") -> list[str]:
    """Return the rectangle of the background with the attribute ``identifier``; nothing if ``scene`` is transparent."""
    fill = hex_colors(scene.background[None])[0]
    return [] if scene.transparent else [f'<rect{identifier} width="{width}" height="{height}" fill="{fill}"/>']


def _layers(generation: NDArray[np.int64], elements: list[str], names: Mapping[int, str]) -> Iterator[str]:
    """Yield ``elements`` in one group per run of equal generation; the running number keeps ids unique."""
    for number, (start, stop) in enumerate(runs_of(generation), 1):
        level = int(generation[start])
        plural = "path" if stop - start == 1 else "paths"
        unnamed = f"Layer {number}: generation {level}, {stop - start} {plural}"
        label = f"{number} {names[level]}" if level in names else unnamed
        identifier = layer_id(names[level]) if level in names else f"layer-{number}-generation-{level}"
        yield f'<g id="{identifier}" inkscape:groupmode="layer" inkscape:label={quoteattr(label)}>'
        yield from elements[start:stop]
        yield "</g>"


def runs_of(generation: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Yield the first row, and the row after the last, of each run of equal ``generation`` [N]."""
    inner = np.flatnonzero(np.diff(generation)) + 1
    yield from pairwise(np.unique([0, *inner, len(generation)]).tolist())


def layer_name(label: str, identifier: str) -> str:
    """Return the name of a layer from its ``label``, which begins with a number if its ``identifier`` does not."""
    numbered = re.fullmatch(r"\d+ (.+)", label, re.ASCII | re.DOTALL)
    return numbered[1] if numbered and layer_id(numbered[1]) == identifier else label


def layer_id(name: str) -> str:
    """Return the id of a layer called ``name``: its letters and digits, with hyphens between."""
    return re.sub(r"[^a-zA-Z0-9]+", "-", name).strip("-")


class Look(NamedTuple):
    """How a path is painted.

    Attributes:
        paint: the colour of its fill or stroke, or a reference to a gradient.
        opacity: of the fill or stroke, in ticks.
        stroke: the attributes of a stroke but for its paint, each with a space before it; None for a fill.
        blur: the attribute of a soft path, with the space before it.
    """

    paint: str
    opacity: int
    stroke: str | None
    blur: str = ""


def shape_element(look: Look, shape: Shape, shared: int = OPAQUE) -> str:
    """Return the element of a shape; the opacity of a fill is left out if its group states it as ``shared``."""
    if look.stroke is not None:
        opacity = "" if look.opacity == OPAQUE else opacity_attribute(look.opacity, "stroke")
        return (
            f'<{shape.element} fill="none" stroke="{look.paint}"{look.stroke}{opacity}{look.blur}{shape.attributes}/>'
        )
    opacity = "" if look.opacity == shared else opacity_attribute(look.opacity)
    return f'<{shape.element} fill="{look.paint}"{opacity}{look.blur}{shape.attributes}/>'


def opacity_attribute(ticks: int, role: str = "fill") -> str:
    """Return the attribute, with the space before it, that states an opacity of "fill" or "stroke"."""
    return f' {role}-opacity="{format_number(ticks, OPACITY_DECIMALS)}"'


def looks_of(
    scene: Scene, precision: int, *, short_ids: bool = False, keeps_opacity: Collection[int] = ()
) -> tuple[list[Look], list[str]]:
    """Return the look of each path, and the lines of the definitions that looks refer to.

    The stops of a gradient state the opacity of its path too, because some programs ignore that of a path beside a
    gradient; but not for the paths ``keeps_opacity``, which are in a group that states it.
    """
    opacity = ticks_of(scene.opacity, OPAQUE)
    in_stops = torch.zeros_like(opacity, dtype=torch.bool) if scene.gradients is None else scene.gradients.kind != FLAT
    in_stops[list(keeps_opacity)] = False
    of_stops, own = (torch.where(where, opacity, OPAQUE).tolist() for where in (in_stops, ~in_stops))
    fills, blurs, definitions = _paints_of(scene, of_stops, short_ids)
    return list(map(Look, fills, own, _strokes_of(scene, precision), blurs)), definitions


def _strokes_of(scene: Scene, precision: int) -> list[str | None]:
    """Return the attributes of each stroke but for its paint, each with a space before it; None for fills."""
    strokes = scene.strokes
    if strokes is None:
        return [None] * len(scene)
    decimals = width_decimals(precision)
    widths = ticks_of(strokes.width, 10**decimals).tolist()
    limits = ticks_of(strokes.miter_limit, 10**MITER_DECIMALS).tolist()
    rows = zip(widths, strokes.cap.tolist(), strokes.join.tolist(), limits, strict=True)
    return [_stroke_attributes(*row, decimals) if row[0] else None for row in rows]


def _stroke_attributes(width: int, cap: int, join: int, limit: int, decimals: int) -> str:
    text = f' stroke-width="{format_number(width, decimals)}"'
    text += "" if cap == BUTT else f' stroke-linecap="{CAPS[cap]}"'
    if join != MITER:
        return text + f' stroke-linejoin="{JOINS[join]}"'
    usual = round(MITER_LIMIT * 10**MITER_DECIMALS)
    return text + ("" if limit == usual else f' stroke-miterlimit="{format_number(limit, MITER_DECIMALS)}"')


def shapes_of(
    scene: Scene, precision: int, has_arcs: bool = True, has_dashes: bool = False, closes_exactly: bool = False
) -> list[Shape]:
    """Return the shape of each path: its form, a dashed line, or the data of its outline."""
    shapes = _dashed_shapes(scene, precision) if has_dashes else {}
    if scene.forms is None and not shapes:
        return list(map(path_shape, path_data(scene, precision, has_arcs, closes_exactly)))
    shapes |= {} if scene.forms is None else form_shapes(scene.forms, precision)
    outlines = torch.tensor([path for path in range(len(scene)) if path not in shapes], dtype=torch.int64)
    data = path_data(scene.select(outlines), precision, has_arcs, closes_exactly)
    shapes |= {path: path_shape(each) for path, each in zip(outlines.tolist(), data, strict=True)}
    return [shapes[path] for path in range(len(scene))]


def _dashed_shapes(scene: Scene, precision: int) -> dict[int, Shape]:
    """Return the shape of each path that is a dashed line: a line, and the lengths of its dashes and gaps.

    Whose numbers have fewer decimals than the file is left out, unless a reader with so many finds the same dashes.
    """
    shapes = {}
    for path, rows in paths_of_lines(scene).items():
        dashes = dashes_of(ticks_of(scene.segments[rows, 0], 10**precision).numpy().reshape(-1, 2, 2))
        if dashes is not None:
            ends = np.repeat(np.stack([dashes.start, dashes.end])[:, None], 3, 1)
            data = format_path([Loop(ends, np.array([True, True]), is_open=True)], precision)
            array = " ".join(format_number(length, precision) for length in dashes.lengths)
            is_level = bool((dashes.start == dashes.end).any())
            if is_level or max(map(decimals_of, (data, array))) == precision:
                shapes[path] = Shape("path", f' stroke-dasharray="{array}" d="{data}"')
    return shapes


def path_shape(data: str) -> Shape:
    """Return the shape of a path with ``data``."""
    return Shape("path", f' d="{data}"')


def path_data(scene: Scene, precision: int, has_arcs: bool = True, closes_exactly: bool = False) -> list[str]:
    """Return the ``d`` of each path, with arcs or without, that closes exactly or not.

    The choice between the two forms depends only on what a reader of the file finds as well, so that a file that is
    read and written again has the same bytes: not on rows of no length, which are left out.
    """
    ticks, structure = ticks_of(scene.segments, 10**precision).numpy(), scene.structure
    is_line = _line_rows(scene)
    has_lines = (is_line & (ticks[structure.segment_next.numpy(), 0] != ticks[:, 0]).any(1)).any()
    is_exact = closes_exactly and precision > 0
    if structure.loop_count == len(scene) and not has_lines and structure.is_open is None and not is_exact:
        return format_curves(ticks, structure.loop_first_segment.numpy().astype(np.int64), precision)
    rows, loops = structure.loop_first_segment.tolist(), structure.path_first_loop.tolist()
    is_open = [False] * structure.loop_count if structure.is_open is None else structure.is_open.tolist()
    spans = zip(pairwise(rows), is_open, strict=True)
    parts = [Loop(ticks[start:stop], is_line[start:stop], opened) for (start, stop), opened in spans]
    return [format_path(parts[start:stop], precision, has_arcs, is_exact) for start, stop in pairwise(loops)]


def closes_by_lines(scene: Scene) -> NDArray[np.bool_] | None:
    """Return the rows [R] that are the line which closes a path; None if any has several loops, other lines or ends.

    ``scene`` has whole numbers of ticks, as those of its file.
    """
    structure = scene.structure
    if structure.loop_count != len(scene) or structure.is_open is not None:
        return None
    is_line = _line_rows(scene)
    is_last = np.zeros_like(is_line)
    is_last[structure.loop_first_segment.numpy()[1:] - 1] = True
    return None if (is_line & ~is_last).any() else is_line & is_last


def _line_rows(scene: Scene) -> NDArray[np.bool_]:
    """Return which rows [R] are lines."""
    is_line = scene.structure.is_line
    return np.zeros(len(scene.segments), np.bool_) if is_line is None else is_line.numpy()


def _paints_of(scene: Scene, opacity: list[int], short_ids: bool) -> tuple[list[str], list[str], list[str]]:
    """Return the ``fill`` of each path, the attribute that blurs it, and the lines of the definitions of both.

    ``opacity`` in ticks is that which the stops of a path's gradient state beside their own. Equal gradients are one,
    and so are equal blurs. An id follows from the text of the gradient or blur, so that two files on one page have the
    same id only for the same text. With ``short_ids``, ids are as short as can be.
    """

    def blur_name(text: str, taken: list[str]) -> str:
        return f"b{len(taken) + 1}" if short_ids else _content_id(text, taken, "b")

    fills, gradients = _fills_of(scene, opacity, short_ids)
    blurs, filters = blurs_of(scene, blur_name)
    lines = [*gradients, *filters]
    return fills, blurs, ["<defs>", *lines, "</defs>"] if lines else []


def _fills_of(scene: Scene, opacity: list[int], short_ids: bool) -> tuple[list[str], list[str]]:
    """Return the ``fill`` of each path, and the gradients."""
    fills = hex_colors(scene.color)
    if scene.gradients is None:
        return fills, []
    gradients, names = scene.gradients, dict[str, str]()
    places = ticks_of(gradients.whole_geometry, 10**GRADIENT_DECIMALS).tolist()
    stops = _stop_lists(scene.color, gradients, opacity)
    for row, kind in enumerate(gradients.kind.tolist()):
        if kind != FLAT:
            text = _gradient(kind, places[row], stops[row])
            if text not in names:
                names[text] = f"g{len(names) + 1}" if short_ids else _content_id(text, names.values())
            fills[row] = f"url(#{names[text]})"
    return fills, [text.replace(" ", f' id="{name}" ', 1) for text, name in names.items()]


def _content_id(text: str, taken: Collection[str], letter: str = "g") -> str:
    """Return an id that begins with ``letter``, follows from ``text``, and is none of those ``taken``."""
    digits = sha256(text.encode()).hexdigest()
    return next(name for count in range(6, len(digits)) if (name := letter + digits[:count]) not in taken)


def _stop_lists(color: Tensor, gradients: Gradients, opacity_of_path: list[int]) -> list[str]:
    """Return the elements of the stops of each path, whose first ones have the ``color`` [N, 3].

    Their opacity is multiplied by ``opacity_of_path``, in ticks.
    """
    stops, count = gradients.all_stops(), len(color)
    colors = hex_colors(stops.colors(color, gradients.end_color).reshape(-1, 3))
    offsets = ticks_of(stops.shown_offsets(), 10**OFFSET_DECIMALS).tolist()
    factor = torch.tensor(opacity_of_path, dtype=torch.float64)[:, None] / OPAQUE
    opacity = ticks_of(factor * stops.opacity, 10**STOP_OPACITY_DECIMALS).tolist()
    shades = [colors[start : start + STOPS_MAX] for start in range(0, count * STOPS_MAX, STOPS_MAX)]
    lists = zip(stops.count.tolist(), offsets, shades, opacity, strict=True)
    return ["".join(map(_stop, *(each[:number] for each in (a, b, c)))) for number, a, b, c in lists]


def _stop(offset: int, color: str, opacity: int) -> str:
    """Return the element of a stop, whose offset and opacity are in ticks."""
    is_opaque = opacity == 10**STOP_OPACITY_DECIMALS
    shown = "" if is_opaque else f' stop-opacity="{format_number(opacity, STOP_OPACITY_DECIMALS)}"'
    return f'<stop offset="{format_number(offset, OFFSET_DECIMALS)}" stop-color="{color}"{shown}/>'


def _gradient(kind: int, geometry: list[int], stops: str) -> str:
    paint = kind_of(kind)
    attributes = paint.attributes([format_number(ticks, GRADIENT_DECIMALS) for ticks in geometry])
    places = (f'{side}="{text}"' for side, text in attributes.items())
    return f'<{paint.element} gradientUnits="userSpaceOnUse" {" ".join(places)}>{stops}</{paint.element}>'


def hex_colors(color: Tensor) -> list[str]:
    """Return ``#rrggbb``, or ``#rgb`` if that is the same colour, for each row of ``color`` [N, 3]."""
    names = (bytes(levels).hex() for levels in ticks_of(color, COLOR_LEVELS).tolist())
    return ["#" + (name[::2] if name[::2] == name[1::2] else name) for name in names]
