"""One pass over SVG text: check that it is safe, and collect its elements for the other modules.

SVG files come from anywhere, so every module reads them through `parse_svg`, before another parser or native code sees
them. Allowed are ``MAX_SVG_BYTES`` of text and ``MAX_ELEMENTS`` elements, ``MAX_DEPTH`` deep. Entities and references
to other files are refused.
"""

from __future__ import annotations

import gzip
import io
import math
import re
import zlib
from dataclasses import dataclass, field
from itertools import islice
from typing import Protocol
from xml.parsers import expat

from warpvec.errors import InputError
from warpvec.svg.painted import PaintedCounter
from warpvec.svg.units import NUMBER

SVG_NAMESPACE = "http://www.w3.org/2000/svg"

MAX_SVG_BYTES = 2**27
"""Largest text in bytes: the largest drawing that warpvec fits, of 2^22 segments of 30 bytes each. To check and measure
any such text takes less than 20 s and 1 GB."""

MAX_DEPTH = 100
"""Deepest nesting of elements. resvg overflows its stack, and ends the process, somewhere between 200 and 300."""

MAX_ELEMENTS = 2**19
"""Most elements, eight times as many as warpvec draws: with a name each, as a tree, they take 5 s and 400 MB."""

MAX_ATTRIBUTES = 1000
"""Most attributes of an element, above any that SVG knows. The parser makes a string of each, with its namespace."""

MAX_ALL_ATTRIBUTES = 2**22
"""Most attributes of all elements, with those that a document type adds to each: they take 3 s."""

MAX_NAMESPACE = 1000
"""Longest namespace in bytes. The parser repeats the namespace for each of its names: a megabyte takes gigabytes."""

_DATA_URL = re.compile(r"[\x00-\x20]*data:[^,#]*,")
"""A data URL, as resvg tells it from a path: without a comma, or with one only after a "#", it would be a file."""

_REFERENCES = {
    "image": _DATA_URL,
    # A fragment names an element. If there is none, resvg takes it for a file; a name without a slash is then looked
    # for in the root of the file system, and on most systems not even there; see `sandbox.child`.
    "feImage": re.compile(rf"{_DATA_URL.pattern}|#[^/\\]*\Z"),
    # resvg looks for the element alone.
    "use": re.compile(r"\s*(?:#|data:)"),
}
"""Element -> the references that resvg draws without opening a file."""

# The cost of drawing these elements and attributes follows from the size of the file and of the picture. Patterns,
# filters, masks and strokes can ask for any amount of time and memory in a few bytes. So can a style sheet that names
# them.
_GRADIENTS = frozenset({"linearGradient", "radialGradient"})
_FORMS = {"rect": ("x", "y", "width", "height"), "circle": ("cx", "cy", "r", "r"), "ellipse": ("cx", "cy", "rx", "ry")}
_PLAIN_ELEMENTS = frozenset({"svg", "g", "path", "title", "desc", "metadata", "defs", "stop", *_FORMS}) | _GRADIENTS
_PLAIN_ATTRIBUTES = frozenset(
    {"id", "version", "width", "height", "viewBox", "x", "y", "d", "fill", "fill-opacity"}
    | {"gradientUnits", "gradientTransform", "x1", "y1", "x2", "y2", "cx", "cy", "r", "rx", "ry"}
    | {"offset", "stop-color", "stop-opacity"}
)

_TURN = re.compile(r"rotate\(-?[\d.]{1,20} (-?[\d.]{1,20}) (-?[\d.]{1,20})\)", re.ASCII)
"""A turn about a point, the one transform that a plain form may have."""

_PLAIN_STOPS = 8
"""Most stops of a plain gradient, as many as a path may have in `warpvec.geometry.stops`, which would load torch. A
pixel takes the longer the more there are: with two, four times a flat pixel, with 10,000, a hundred times."""

_DRAWN_NAMESPACES = (f"{SVG_NAMESPACE} ", "http://www.w3.org/1999/xlink ", "http://www.w3.org/XML/1998/namespace ")
"""resvg takes an attribute of one of these namespaces, here as expat's names begin, for the one without."""

_NUMBER = re.compile(NUMBER)

_LAYER_ID = re.compile(r"layer-\d{1,9}-generation-(\d{1,9})", re.ASCII)

_TAG = re.compile(rb"""<(?:[^>"']|"[^"]*"|'[^']*')*+>""")

_LONG_TAG = re.compile(rb"<[^<!?/][^<]{%d}" % (5 * MAX_ATTRIBUTES))
"""The start of a tag that has room for too many attributes; " a=''" is the shortest. No tag holds a "<"."""

