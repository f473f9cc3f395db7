"""Shapes of a document: given to warpvec in pixels of the image, and taken back into the place of each."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any

import inkex
from lxml import etree
from warpvec_effect import unused_id
from warpvec_images import SVG
from warpvec_placement import Matrix, Size, compose, is_identity, matrix_text
from warpvec_refusal import Refusal

SHAPES = {SVG + name for name in ("path", "rect", "circle", "ellipse", "polygon")}
"""Elements that have a fill and an outline."""

_SHARED = ("style", "linearGradient", "radialGradient", "clipPath")
"""Elements that others refer to, or take their style from."""

_FRAME = ("id", "x", "y", "width", "height", "viewBox", "preserveAspectRatio")
"""Attributes of an SVG that a group does not have."""

_WHOLE = ("opacity", "clip-path", "mask", "filter", "mix-blend-mode")
"""Properties that belong to a group as a whole. On a path, warpvec makes opacity and clipping part of its fill and
outline, and does not know the others."""

_OUTLINE = ("x", "y", "width", "height", "rx", "ry", "cx", "cy", "r", "points", "d")
_PAINT = ("fill", "fill-opacity", "fill-rule")
_EDITED = ("{http://sodipodi.sourceforge.net/", "{http://www.inkscape.org/namespaces/inkscape}path-effect",
           "{http://www.inkscape.org/namespaces/inkscape}original-d")  # fmt: skip
"""Beginnings of attributes from which Inkscape makes an outline: they would undo the new one."""


def element_matrix(element: Any) -> Matrix:
    """Return the matrix from the user units inside of ``element``'s transform to those of the document.

    Raises:
        Refusal: it is in an SVG in the document's SVG.
    """
    parent = element.getparent()
    if parent is None:
        return (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    if element.tag == SVG + "svg":
        raise Refusal("The image or a path is in an SVG within the document. Ungroup it, then try again.")
    return compose(element_matrix(parent), inkex.Transform(element.get("transform")).to_hexad())


def draft_of(shapes: Iterable[Any], root: Any, pixels: Size, to_pixels: Matrix) -> bytes:
    """Return an SVG of ``pixels`` with the ``shapes`` of the document ``root``.

    Each is in a layer of its own, whose number warpvec writes into the id of the layer in its file.

    Args:
        to_pixels: the matrix from user units of the document to pixels.
    """
    width, height = (f"{side:g}" for side in pixels)
    draft = etree.Element(SVG + "svg", width=width, height=height, viewBox=f"0 0 {width} {height}")
    shared = etree.SubElement(draft, SVG + "defs")
    shared.extend(copy.deepcopy(element) for element in root.iter(*(SVG + name for name in _SHARED)))
    for number, shape in enumerate(shapes):
        layer = etree.SubElement(draft, SVG + "g", id=f"layer-{number + 1}-generation-{number}")
        layer.set("transform", matrix_text(to_pixels))
        for ancestor in reversed(list(shape.iterancestors())):
            layer = etree.SubElement(layer, SVG + "g", _inherited(ancestor))
        layer.append(copy.deepcopy(shape))
    return bytes(etree.tostring(draft))


def _inherited(ancestor: Any) -> dict[str, str]:
    """Return the attributes of ``ancestor`` that its paths inherit, without effects on the group as a whole.

    Somebody who makes a layer translucent to see the image does not want other colours.
    """
    kept = {name: value for name, value in ancestor.attrib.items() if name[0] != "{"}
    for name in (*_FRAME, *_WHOLE):
        kept.pop(name, None)
    style = {name: value for name, value in ancestor.style.items() if name not in _WHOLE}
    return {**kept, "style": str(inkex.Style(style))}


def replace_shape(shape: Any, path: Any, definitions: dict[str, Any], matrix: Matrix) -> None:
    """Give ``shape`` the outline and the fill of ``path``.

    Args:
        definitions: the gradients of the paths by id.
        matrix: from the units of ``path`` to those of ``shape``.
    """
    svg, data = shape.root, path.get("d")
    outline = data if is_identity(matrix) else str(inkex.Path(data).transform(inkex.Transform(matrix)))
    style = {**shape.style, "fill": _fill(path, definitions, matrix, svg), "fill-rule": "nonzero"}
    style["fill-opacity"] = path.get("fill-opacity", "1")
    for name in ("opacity", "clip-path"):
        style.pop(name, None)
    kept = {name: value for name, value in shape.attrib.items() if not name.startswith(_EDITED)}
    for name in (*_OUTLINE, *_PAINT, "opacity", "clip-path"):
        kept.pop(name, None)
    refined = inkex.PathElement()
    refined.attrib.update({**kept, "d": outline, "style": str(inkex.Style(style))})
    refined.extend(shape)
    refined.tail = shape.tail
    shape.getparent().replace(shape, refined)


def _fill(path: Any, definitions: dict[str, Any], matrix: Matrix, svg: Any) -> str:
    """Return the fill of ``path``; a gradient becomes one of ``svg``."""
    fill = str(path.get("fill"))
    if not fill.startswith("url(#"):
        return fill
    gradient = copy.deepcopy(definitions[fill[5:-1]])
    gradient.set("id", unused_id(svg, "refined-gradient"))
    if not is_identity(matrix):
        gradient.set("gradientTransform", matrix_text(matrix))
    svg.defs.append(gradient)
    return "url(#{})".format(gradient.get("id"))
