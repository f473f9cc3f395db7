"""An SVG of anyone's, reduced to what draws paths: known elements with known attributes, and no others."""

from __future__ import annotations

from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from warpvec.svg.scan import SVG_NAMESPACE

INKSCAPE_NAMESPACE = "http://www.inkscape.org/namespaces/inkscape"

_SHAPES = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"})
_CONTAINERS = frozenset({"svg", "g", "a", "switch", "defs", "linearGradient", "radialGradient", "stop"})
_TEXTS = {"title": "title", "metadata": "metadata", "style": "css"}
# What draws nothing where it stands; no one misses it.
_SILENT = frozenset(
    {"", "desc", "script", "symbol", "clipPath", "mask", "marker", "pattern", "filter", "animate", "set"}
)

_GEOMETRY = "d points x y width height viewBox rx ry cx cy r x1 y1 x2 y2 transform"
_PAINT = (
    "fill fill-opacity fill-rule stroke stroke-width stroke-opacity stroke-dasharray opacity display visibility"
    " clip-path mask filter stop-color"
)
# A browser acts on "style" even in a document that it only parses, and complains where a policy forbids it.
_RENAMED = {f"{INKSCAPE_NAMESPACE} label": "label", "style": "css"}
_ATTRIBUTES = {name: name for name in f"id class {_GEOMETRY} {_PAINT}".split()} | _RENAMED


def sanitized(text: str) -> str:
    """The SVG ``text`` without anything that could run, load or link: no handlers, scripts, references or entities.

    Elements that are left out but drew something become ``<left-out name="..."/>``. Style sheets and style attributes
    are named ``css``, Inkscape's labels ``label``. ``text`` has passed the checks of `warpvec.svg.measure.file_facts`.
    """
    cleaner = _Cleaner()
    parser = expat.ParserCreate("utf-8", namespace_separator=" ")
    parser.StartElementHandler = cleaner.start_element
    parser.EndElementHandler = cleaner.end_element
    parser.CharacterDataHandler = cleaner.characters
    parser.Parse(text.encode(), True)
    return "".join(cleaner.parts)


class _Cleaner:
    """Collects the parts of the clean text."""

    def __init__(self) -> None:
        self.parts: list[str] = []
        self._open: list[str] = []
        self._skipped = 0

    def start_element(self, name: str, attributes: dict[str, str]) -> None:
        namespace, _, local = name.rpartition(" ")
        # Elements of other programs draw nothing.
        local = local if namespace in ("", SVG_NAMESPACE) else ""
        written = _TEXTS.get(local, local if local in _SHAPES | _CONTAINERS else None)
        # Text is taken without what stands inside it: metadata may hold whole documents.
        inside_text = bool(self._open) and self._open[-1] in _TEXTS.values()
        if self._skipped or written is None or inside_text:
            if not (self._skipped or inside_text or local in _SILENT):
                self.parts.append(f"<left-out name={quoteattr(local)}/>")
            self._skipped += 1
            return
        declared = "" if self._open else f' xmlns="{SVG_NAMESPACE}"'
        self.parts.append(f"<{written}{declared}{_known(attributes)}>")
        self._open.append(written)

    def end_element(self, _: str) -> None:
        if self._skipped:
            self._skipped -= 1
        else:
            self.parts.append(f"</{self._open.pop()}>")

    def characters(self, text: str) -> None:
        if not self._skipped and self._open[-1] in _TEXTS.values():
            self.parts.append(escape(text))


def _known(attributes: dict[str, str]) -> str:
    """The known attributes; all but Inkscape's label are of no namespace."""
    known = {_ATTRIBUTES[name]: value for name, value in attributes.items() if name in _ATTRIBUTES}
    return "".join(f" {name}={quoteattr(value)}" for name, value in known.items())