_NAMESPACE = re.compile(rb"""(?<=\s)xmlns[^\s="'<>]*+\s*+=\s*+(?:"([^"<]*+)|'([^'<]*+))""")

_VALUE = re.compile(rb"""=\s*+(?>"[^"]*"|'[^']*')""")


@dataclass(frozen=True)
class Group:
    """A <g> element directly inside the root.

    Attributes:
        level: its level of detail; see `layer_level`.
        start, stop: the range of bytes that it takes in the UTF-8 text.
        painted_count: the number of elements in it that paint something.
    """

    level: int
    start: int
    stop: int
    painted_count: int


@dataclass
class Document:
    """An SVG that passed the safety checks.

    Attributes:
        text: the whole file.
        root: attributes of the root element.
        root_range: start and stop of the root element in the UTF-8 text, in bytes.
        groups: the <g> elements directly inside the root, in the order of the file.
        path_data: the ``d`` attribute of each <path>.
        forms: position and size of each <rect>, <circle> and <ellipse>, and the point that it is turned about, as
            text.
        painted: the elements that paint something.
        plain: True if the file holds only paths, forms and groups with flat fills, and gradients of few stops that
            refer to nothing, so that drawing it is cheap.
    """

    text: str
    root: dict[str, str] = field(default_factory=dict)
    root_range: tuple[int, int] = (0, 0)
    groups: list[Group] = field(default_factory=list)
    path_data: list[str] = field(default_factory=list)
    forms: list[str] = field(default_factory=list)
    painted: PaintedCounter = field(default_factory=PaintedCounter)
    plain: bool = True

    def reach(self) -> float:
        """Return an upper bound of the distance from the origin to any point of a path or form, in user units.

        The bound of a shape is the sum of the absolute values of its numbers, those of a point to turn about twice.
        """
        shapes = (_NUMBER.finditer(numbers) for numbers in (*self.path_data, *self.forms))
        return max((math.fsum(abs(float(match[0])) for match in shape) for shape in shapes), default=0.0)


SvgSource = str | bytes | Document
"""Text, the bytes of an ``.svg`` or ``.svgz`` file, or a `Document`, which is not parsed again."""


class Builder(Protocol):
    """A receiver of the parsed elements, such as `xml.etree.ElementTree.TreeBuilder`.

    Names with a namespace have the form "{namespace}name".
    """

    def start(self, tag: str, attrs: dict[str, str], /) -> object:
        """Take the start of an element."""

    def data(self, text: str, /) -> object:
        """Take text between tags; one text may come in several pieces."""

    def end(self, tag: str, /) -> object:
        """Take the end of an element."""


def parse_svg(svg: SvgSource, builder: Builder | None = None) -> Document:
    """Parse ``svg`` once, check that it is safe, and pass its elements on to ``builder``.

    Raises:
        InputError: ``svg`` is not an SVG, or is refused as unsafe: too large, too deep, with entities or with
            references to other files.
    """
    if isinstance(svg, Document) and builder is None:
        return svg
    return _Parser(svg.text if isinstance(svg, Document) else read_text(svg), builder).run()


def read_text(svg: str | bytes) -> str:
    """Return the text of an SVG given as text, or as the bytes of an ``.svg`` or ``.svgz`` file.

    Raises:
        InputError: the text has more than ``MAX_SVG_BYTES``, or the bytes are not UTF-8, or a damaged gzip file.
    """
    if isinstance(svg, str):
        _check_size(len(svg))  # a character takes a byte or more; `_Parser` counts those
        return svg
    try:
        data = _gunzip(svg) if svg.startswith(b"\x1f\x8b") else svg
        _check_size(len(data))
        return data.decode()
    except (OSError, EOFError, zlib.error) as error:
        raise InputError("SVG", "must be complete if gzipped", f"an error ({error})", "write it again") from None
    except UnicodeDecodeError as error:
        raise InputError("SVG", "must be UTF-8 text", f"other bytes at {error.start}", "give an SVG file") from None


def local_name(tag: str) -> str:
    """Return the name of an SVG element without its namespace; "" for an element of another namespace."""
    namespace, _, name = tag.rpartition("}")
    return name if namespace in ("", "{" + SVG_NAMESPACE) else ""


def layer_level(identifier: str | None, index: int) -> int:
    """Return the level of the top-level group number ``index`` whose ``id`` is ``identifier``."""
    match = _LAYER_ID.fullmatch(identifier or "")
    return int(match[1]) if match else index


