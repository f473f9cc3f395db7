"""Resolve the properties of SVG elements from attributes, style sheets and style attributes, in the order of CSS.

Supported are the selectors that drawing programs write: ``*``, ``tag``, ``.class``, ``tag.class``, ``#id``, and lists
of these.
"""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element

from warpvec.svg.document import local_name

INHERITED = {
    "fill": "black", "fill-opacity": "1", "fill-rule": "nonzero", "stroke": "none", "stroke-width": "1",
    "stroke-opacity": "1", "color": "black", "visibility": "visible", "marker-start": "none", "marker-mid": "none",
    "marker-end": "none", "stroke-linecap": "butt", "stroke-linejoin": "miter", "stroke-miterlimit": "4",
    "stroke-dasharray": "none", "stroke-dashoffset": "0", "paint-order": "normal", "clip-rule": "nonzero",
}  # fmt: skip
"""Properties that children inherit (SVG 1.1, appendix N), with their initial values."""

OWN = {
    "opacity": "1", "display": "inline", "clip-path": "none", "mask": "none", "filter": "none",
    "mix-blend-mode": "normal", "transform": "none", "stop-color": "black", "stop-opacity": "1",
    "vector-effect": "none", "overflow": "hidden",
}  # fmt: skip
"""Properties that children do not inherit, with their initial values; "overflow" of nested drawings."""

Properties = dict[str, str]

# An unclosed comment matches the rest of the text, so that the time stays linear.
_COMMENT = re.compile(r"/\*(?:.*?\*/|.*)", re.DOTALL)
_KNOWN_SELECTOR = re.compile(r"\*|#[\w-]+|\w+|\w*\.[\w-]+")


class StyleSheet:
    """Rules of all <style> elements below ``root``.

    Attributes:
        unknown: selectors that are not supported.
    """

    def __init__(self, root: Element) -> None:
        self.unknown: list[str] = []
        self._rules: dict[str, Properties] = {}
        for element in root.iter():
            if local_name(element.tag) == "style":
                self._add("".join(element.itertext()))

    def properties(self, element: Element, inherited: Properties) -> Properties:
        """Return all properties of ``element``, whose parent has the properties ``inherited``."""
        attributes = {name: value.strip() for name, value in element.attrib.items() if name in INHERITED or name in OWN}
        declared = attributes | self._from_rules(element) | _declarations(element.get("style", ""))
        from_parent = {name: inherited[name] for name in INHERITED}
        return from_parent | OWN | {name: value for name, value in declared.items() if value != "inherit"}

    def _add(self, text: str) -> None:
        for rule in _COMMENT.sub("", text).split("}"):
            selectors, brace, body = rule.partition("{")
            declarations = _declarations(body)  # once: a rule may have thousands of selectors
            for selector in selectors.split(",") if brace else ():
                if _KNOWN_SELECTOR.fullmatch(selector.strip()):
                    self._rules.setdefault(selector.strip(), {}).update(declarations)
                else:
                    self.unknown.append(selector.strip())

    @property
    def is_empty(self) -> bool:
        """Whether no rule applies to any element."""
        return not self._rules

    def _from_rules(self, element: Element) -> Properties:
        """Return the declarations of all rules for ``element``; more specific selectors win (CSS 2.1, 6.4.3)."""
        if not self._rules:
            return {}
        tag, classes = local_name(element.tag), element.get("class", "").split()
        selectors = ["*", tag, *("." + name for name in classes), *(f"{tag}.{name}" for name in classes)]
        found: Properties = {}
        for selector in (*selectors, "#" + element.get("id", "")):
            found |= self._rules.get(selector, {})
        return found


def _declarations(text: str) -> Properties:
    found: Properties = {}
    for declaration in text.split(";"):
        name, _, value = declaration.partition(":")
        name, value = name.strip().lower(), value.replace("!important", "").strip()
        if value and (name in INHERITED or name in OWN):
            found[name] = value
    return found
