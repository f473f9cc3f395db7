"""SVG files come from anywhere: what is checked before a parser or native code sees one, and what it holds.

Limits: ``MAX_SVG_BYTES`` of text, no entities, ``MAX_DEPTH`` nested elements, no other files drawn.
"""

from __future__ import annotations

import gzip
import io
import math
import re
import zlib
from xml.parsers import expat

from warpvec.errors import InputError
from warpvec.svg.units import NUMBER

SVG_NAMESPACE = "http://www.w3.org/2000/svg"

MAX_SVG_BYTES = 2**28
"""Far above any drawing that an editor opens; stops a few kilobytes of gzip from filling the memory."""

MAX_DEPTH = 100
"""Nested elements; resvg overflows its stack, and ends the process, somewhere between 200 and 300."""

_DRAWS_A_FILE = frozenset({"image", "feImage", "use"})

# Elements and attributes whose cost follows from the size of the file and of the picture. Patterns, filters, masks and
# strokes can ask for any amount of time and memory in a few bytes; so can a style sheet, by naming them.
_PLAIN_ELEMENTS = frozenset({"svg", "g", "path", "rect", "title", "desc", "metadata"})
_PLAIN_ATTRIBUTES = frozenset({"id", "version", "width", "height", "viewBox", "x", "y", "d", "fill", "fill-opacity"})


class Scan:
    """What one pass over an SVG, without building a tree, finds in it.

    Attributes:
        root: attributes of the outermost element.
        path_data: the ``d`` of each <path>.
        plain: whether it holds only paths, rectangles and groups with flat fills, so that nothing in it is costly.
    """

    def __init__(self) -> None:
        self.root: dict[str, str] = {}
        self.path_data: list[str] = []
        self.plain = True
        self._rectangles: list[str] = []
        self._depth = 0

    def start_element(self, name: str, attributes: dict[str, str]) -> None:
        namespace, _, local_name = name.rpartition(" ")
        if namespace not in ("", SVG_NAMESPACE):
            local_name = ""
        if self._depth == 0:
            _check_root(local_name)
            self.root = attributes
        if self._depth == MAX_DEPTH:
            raise InputError(f"SVG must nest at most {MAX_DEPTH} elements, this one nests more; ungroup it")
        self._depth += 1
        if local_name == "path":
            self.path_data.append(attributes.get("d", ""))
        if local_name == "rect":
            self._rectangles.append(" ".join(attributes.get(name, "0") for name in ("x", "y", "width", "height")))
        if local_name in _DRAWS_A_FILE:
            _check_references(local_name, attributes)
        self.plain = self.plain and _is_plain(local_name, attributes)

    def end_element(self, _: str) -> None:
        self._depth -= 1

    def reach(self) -> float:
        """User units, at most, from the origin to a point of a path or rectangle: the sum of its numbers' sizes."""
        shapes = (re.findall(NUMBER, numbers) for numbers in (*self.path_data, *self._rectangles))
        return max((math.fsum(abs(float(word)) for word in shape) for shape in shapes), default=0.0)


def scan(text: str) -> Scan:
    """What ``text`` holds, once it has been found harmless.

    Raises:
        InputError: not an SVG, or refused as unsafe: entities, references to other files, too deep.
    """
    contents = Scan()
    parser = expat.ParserCreate("utf-8", namespace_separator=" ")
    parser.StartElementHandler = contents.start_element
    parser.EndElementHandler = contents.end_element
    parser.EntityDeclHandler = _refuse_entity
    try:
        parser.Parse(text.encode(), True)
    except (expat.ExpatError, UnicodeEncodeError) as error:
        raise InputError(f"SVG must be well-formed XML, got {error}; save it again from its editor") from None
    return contents


def read_text(svg: str | bytes) -> str:
    """The text of an SVG given as text, or as the bytes of an ``.svg`` or ``.svgz`` file.

    Raises:
        InputError: more than ``MAX_SVG_BYTES``, not UTF-8, or gzipped and not whole.
    """
    if isinstance(svg, str):
        return svg
    try:
        data = _gunzip(svg) if svg.startswith(b"\x1f\x8b") else svg
        _check_bytes(len(data))
        return data.decode()
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"SVG must be whole if gzipped, got: {error}; write it again") from None
    except UnicodeDecodeError as error:
        raise InputError(f"SVG must be UTF-8 text, not so at byte {error.start}; is it an SVG file?") from None


def _is_plain(local_name: str, attributes: dict[str, str]) -> bool:
    # Attributes of another namespace have a space in their name and mean nothing to a renderer.
    names = {name for name in attributes if " " not in name}
    return local_name in _PLAIN_ELEMENTS and names <= _PLAIN_ATTRIBUTES


def _check_root(local_name: str) -> None:
    if local_name != "svg":
        found = f"<{local_name}>" if local_name else "one of another namespace"
        raise InputError(f"SVG must have <svg> as its outermost element, got {found}; is it an SVG file?")


def _refuse_entity(name: str, *_: object) -> None:
    raise InputError(f"SVG must not declare entities, got {name!r}; save it as plain SVG")


def _check_references(local_name: str, attributes: dict[str, str]) -> None:
    """What is measured is the file alone: a link to the photo itself would score without limit."""
    for name, value in attributes.items():
        if name.rpartition(" ")[2] == "href" and not value.strip().startswith(("#", "data:")):
            raise InputError(f"SVG must not draw other files, got <{local_name} href={value[:80]!r}>; embed it instead")


def _gunzip(data: bytes) -> bytes:
    with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
        return file.read(MAX_SVG_BYTES + 1)


def _check_bytes(count: int) -> None:
    if count > MAX_SVG_BYTES:
        raise InputError(f"SVG must have at most {MAX_SVG_BYTES} bytes of text, this one has more; simplify it")
