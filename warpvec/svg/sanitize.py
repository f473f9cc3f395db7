"""Reduce any SVG to known elements and attributes that draw paths."""

from __future__ import annotations

from xml.sax.saxutils import escape, quoteattr

from warpvec.svg.document import SVG_NAMESPACE, Document, SvgSource, local_name, parse_svg

INKSCAPE_NAMESPACE = "http://www.inkscape.org/namespaces/inkscape"

_SHAPES = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"})
_CONTAINERS = frozenset({"svg", "g", "a", "switch", "defs", "stop"})
_GRADIENTS = frozenset({"linearGradient", "radialGradient"})
_FILTERS = frozenset({"filter", "feGaussianBlur"})
_KEPT = _SHAPES | _CONTAINERS | _GRADIENTS | _FILTERS
_TEXTS = {"title": "title", "metadata": "metadata", "style": "css"}
# These draw nothing by themselves, so they are left out without a note.
_SILENT = frozenset({"", "desc", "script", "symbol", "clipPath", "mask", "marker", "pattern", "animate", "set"})

_GEOMETRY = "d points x y width height viewBox rx ry cx cy r x1 y1 x2 y2 transform"
_STYLE = (
    "fill fill-opacity fill-rule stroke stroke-width stroke-opacity stroke-dasharray stroke-linecap stroke-linejoin"
    " stroke-miterlimit opacity display visibility clip-path mask filter stop-color stop-opacity"
)
_REFERENCES = ("href", "{http://www.w3.org/1999/xlink}href")
_GRADIENT = "gradientUnits gradientTransform spreadMethod offset fx fy"
_FILTER = "stdDeviation in"
# A browser applies "style" even in a document that it only parses, and reports an error where a policy forbids it.
_RENAMED = {f"{{{INKSCAPE_NAMESPACE}}}label": "label", "style": "css"}
_ATTRIBUTES = {name: name for name in f"id class {_GEOMETRY} {_STYLE} {_GRADIENT} {_FILTER}".split()} | _RENAMED


def sanitize(svg: SvgSource) -> tuple[Document, str]:
    """Return the parsed ``svg``, and its text without anything that could run, load or link.

    The text has no event handlers, scripts, references or entities. An element that is left out although it draws
    something becomes ``<left-out name="..."/>``. Style sheets and style attributes are named ``css``, Inkscape's labels
    ``label``, and the gradient of the same file that a gradient takes its stops from ``template``.

    Raises:
        InputError: ``svg`` is not an SVG, or is refused as unsafe.
    """
    sanitizer = _Sanitizer()
    document = parse_svg(svg, sanitizer)
    return document, "".join(sanitizer.parts)


class _Sanitizer:
    """A builder that collects the parts of the reduced text."""

    def __init__(self) -> None:
        self.parts: list[str] = []
        self._open: list[str] = []
        self._skipped_depth = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        # Elements of other namespaces have no local name here; they draw nothing.
        name = local_name(tag)
        written = _TEXTS.get(name, name if name in _KEPT else None)
        # Only the text of a text element is kept, not the elements inside it: metadata may hold whole documents.
        inside_text = bool(self._open) and self._open[-1] in _TEXTS.values()
        if self._skipped_depth or written is None or inside_text:
            if not (self._skipped_depth or inside_text or name in _SILENT):
                self.parts.append(f"<left-out name={quoteattr(name)}/>")
            self._skipped_depth += 1
            return
        declared = "" if self._open else f' xmlns="{SVG_NAMESPACE}"'
        self.parts.append(f"<{written}{declared}{_known_attributes(written, attributes)}>")
        self._open.append(written)

    def data(self, text: str) -> None:
        if not self._skipped_depth and self._open[-1] in _TEXTS.values():
            self.parts.append(escape(text))

    def end(self, _: str) -> None:
        if self._skipped_depth:
            self._skipped_depth -= 1
        else:
            self.parts.append(f"</{self._open.pop()}>")


def _known_attributes(element: str, attributes: dict[str, str]) -> str:
    """Return the text of the known attributes. All but Inkscape's label have no namespace."""
    known = {_ATTRIBUTES[name]: value for name, value in attributes.items() if name in _ATTRIBUTES}
    reference = next((attributes[name].strip() for name in _REFERENCES if name in attributes), "")
    if element in _GRADIENTS and reference.startswith("#"):
        known["template"] = reference
    if "stroke-dasharray" in known and element == "path":
        known |= _without_dashes(known)
    return "".join(f" {name}={quoteattr(value)}" for name, value in known.items())


def _without_dashes(attributes: dict[str, str]) -> dict[str, str]:
    """Return the attributes that say each dash of a line of warpvec's own files; none for other files.

    The page edits lines, and has no dashes.
    """
    from warpvec.svg.dashes import plain_data  # not above: few files have dashes

    data = plain_data(attributes.get("d", ""), attributes["stroke-dasharray"])
    return {} if data is None else {"d": data, "stroke-dasharray": "none"}
