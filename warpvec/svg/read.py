"""Read an SVG as a scene: warpvec's own files exactly, files of other programs as far as a scene can represent them.

The text may have ``MAX_CHARACTERS``. `warpvec.svg.document`, `warpvec.svg.foreign.reader` and `warpvec.geometry.loops`
have further limits.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from warpvec.errors import InputError
from warpvec.geometry.loops import Color, Outline, OutlineGradient, OutlineStop, OutlineStroke, make_scene
from warpvec.geometry.paints.kind import GradientKind
from warpvec.geometry.paints.registry import KINDS
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX
from warpvec.geometry.strokes import BUTT, CAPS, JOINS, MITER, MITER_LIMIT, MITER_LIMIT_MAX
from warpvec.svg.blurs import read_blur
from warpvec.svg.dashes import read_dashes
from warpvec.svg.document import layer_level, local_name, parse_svg, read_text
from warpvec.svg.form_elements import FORM_ATTRIBUTES, FORM_ELEMENTS, form_decimals, read_form
from warpvec.svg.path_data import OWN_NUMBER, decimals_of, is_own_data, read_loops, with_points
from warpvec.svg.quantize import COLOR_LEVELS, MAX_TICKS, MIN_WIDTH_DECIMALS, OPACITY_DECIMALS
from warpvec.svg.units import check_pixels, stated_size
from warpvec.svg.write import layer_id, layer_name

_Paint = tuple[Color, OutlineGradient | None]


class _Definitions(NamedTuple):
    """What paths refer to: by the fill, the first colour and the rest of a gradient; by the filter, its blur."""

    paints: dict[str, _Paint]
    blurs: dict[str, float]


MAX_CHARACTERS = 2**26
"""Longest text. A path of four cubics takes about 80 characters, so this is a hundred times what warpvec fits."""

_OWN_OPACITY = re.compile(r"0|1|\.\d{1,6}|0\.\d{1,6}", re.ASCII)
_OWN_COLOR = re.compile(r"#(?>[0-9a-f]{6}|[0-9a-f]{3})")
_OWN_BOX = re.compile(r"0 0 ([1-9]\d{0,8}) ([1-9]\d{0,8})", re.ASCII)
_OWN_SIDE = re.compile(r"\d{1,9}(\.\d{1,9})?(mm|cm|in|pt)?", re.ASCII)
_ROUNDED_SIDE = 0.005
"""Largest share by which a stated side is rounded: two sides of a very small drawing have few digits."""

_OWN_STROKE = ("stroke-width", "stroke-linecap", "stroke-linejoin", "stroke-miterlimit")
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_SHAPES = FORM_ELEMENTS | {"path"}
_OWN_ATTRIBUTES = {"path": ("d",), **dict.fromkeys(FORM_ELEMENTS, tuple(FORM_ATTRIBUTES))}
_CURVES_OF_PHOTO = re.compile(r"M[^A-Za-z]*+c[^A-Za-z]*+z")
_UNDRAWN = frozenset({"title", "desc", "metadata"})


@dataclass(frozen=True)
class LoadedSvg:
    """An SVG as a scene.

    Attributes:
        scene: the filled paths. A rectangle that covers the canvas is the background; without one the scene is
            transparent.
        width, height: the size in pixels, which are the units of the scene.
        omitted: a remark for each kind of thing that the scene does not show, with its count and what was done.
        precision: decimals of the coordinates in warpvec's own files, None for other files.
        sides: width and height as warpvec's own file states them, with their units, if these are not pixels.
        layer_names: names of the layers of warpvec's own file by generation, if they have names.
        minified: whether warpvec's own file has the form of `warpvec.svg.minify.write_minified`.
        sources: for each path the place of its shape in the file of another program, where a shape can be several
            paths or none; None in warpvec's own files, which have a shape for each path.
        shape_count: number of shapes in the file of another program; None in warpvec's own files.
        closes_exactly: whether a file that keeps the form of this one closes its loops exactly. Only warpvec's own
            files of photos do not; they have nothing but loops of relative curves.
    """

    scene: Scene
    width: float
    height: float
    omitted: list[str] = field(default_factory=list)
    precision: int | None = None
    sides: tuple[str, str] | None = None
    layer_names: dict[int, str] | None = None
    minified: bool = False
    closes_exactly: bool = True
    sources: tuple[int, ...] | None = None
    shape_count: int | None = None


def read_svg(source: bytes | str) -> LoadedSvg:
    """Read the drawing in an ``.svg`` or ``.svgz`` file, given as its bytes or its text.

    A file that has only what `warpvec.svg.write.write_svg` writes is read exactly: written again with as many decimals,
    its paths have the same bytes. Layers and paths may have been taken out, reordered, moved or recoloured. Any other
    file is read through svgelements: transforms are applied; shapes become paths; lines, quadratics and arcs become
    cubics; opacities are multiplied. Its top-level groups are generations 0, 1, ... unless their ``id`` states others.

    Raises:
        InputError: ``source`` is not an SVG, is refused as unsafe, is too large, or has too many curves; or it is not
            warpvec's own and svgelements is not installed.
    """
    text = read_text(source)
    if len(text) > MAX_CHARACTERS:
        raise InputError("SVG", f"must have at most {MAX_CHARACTERS} characters", str(len(text)), "simplify it")
    builder = ElementTree.TreeBuilder()
    check_pixels(*stated_size(parse_svg(text, builder).root))
    root = builder.close()
    try:
        return replace(_read_own(root), minified=_is_minified(text, root))
    except _NotOurs:
        return _read_foreign(root)


class _NotOurs(Exception):
    """The file has something that `write_svg` never writes."""


def _read_own(root: Element) -> LoadedSvg:
    box = _OWN_BOX.fullmatch(root.get("viewBox", ""))
    stated = root.get("width", ""), root.get("height", "")
    if box is None or not all(_OWN_SIDE.fullmatch(side) for side in stated) or root.get("style"):
        raise _NotOurs
    width, height = box.groups()
    _expect(root.get("preserveAspectRatio") is None and _is_in_proportion(root, float(width), float(height)))
    children = [child for child in root if local_name(child.tag) not in ("", *_UNDRAWN)]
    has_definitions = bool(children) and local_name(children[0].tag) == "defs"
    definitions = _own_definitions(children.pop(0)) if has_definitions else _Definitions({}, {})
    has_background = bool(children) and local_name(children[0].tag) == "rect" and "x" not in children[0].attrib
    background = _read_background(children.pop(0), width, height) if has_background else None
    elements = list(_own_paths(children))
    decimals = max((_own_decimals(path.element) for path in elements), default=0)
    outlines = [_own_outline(path, decimals, definitions) for path in elements]
    return LoadedSvg(
        make_scene(outlines, background),
        float(width),
        float(height),
        precision=decimals,
        sides=None if stated == (width, height) else stated,
        layer_names=_own_layer_names(children),
        closes_exactly=len(elements) < 2 or not all(map(_is_of_photo, elements)),
    )


def _is_of_photo(path: _OwnPath) -> bool:
    """Return whether a path is written as those of photos are. One alone says nothing."""
    return _CURVES_OF_PHOTO.fullmatch(path.element.get("d", "")) is not None


def _is_in_proportion(root: Element, width: float, height: float) -> bool:
    """Return whether the stated size has the proportions of the view box, but for rounding: it moves nothing then."""
    across, down = stated_size(root.attrib)
    return abs(across * height - down * width) <= _ROUNDED_SIDE * down * width


def _read_foreign(root: Element) -> LoadedSvg:
    from warpvec.svg.foreign.reader import ForeignReader

    reader = ForeignReader(root)
    scene = make_scene(reader.painter.outlines, reader.painter.background)
    sources = tuple(reader.sources)
    return LoadedSvg(scene, *reader.size, reader.omitted, sources=sources, shape_count=reader.shape_count)


def _expect(condition: bool) -> None:
    if not condition:
        raise _NotOurs


def _expect_attributes(element: Element, known: Sequence[str]) -> None:
    """Expect only ``known`` attributes. Those of other namespaces are for editors and do not matter."""
    _expect(all(name in known or name.startswith("{") for name in element.attrib))


def _read_background(rect: Element, width: str, height: str) -> Color:
    _expect_attributes(rect, ("id", "width", "height", "fill"))
    _expect(rect.get("width") == width and rect.get("height") == height and len(rect) == 0)
    return _own_color(rect)


class _OwnPath(NamedTuple):
    """A path with the attributes of its group."""

    element: Element
    generation: int
    opacity: str


def _own_paths(children: Sequence[Element]) -> Iterator[_OwnPath]:
    """Yield each path. All paths are in groups, and no group in another; or there are no groups."""
    if children and all(local_name(child.tag) in _SHAPES for child in children):
        yield from (_own_path(path, 0, "1") for path in children)
        return
    for index, group in enumerate(children):
        _expect(local_name(group.tag) == "g")
        _expect_attributes(group, ("id", "fill-opacity"))
        for path in group:
            yield _own_path(path, layer_level(group.get("id"), index), group.get("fill-opacity", "1"))


def _own_path(path: Element, generation: int, opacity: str) -> _OwnPath:
    name = local_name(path.tag)
    _expect(name in _SHAPES and len(path) == 0)
    if "stroke" in path.attrib:
        dashed = ("stroke-dasharray",) if name == "path" else ()
        own = ("id", "fill", "stroke", "stroke-opacity", "filter", *_OWN_STROKE, *dashed, *_OWN_ATTRIBUTES[name])
        _expect_attributes(path, own)
        _expect(path.get("fill") == "none")
        return _OwnPath(path, generation, path.get("stroke-opacity", "1"))
    _expect_attributes(path, ("id", "fill", "fill-opacity", "filter", *_OWN_ATTRIBUTES[name]))
    return _OwnPath(path, generation, path.get("fill-opacity", opacity))


def _is_minified(text: str, root: Element) -> bool:
    """Return whether warpvec's own file has one line, and neither names nor settings."""
    children = [local_name(child.tag) for child in root]
    has_names = any(child.get("id") for child in root) or any(name in _UNDRAWN for name in children)
    has_shapes = bool({"g", *(_SHAPES - {"rect"})} & set(children)) or any("x" in child.attrib for child in root)
    return "\n" not in text.strip() and not has_names and has_shapes


