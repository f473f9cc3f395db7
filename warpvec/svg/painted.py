"""Count the elements of an SVG that paint something."""

from __future__ import annotations

_PAINTED = frozenset(
    {"path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "text", "image", "use", "foreignObject"}
)

_DEFINITIONS = frozenset(
    {"defs", "symbol", "clipPath", "mask", "pattern", "marker", "filter", "linearGradient", "radialGradient"}
)
"""Elements whose contents paint nothing where they stand."""

_BACKGROUND_ID = "background"
"""The ``id`` of the rectangle that is the canvas in warpvec's own files, and does not count."""


class PaintedCounter:
    """Counts shapes, texts, images and copies outside of definitions, clip paths and masks.

    Attributes:
        count: the elements so far.
        gradient_count: those of them whose own fill refers to a gradient or a pattern.
    """

    def __init__(self) -> None:
        self.count = self.gradient_count = self._depth = 0

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """Take the start of the SVG element ``name``."""
        self._depth += name in _DEFINITIONS
        is_background = name == "rect" and attributes.get("id") == _BACKGROUND_ID
        if name in _PAINTED and not self._depth and not is_background:
            self.count += 1
            self.gradient_count += _has_gradient(attributes)

    def end(self, name: str) -> None:
        """Take the end of the SVG element ``name``."""
        self._depth -= name in _DEFINITIONS


def _has_gradient(attributes: dict[str, str]) -> bool:
    return "url(" in attributes.get("fill", "") or "fill:url(" in "".join(attributes.get("style", "").split())
