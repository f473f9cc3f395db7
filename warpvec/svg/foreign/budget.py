"""Limit the work that one file may ask for."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from xml.etree.ElementTree import Element

from warpvec.svg.document import local_name

_MAY_HIDE = frozenset({"display", "style", "class", "systemLanguage", "requiredExtensions"})
"""Attributes with which an element may not be drawn."""


class WorkBudget:
    """The amount of work that may be spent on one file."""

    def __init__(self, amount: int) -> None:
        self._left = amount

    def takes(self, amount: int) -> bool:
        """Return whether ``amount`` is left, and take it if so."""
        if amount > self._left:
            return False
        self._left -= amount
        return True


class ElementCounter:
    """Count the elements that a file draws at the least, before any of them is read.

    An element that a <use> repeats counts again, but is looked at once, so a few lines of <use> that draw a billion
    elements are found at once. What may be hidden, or is nested too deep, counts as nothing.

    Args:
        by_id: elements of the file by their id.
        drawn: names of elements that are drawn or have children that are.
        depth_max: deepest nesting that is followed.
    """

    def __init__(self, by_id: Mapping[str, Element], drawn: Collection[str], depth_max: int) -> None:
        self._by_id, self._drawn, self._depth_max = by_id, drawn, depth_max
        self._counts: dict[Element, int] = {}

    def count(self, element: Element, depth: int = 0) -> int:
        """Return the least number of elements that ``element`` draws, itself included."""
        name = local_name(element.tag)
        if name not in self._drawn or depth > self._depth_max or not _MAY_HIDE.isdisjoint(element.keys()):
            return 0
        if element not in self._counts:
            self._counts[element] = 0  # if it refers to itself
            self._counts[element] = 1 + self._below(element, name, depth + 1)
        return self._counts[element]

    def _below(self, element: Element, name: str, depth: int) -> int:
        if name == "switch":  # one of its children is drawn
            return 0
        if name != "use":
            return sum(self.count(child, depth) for child in element)
        target = self._by_id.get(reference_of(element))
        if target is None or local_name(target.tag) not in ("symbol", "svg"):
            return 0 if target is None else self.count(target, depth)
        return sum(self.count(child, depth) for child in target)


def reference_of(use: Element) -> str:
    """Return the id that a <use> refers to."""
    href = next((value for key, value in use.attrib.items() if key.rpartition("}")[2] == "href"), "")
    return href.strip()[1:]