class _Parser:
    """Runs expat over ``text`` and fills a `Document`."""

    def __init__(self, text: str, builder: Builder | None) -> None:
        self.document = Document(text)
        self._builder = builder
        self._depth = self._element_count = self._attribute_count = 0
        self._stops_left = 0  # stops that the gradient may still have
        self._root_start = 0
        self._group: tuple[int, int, int] | None = None  # level, start, and painted elements before it
        self._names: dict[str, tuple[str, str]] = {}  # a name in expat's form -> "{namespace}name", local SVG name
        self._expat = self._make_expat()

    def run(self) -> Document:
        try:
            self._data = self.document.text.encode()
            _check_size(len(self._data))
            _check_attributes(self._data)
            _check_namespaces(self._data)
            self._expat.Parse(self._data, True)
        except (expat.ExpatError, UnicodeEncodeError) as error:
            if "<" not in self.document.text:
                raise InputError("SVG", "must be an SVG file", "a text without tags", "give another file") from None
            raise InputError("SVG", "must be well-formed XML", str(error), "save it again from its editor") from None
        finally:
            # The handlers of expat refer back to this object, so it and its text would stay until the next collection.
            del self._expat
        return self.document

    def _make_expat(self) -> expat.XMLParserType:
        # The encoding is given because a declared one is that of the bytes which the text once was.
        parser = expat.ParserCreate("utf-8", namespace_separator=" ")
        parser.StartElementHandler = self._start_element
        parser.EndElementHandler = self._end_element
        parser.EntityDeclHandler = _refuse_entity
        parser.AttlistDeclHandler = self._declare_attribute
        if self._builder is not None:
            parser.buffer_text = True
            parser.CharacterDataHandler = self._builder.data
            parser.SkippedEntityHandler = _refuse_skipped_entity
        return parser

    def _start_element(self, name: str, attributes: dict[str, str]) -> None:
        tag, local = self._names.get(name) or self._add_name(name)
        if self._depth == 0:
            _check_root(local)
            self.document.root, self._root_start = attributes, self._expat.CurrentByteIndex
        elif self._depth == 1 and local == "g":
            level = layer_level(attributes.get("id"), len(self.document.groups))
            self._group = level, self._expat.CurrentByteIndex, self.document.painted.count
        elif self._depth == MAX_DEPTH:
            raise InputError("SVG", f"must nest at most {MAX_DEPTH} elements", "deeper ones", "ungroup it")
        self._element_count += 1
        if self._element_count > MAX_ELEMENTS:
            raise InputError("SVG", f"must have at most {MAX_ELEMENTS} elements", "more", "simplify it")
        self._attribute_count += len(attributes)
        if self._attribute_count > MAX_ALL_ATTRIBUTES:
            raise InputError("SVG", f"must have at most {MAX_ALL_ATTRIBUTES} attributes", "more", "simplify it")
        self._depth += 1
        self._collect(local, attributes)
        if self._builder is not None:
            self._builder.start(tag, {_clark(key) if " " in key else key: v for key, v in attributes.items()})

    def _declare_attribute(self, element: str, name: str, kind: str, default: str | None, is_required: bool) -> None:
        """Note that resvg, which ignores declarations, may see other attributes than expat does.

        A default namespace would make expat see another element too.
        """
        del kind, is_required
        if default is not None and name.startswith("xmlns"):
            found = f"one for <{element}>"
            raise InputError("SVG", "must not declare a default for a namespace", found, "save it as plain SVG")
        self.document.plain = False

    def _collect(self, name: str, attributes: dict[str, str]) -> None:
        document = self.document
        document.painted.start(name, attributes)
        if name == "path":
            document.path_data.append(attributes.get("d", ""))
        elif name in _FORMS:
            document.forms.append(_form_numbers(name, attributes))
        elif name in _REFERENCES:
            _check_references(name, attributes)
        elif name in _GRADIENTS:
            self._stops_left = _PLAIN_STOPS
        elif name == "stop":
            self._stops_left -= 1
            document.plain = document.plain and self._stops_left >= 0
        # An inner <svg> has a scale of its own.
        is_inner = name == "svg" and self._depth > 1
        document.plain = document.plain and not is_inner and _is_plain(name, attributes)

    def _end_element(self, name: str) -> None:
        self._depth -= 1
        local = self._names[name][1]
        self.document.painted.end(local)
        if local in _GRADIENTS:
            self._stops_left = 0
        if self._depth == 1 and self._group is not None:
            level, start, painted_before = self._group
            painted_count = self.document.painted.count - painted_before
            self.document.groups.append(Group(level, start, self._element_stop(start), painted_count))
            self._group = None
        elif self._depth == 0:
            self.document.root_range = self._root_start, self._element_stop(self._root_start)
        if self._builder is not None:
            self._builder.end(self._names[name][0])

    def _element_stop(self, start: int) -> int:
        """Return the byte after the element that starts at ``start`` and whose end expat reports."""
        opening = _TAG.match(self._data, start)
        if opening is not None and opening[0].endswith(b"/>"):
            return opening.end()
        return self._data.index(b">", self._expat.CurrentByteIndex) + 1

    def _add_name(self, name: str) -> tuple[str, str]:
        tag = _clark(name)
        self._names[name] = tag, local_name(tag)
        return self._names[name]