def _own_layer_names(groups: Sequence[Element]) -> dict[int, str] | None:
    """Return the names of the layers by generation; None unless all have names from which their ids come."""
    identifiers = [group.get("id", "") for group in groups]
    labels = [layer_name(group.get(_LABEL, ""), name) for group, name in zip(groups, identifiers, strict=True)]
    names = {
        layer_level(name, index): label for index, (name, label) in enumerate(zip(identifiers, labels, strict=True))
    }
    return names if groups and all(names.values()) and list(map(layer_id, names.values())) == identifiers else None


def _own_outline(path: _OwnPath, decimals: int, definitions: _Definitions) -> Outline:
    softness, gradients = 0.0, definitions.paints
    if "filter" in path.element.attrib:
        blur = definitions.blurs.get(path.element.get("filter", ""))
        if blur is None:
            raise _NotOurs
        softness = blur
    stroke, name = _own_stroke(path.element), local_name(path.element.tag)
    role = "fill" if stroke is None else "stroke"
    paint = path.element.get(role, "")
    color, gradient = gradients[paint] if paint in gradients else (_own_color(path.element, role), None)
    _expect(_OWN_OPACITY.fullmatch(path.opacity) is not None)
    if gradient is not None:
        _expect("transform" not in path.element.attrib)  # older versions wrote it; it turns the gradient too
        path, gradient = _with_one_opacity(path, gradient)
    if name == "path":
        outline = _own_loops(path, color, decimals)
        return replace(outline, gradient=gradient, stroke=stroke, softness=softness)
    form = read_form(name, path.element.attrib, decimals)
    if form is None:
        raise _NotOurs
    outline = Outline.of_form(form, color, float(path.opacity), path.generation)
    return replace(outline, gradient=gradient, stroke=stroke, softness=softness)


