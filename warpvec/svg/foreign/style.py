"""Which paint an element of an SVG has: attributes, style sheets and style attributes, in CSS's order.

Of style sheets the selectors that drawing programs write are known: ``*``, ``tag``, ``.class``, ``tag.class`` and
``#id``, and lists of these.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from warpvec.svg.scan import SVG_NAMESPACE

INHERITED = {
    "fill": "black", "fill-opacity": "1", "fill-rule": "nonzero", "stroke": "none", "stroke-width": "1",
    "stroke-opacity": "1", "color": "black", "visibility": "visible", "marker-start": "none", "marker-mid": "none",
    "marker-end": "none",
}  # fmt: skip
"""Properties that pass from an element to its children (SVG 1.1, appendix N), with their first values."""

OWN = {
    "opacity": "1", "display": "inline", "clip-path": "none", "mask": "none", "filter": "none",
    "mix-blend-mode": "normal", "transform": "none", "stop-color": "black", "stop-opacity": "1",
}  # fmt: skip
"""Properties that each element has for itself."""

Properties = dict[str, str]

# One that never ends takes the rest, so that the time is linear.
_COMMENT = re.compile(r"/\*(?:.*?\*/|.*)", re.DOTALL)
_KNOWN_SELECTOR = re.compile(r"\*|#[\w-]+|\w+|\w*\.[\w-]+")


class StyleSheet:
    """The rules of all <style> elements below ``root``.

    Attributes:
        unknown: selectors that were not understood.
    """

    def __init__(self, root: Element) -> None:
        self.unknown: list[str] = []
        self._rules: dict[str, Properties] = {}
        for element in root.iter():
            if local_name(element) == "style":
                self._add("".join(element.itertext()))

    def properties(self, element: Element, inherited: Properties) -> Properties:
        """All properties of ``element``, a child of one whose properties are ``inherited``."""
        attributes = {name: value.strip() for name, value in element.attrib.items() if name in INHERITED or name in OWN}
        declared = attributes | self._from_rules(element) | _declarations(element.get("style", ""))
        passed_on = {name: inherited[name] for name in INHERITED}
        return passed_on | OWN | {name: value for name, value in declared.items() if value != "inherit"}

    def _add(self, text: str) -> None:
        for rule in _COMMENT.sub("", text).split("}"):
            selectors, brace, body = rule.partition("{")
            for selector in selectors.split(",") if brace else ():
                self._declare(selector.strip(), _declarations(body))

    def _declare(self, selector: str, declarations: Properties) -> None:
        if _KNOWN_SELECTOR.fullmatch(selector):
            self._rules.setdefault(selector, {}).update(declarations)
        else:
            self.unknown.append(selector)

    def _from_rules(self, element: Element) -> Properties:
        """What the rules declare for ``element``, the more specific selectors last (CSS 2.1, section 6.4.3)."""
        if not self._rules:
            return {}
        tag, classes = local_name(element), element.get("class", "").split()
        selectors = ["*", tag, *("." + name for name in classes), *(f"{tag}.{name}" for name in classes)]
        found: Properties = {}
        for selector in (*selectors, "#" + element.get("id", "")):
            found |= self._rules.get(selector, {})
        return found


def local_name(element: Element) -> str:
    """The name of an SVG element; "" for a comment, and for an element of another namespace."""
    if not isinstance(element.tag, str):
        return ""
    namespace, _, name = element.tag.rpartition("}")
    return name if namespace in ("", "{" + SVG_NAMESPACE) else ""


def _declarations(text: str) -> Properties:
    return dict(_declared(text))


def _declared(text: str) -> Iterator[tuple[str, str]]:
    for declaration in text.split(";"):
        name, colon, value = declaration.partition(":")
        name, value = name.strip().lower(), value.replace("!important", "").strip()
        if colon and value and (name in INHERITED or name in OWN):
            yield name, value
