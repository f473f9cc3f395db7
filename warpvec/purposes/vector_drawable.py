"""Write a drawing as a VectorDrawable, a picture of Android's apps (android.graphics.drawable.VectorDrawable).

It has paths with fills, strokes and gradients whose stops have opacities, and groups, which have the names of layers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.sax.saxutils import quoteattr

from warpvec.purposes.table import ANDROID
from warpvec.purposes.texts import text_for
from warpvec.svg.document import local_name, parse_svg
from warpvec.svg.units import physical_size, stated_size

_PER_INCH = 160.0
"""Units "dp" of Android per inch."""

_NAMES = {
    "fill-opacity": "fillAlpha", "stroke-opacity": "strokeAlpha", "stroke-width": "strokeWidth",
    "stroke-linecap": "strokeLineCap", "stroke-linejoin": "strokeLineJoin", "stroke-miterlimit": "strokeMiterLimit",
    "d": "pathData",
}  # fmt: skip
"""Attribute of a path of SVG -> that of Android."""

_GRADIENT_NAMES = {
    "x1": "startX", "y1": "startY", "x2": "endX", "y2": "endY", "cx": "centerX", "cy": "centerY", "r": "gradientRadius",
}  # fmt: skip

_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"


def vector_drawable(svg: str) -> str:
    """Return the text of the VectorDrawable of an SVG; what it cannot state is drawn by other means.

    Raises:
        InputError: as `warpvec.purposes.texts.text_for`.
    """
    builder = ElementTree.TreeBuilder()
    document = parse_svg(text_for(svg, ANDROID).text, builder)
    root = builder.close()
    size = physical_size(document.root)
    across, down = stated_size(document.root) if size is None else (side / 25.4 * _PER_INCH for side in size)
    box = root.get("viewBox", "").split()
    gradients = {f"url(#{each.get('id')})": each for each in root.iter() if "Gradient" in each.tag}
    lines = [
        '<vector xmlns:android="http://schemas.android.com/apk/res/android" xmlns:aapt="http://schemas.android.com/aapt"',
        f'    android:width="{across:.6g}dp" android:height="{down:.6g}dp"'
        f' android:viewportWidth="{box[2]}" android:viewportHeight="{box[3]}">',
        *(line for child in root for line in _element(child, gradients)),
        "</vector>",
    ]
    return "\n".join(lines) + "\n"


def _element(element: Element, gradients: Mapping[str, Element]) -> Iterator[str]:
    name = local_name(element.tag)
    if name == "g":
        label = element.get(_LABEL)
        yield "<group>" if label is None else f"<group android:name={quoteattr(label)}>"
        for child in element:
            yield from _element(child, gradients)
        yield "</group>"
    elif name == "rect":  # the background
        data = f"M0 0h{element.get('width')}v{element.get('height')}h-{element.get('width')}z"
        yield f'<path android:fillColor="{element.get("fill")}" android:pathData="{data}"/>'
    elif name == "path":
        yield from _path(element, gradients)


def _path(path: Element, gradients: Mapping[str, Element]) -> Iterator[str]:
    stated = [f' android:{_NAMES[name]}="{text}"' for name, text in path.attrib.items() if name in _NAMES]
    inner = []
    for role in ("fill", "stroke"):
        paint = path.get(role, "none")
        if paint in gradients:
            inner.append(f'<aapt:attr name="android:{role}Color">\n{_gradient(gradients[paint])}\n</aapt:attr>\n')
        elif paint != "none":
            stated.insert(0, f' android:{role}Color="{paint}"')
    head = f"<path{''.join(stated)}"
    # Android Studio shows a gradient only with line ends around it and its attribute.
    yield f"{head}>\n{''.join(inner)}</path>" if inner else f"{head}/>"


def _gradient(gradient: Element) -> str:
    kind = local_name(gradient.tag).removesuffix("Gradient")
    places = "".join(
        f' android:{android}="{gradient.get(side)}"' for side, android in _GRADIENT_NAMES.items() if gradient.get(side)
    )
    items = "".join(
        f'<item android:offset="{stop.get("offset")}" android:color="{_color(stop)}"/>' for stop in gradient
    )
    return f'<gradient android:type="{kind}"{places}>{items}</gradient>'


def _color(stop: Element) -> str:
    """Return "#aarrggbb"."""
    digits = stop.get("stop-color", "#000")[1:]
    digits = digits if len(digits) == 6 else re.sub("(.)", r"\1\1", digits)
    return f"#{round(255 * float(stop.get('stop-opacity', '1'))):02x}{digits}"