def _with_one_opacity(path: _OwnPath, gradient: OutlineGradient) -> tuple[_OwnPath, OutlineGradient]:
    """Return an opaque path and its gradient with the opacity of the stops as that of the path, if these are alike."""
    if gradient.stops is None:
        return path, gradient
    even = gradient.stops[0].opacity
    is_even = all(stop.opacity == even for stop in gradient.stops) and round(even, OPACITY_DECIMALS) == even
    if float(path.opacity) != 1.0 or not is_even:
        return path, gradient
    stops = tuple(stop._replace(opacity=1.0) for stop in gradient.stops)
    return path._replace(opacity=f"{even:.{OPACITY_DECIMALS}f}"), gradient._replace(stops=stops)


def _own_loops(path: _OwnPath, color: Color, decimals: int) -> Outline:
    """Return the outline of a path without its gradient and stroke."""
    loops = read_loops(_own_data(path.element), decimals)
    if "stroke-dasharray" in path.element.attrib:
        dashes = read_dashes(loops, path.element.get("stroke-dasharray", ""), decimals)
        if dashes is None:
            raise _NotOurs
        loops = dashes
    _expect(all(bool((np.abs(loop.ticks) < MAX_TICKS).all()) for loop in loops))
    points = np.concatenate([loop.ticks.reshape(-1, 2) for loop in loops]) / 10**decimals
    is_line = np.concatenate([loop.is_line for loop in loops])
    counts, is_open = tuple(len(loop.ticks) for loop in loops), tuple(loop.is_open for loop in loops)
    return Outline(points, color, float(path.opacity), path.generation, counts, is_line, is_open=is_open)


