"""SVGs as parts of web pages: the colour of the text around them, symbols for sprites, and React components.

Ids in these texts begin with a name of their own, so that several drawings on one page do not share any.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.sax.saxutils import escape, quoteattr

from warpvec.errors import InputError
from warpvec.image.luma import LUMA
from warpvec.svg.document import SVG_NAMESPACE, local_name, parse_svg

DARKEST = "darkest"
"""Stands for the darkest colour of a drawing."""

_PAINT = re.compile(
    r'(<(?!rect (?:id="background" )?width=)[^<>]*?\b(?:fill|stroke)=")(#[0-9a-f]{3}|#[0-9a-f]{6})(?=")'
)
"""The colour of a shape of warpvec's own files. The background is a rectangle whose first attribute is its width."""

_REFERENCE = re.compile(r"url\(#([^()]+)\)")

_LINKS = "http://www.w3.org/1999/xlink"
"""Namespace of links. Inkscape 1.2, paper and others follow no link without it."""

_NAMES_IN_JSX = {"class": "className", "xlink:href": "xlinkHref"}

_UNDRAWN = ("metadata", "desc")


def with_current_color(svg: str, color: str) -> str:
    """Return ``svg`` with "currentColor" for the paint that is nearest to ``color``: it follows the text of a page.

    Args:
        svg: text of a file of warpvec.
        color: "#rrggbb", or ``DARKEST``.
    """
    found = list(dict.fromkeys(match[2] for match in _PAINT.finditer(svg)))
    if not found:
        return svg
    away = _brightness if color == DARKEST else _distance_from(color)
    chosen = min(found, key=away)
    return _PAINT.sub(lambda match: match[1] + ("currentColor" if match[2] == chosen else match[2]), svg)


def _brightness(color: str) -> float:
    return sum(weight * level for weight, level in zip(LUMA, _levels(color), strict=True))


def _distance_from(color: str) -> Callable[[str], float]:
    wanted = _levels(color)
    return lambda other: sum((a - b) ** 2 for a, b in zip(wanted, _levels(other), strict=True))


def _levels(color: str) -> tuple[int, ...]:
    digits = color[1:] if len(color) == 7 else "".join(2 * digit for digit in color[1:])
    return tuple(bytes.fromhex(digits))


def as_symbol(svg: str, name: str) -> str:
    """Return ``svg`` as a file of one symbol with the id ``name``, and one use of it, so that viewers show it.

    Raises:
        InputError: as `warpvec.svg.document.parse_svg`.
    """
    root = _cleaned(svg, name)
    width, height, box = (root.get(side, "") for side in ("width", "height", "viewBox"))
    inner = "\n".join(_text(child, _xml_attributes, escape) for child in root)
    return (
        f'<svg xmlns="{SVG_NAMESPACE}" xmlns:xlink="{_LINKS}" width="{width}" height="{height}" viewBox="{box}">\n'
        f'<symbol id="{name}" viewBox="{box}">\n{inner}\n</symbol>\n<use xlink:href="#{name}"/>\n</svg>\n'
    )


def as_component(svg: str, name: str) -> str:
    """Return ``svg`` as the text of a React component called ``name``, whose props go to its <svg>.

    Raises:
        InputError: as `warpvec.svg.document.parse_svg`.
    """
    root = _cleaned(svg, name)
    sides = "".join(f" {key}={value}" for key, value in _jsx_attributes(root))
    inner = "\n".join(f"      {_text(child, _jsx_attributes, _jsx_text)}" for child in root)
    return (
        f"export default function {name}(props) {{\n  return (\n"
        f'    <svg xmlns="{SVG_NAMESPACE}"{sides} {{...props}}>\n{inner}\n    </svg>\n  );\n}}\n'
    )


def component_name(stem: str) -> str:
    """Return the name of the component in a file called ``stem``: "my-logo 2" becomes "MyLogo2"."""
    name = "".join(word[0].upper() + word[1:] for word in re.findall(r"[A-Za-z0-9]+", stem))
    return name if name[:1].isalpha() else f"Drawing{name}"


def check_id(name: str, value: object) -> str | None:
    """Return the id ``value`` of a symbol; None stays None.

    Raises:
        InputError: it is no id that CSS and URLs take without escapes.
    """
    if value is None:
        return None
    if not (isinstance(value, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,99}", value)):
        rule = "must be letters, digits, - and _, and begin with a letter"
        raise InputError(name, rule, repr(value), "give one such as logo")
    return value


def _cleaned(svg: str, prefix: str) -> Element:
    """Return the root without names of namespaces, metadata, and ids that nothing refers to.

    The other ids begin with ``prefix``.
    """
    builder = ElementTree.TreeBuilder()
    parse_svg(svg, builder)
    root = builder.close()
    used = {name for each in root.iter() for text in each.attrib.values() for name in _REFERENCE.findall(text)}
    for each in root.iter():
        each.tag, each.tail = local_name(each.tag), None
        each.attrib = {name: text for name, text in each.attrib.items() if not name.startswith("{")}
        if each.get("id") in used:
            each.set("id", f"{prefix}-{each.get('id')}")
        else:
            each.attrib.pop("id", None)
        for name, text in each.attrib.items():
            each.set(name, _REFERENCE.sub(rf"url(#{prefix}-\1)", text))
        for child in [child for child in each if local_name(child.tag) in ("", *_UNDRAWN)]:
            each.remove(child)
    return root


def _text(
    element: Element, attributes: Callable[[Element], Iterator[tuple[str, str]]], content: Callable[[str], str]
) -> str:
    head = element.tag + "".join(f" {name}={value}" for name, value in attributes(element))
    text = content(element.text) if element.text and element.text.strip() else ""
    inner = text + "".join(_text(child, attributes, content) for child in element)
    return f"<{head}>{inner}</{element.tag}>" if inner else f"<{head}/>"


def _xml_attributes(element: Element) -> Iterator[tuple[str, str]]:
    for name, text in element.attrib.items():
        yield name, quoteattr(text)


def _jsx_attributes(element: Element) -> Iterator[tuple[str, str]]:
    for name, text in element.attrib.items():
        if name == "style":
            pairs = (part.partition(":") for part in text.split(";") if part.strip())
            values = {_camel(key.strip()): value.strip() for key, _, value in pairs}
            yield name, "{" + json.dumps(values) + "}"
        else:
            is_plain = not re.search(r'["&{}\\\n]', text)
            yield _NAMES_IN_JSX.get(name, _camel(name)), f'"{text}"' if is_plain else "{" + json.dumps(text) + "}"


def _camel(name: str) -> str:
    return re.sub(r"[-:]([a-z])", lambda match: match[1].upper(), name)


def _jsx_text(text: str) -> str:
    return "{" + json.dumps(text) + "}"