def _clark(name: str) -> str:
    """Return "{namespace}name" for expat's "namespace name"."""
    namespace, space, local = name.rpartition(" ")
    return f"{{{namespace}}}{local}" if space else name


def _is_plain(element: str, attributes: dict[str, str]) -> bool:
    # Attributes of a namespace have a space in their name; those of most namespaces mean nothing to a renderer.
    names = {name for name in attributes if " " not in name or name.startswith(_DRAWN_NAMESPACES)}
    if element in _FORMS and _TURN.fullmatch(attributes.get("transform", "")):
        names.remove("transform")
    matrix = attributes.get("gradientTransform")
    return element in _PLAIN_ELEMENTS and names <= _PLAIN_ATTRIBUTES and (matrix is None or _is_matrix(matrix))


def _is_matrix(text: str) -> bool:
    """Return whether ``text`` is one matrix of six numbers."""
    return re.fullmatch(rf"matrix\({' '.join([NUMBER] * 6)}\)", text) is not None


def _form_numbers(element: str, attributes: dict[str, str]) -> str:
    """Return place and sizes of a form, and twice the point that it is turned about."""
    turn = _TURN.fullmatch(attributes.get("transform", ""))
    sides = [attributes.get(side, "0") for side in _FORMS[element]]
    return " ".join([*sides, *(turn.groups() * 2 if turn else ())])


def _check_root(element: str) -> None:
    if element != "svg":
        found = f"<{element}>" if element else "an element of another namespace"
        raise InputError("SVG", "must have <svg> as its outermost element", found, "give an SVG file")


def _check_attributes(data: bytes) -> None:
    """Refuse too many attributes before the parser makes a list of them."""
    for match in _LONG_TAG.finditer(data):
        tag = _TAG.match(data, match.start())
        values = _VALUE.finditer(data, match.start(), tag.end() if tag else match.end())
        if sum(1 for _ in islice(values, MAX_ATTRIBUTES + 1)) > MAX_ATTRIBUTES:
            rule = f"must have at most {MAX_ATTRIBUTES} attributes in an element"
            raise InputError("SVG", rule, "more", "save it as plain SVG")


def _check_namespaces(data: bytes) -> None:
    """Refuse long namespaces. A handler of the parser would be called too late: it goes on to the end of the tag."""
    for match in _NAMESPACE.finditer(data):
        if match.end() - match.start(match.lastindex or 0) > MAX_NAMESPACE:
            rule = f"must have namespaces of at most {MAX_NAMESPACE} bytes"
            raise InputError("SVG", rule, "a longer one", "save it as plain SVG")


def _refuse_entity(name: str, *_: object) -> None:
    raise InputError("SVG", "must not contain entities", repr(name), "save it as plain SVG")


def _refuse_skipped_entity(name: str, is_parameter_entity: bool) -> None:
    """Refuse an entity that only an external document type could declare: its text is missing."""
    if not is_parameter_entity:
        _refuse_entity(name)


def _check_references(element: str, attributes: dict[str, str]) -> None:
    """Refuse links to other files: a link to the original image would score without limit."""
    for name, value in attributes.items():
        if name.rpartition(" ")[2] == "href" and not _REFERENCES[element].match(value):
            found = f"<{element} href={value[:80]!r}>"
            raise InputError("SVG", "must not draw other files", found, "embed what it links to")


def _gunzip(data: bytes) -> bytes:
    with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
        return file.read(MAX_SVG_BYTES + 1)


def _check_size(count: int) -> None:
    if count > MAX_SVG_BYTES:
        raise InputError("SVG", f"must have at most {MAX_SVG_BYTES} bytes of text", "more", "simplify it")