def _own_stroke(path: Element) -> OutlineStroke | None:
    """Return how a path is stroked; None if it is filled."""
    if "stroke" not in path.attrib:
        return None
    width, limit = path.get("stroke-width", ""), path.get("stroke-miterlimit", str(MITER_LIMIT))
    _expect(all(OWN_NUMBER.fullmatch(text) for text in (width, limit)))
    _expect(0.0 < float(width) < MAX_TICKS and 1.0 <= float(limit) <= MITER_LIMIT_MAX)
    cap, join = path.get("stroke-linecap", CAPS[BUTT]), path.get("stroke-linejoin", JOINS[MITER])
    _expect(cap in CAPS.values() and join in JOINS.values())
    return OutlineStroke(float(width), _number_of(cap, CAPS), _number_of(join, JOINS), float(limit))


def _number_of(word: str, words: Mapping[int, str]) -> int:
    return next(number for number, known in words.items() if known == word)


def _own_definitions(definitions: Element) -> _Definitions:
    """Return the gradients and blurs of a file."""
    _expect_attributes(definitions, ("id",))
    paints: dict[str, _Paint] = {}
    blurs: dict[str, float] = {}
    for element in definitions:
        blur = read_blur(element)
        if blur is not None:
            blurs[f"url(#{element.get('id')})"] = blur
            continue
        number, kind = _own_kind(element)
        _expect_attributes(element, ("id", "gradientUnits", *kind.sides))
        _expect(element.get("gradientUnits") == "userSpaceOnUse" and 2 <= len(element) <= STOPS_MAX)
        numbers = kind.numbers({side: element.get(side, "") for side in kind.sides})
        _expect(bool(numbers) and all(OWN_NUMBER.fullmatch(text) for text in numbers))
        stops = tuple(_own_stop(stop) for stop in element)
        _expect(all(before.offset <= after.offset <= 1.0 for before, after in pairwise(stops)))
        geometry = tuple(float(text) for text in numbers)
        paint = OutlineGradient(number, geometry, stops[-1].color, stops)
        paints[f"url(#{element.get('id')})"] = stops[0].color, paint
    return _Definitions(paints, blurs)


def _own_kind(element: Element) -> tuple[int, GradientKind]:
    """Return the kind of gradient, and its number, that has this element and just these attributes."""
    given = element.attrib.keys() - {"id", "gradientUnits"}
    for number, kind in KINDS.items():
        if kind.element == local_name(element.tag) and given == set(kind.sides):
            return number, kind
    raise _NotOurs


def _own_stop(stop: Element) -> OutlineStop:
    _expect(local_name(stop.tag) == "stop" and len(stop) == 0)
    _expect_attributes(stop, ("offset", "stop-color", "stop-opacity"))
    offset, opacity = stop.get("offset", "0"), stop.get("stop-opacity", "1")
    _expect(all(_OWN_OPACITY.fullmatch(text) is not None for text in (offset, opacity)))
    return OutlineStop(float(offset), _own_color(stop, "stop-color"), float(opacity))


def _own_color(element: Element, attribute: str = "fill") -> Color:
    digits = element.get(attribute, "")
    _expect(_OWN_COLOR.fullmatch(digits) is not None)
    digits = digits[1:] if len(digits) == 7 else "".join(2 * digit for digit in digits[1:])
    red, green, blue = (level / COLOR_LEVELS for level in bytes.fromhex(digits))
    return red, green, blue


def _own_decimals(path: Element) -> int:
    """Return the most decimals of a path's numbers; the width of a stroke has some in files of whole numbers too."""
    of_width = decimals_of(path.get("stroke-width", ""))
    own = decimals_of(_own_data(path)) if local_name(path.tag) == "path" else form_decimals(path.attrib)
    own = max(own, decimals_of(path.get("stroke-dasharray", "")))
    return max(own, of_width if of_width > MIN_WIDTH_DECIMALS else 0)


def _own_data(path: Element) -> str:
    data, is_stroke = path.get("d", ""), "stroke" in path.attrib
    _expect(is_own_data(data, is_stroke))
    return with_points(data) if is_stroke else data
