"""Write the layers of an SVG as layers of a PDF, which viewers and editors show and hide: optional content groups.

CairoSVG knows no layers. So it draws each part of the SVG on a page of its own, and pikepdf (MPL, on qpdf) puts these
on one page, each in its group: ISO 32000-1, section 8.11.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from importlib.util import find_spec
from io import BytesIO
from itertools import groupby
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from warpvec.svg.document import local_name, parse_svg

_INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
_UNPAINTED = ("defs", "title", "desc", "metadata", "style")
_REST = "Background"
"""Name of what lies between layers, which in files of warpvec is the rectangle below them."""

COUNT_MAX = 200
"""Most parts that become pages."""

REPEATED_MAX = 2**22
"""Most characters that pages repeat of the SVG, its gradients above all: CairoSVG reads a million in 0.3 s."""


def can_have_layers() -> bool:
    """Return whether pikepdf is installed."""
    return find_spec("pikepdf") is not None


class Part(NamedTuple):
    """A layer, or what lies between two, as an SVG of its own."""

    name: str
    svg: str


def parts_of(svg: str) -> list[Part]:
    """Return the parts of an SVG in the order of painting; none if it has no layers, or too many for the time.

    Raises:
        InputError: ``svg`` is not an SVG, or is refused as unsafe.
    """
    builder = ElementTree.TreeBuilder()
    parse_svg(svg, builder)
    root = builder.close()
    painted = [child for child in root if local_name(child.tag) not in _UNPAINTED]
    runs = [list(run) for _, run in groupby(painted, _layer_key)]
    if not any(map(_is_layer, painted)) or len(runs) > COUNT_MAX:
        return []
    parts = list(_parts(root, runs))
    return parts if sum(len(part.svg) for part in parts) - len(svg) <= REPEATED_MAX else []


def _is_layer(element: Element) -> bool:
    return element.get(_INKSCAPE + "groupmode") == "layer"


def _layer_key(element: Element) -> int:
    """Return a number of its own for a layer; all others have 0."""
    return id(element) if _is_layer(element) else 0


def _parts(root: Element, runs: Sequence[Sequence[Element]]) -> Iterator[Part]:
    shared = [child for child in root if local_name(child.tag) in _UNPAINTED]
    for run in runs:
        page = copy(root)
        page[:] = [*shared, *run]
        name = run[0].get(_INKSCAPE + "label") or run[0].get("id") or "Layer" if _is_layer(run[0]) else _REST
        yield Part(name, ElementTree.tostring(page, encoding="unicode"))


def on_one_page(names: Sequence[str], pages: Sequence[bytes]) -> bytes:
    """Return the PDF of one page on which ``pages``, PDFs of one page and one size, lie as layers with these names."""
    import pikepdf  # not above: it is an extra

    made = pikepdf.new()
    sources = [pikepdf.open(BytesIO(data)) for data in pages]  # an object lives as long as its file
    sides = sources[0].pages[0].mediabox
    page = made.add_blank_page(page_size=(float(sides[2]), float(sides[3])))
    page.obj.Resources = pikepdf.Dictionary(XObject=pikepdf.Dictionary(), Properties=pikepdf.Dictionary())
    layers, commands = pikepdf.Array(), ""
    for number, (name, source) in enumerate(zip(names, sources, strict=True)):
        form = source.pages[0].as_form_xobject()
        layer = made.make_indirect(pikepdf.Dictionary(Type=pikepdf.Name.OCG, Name=pikepdf.String(name)))
        page.obj.Resources.XObject[f"/X{number}"] = made.copy_foreign(form)
        page.obj.Resources.Properties[f"/L{number}"] = layer
        layers.append(layer)
        commands += f"/OC /L{number} BDC /X{number} Do EMC\n"
    page.obj.Contents = made.make_stream(commands.encode())
    order = pikepdf.Array(reversed(list(layers)))
    shown = pikepdf.Dictionary(Order=order, ON=layers, Name=pikepdf.String("Layers"))
    made.Root.OCProperties = pikepdf.Dictionary(OCGs=layers, D=shown)
    made.Root.PageMode = pikepdf.Name.UseOC
    out = BytesIO()
    disabled = pikepdf.ObjectStreamMode.disable  # some readers look for the size of a page in plain text
    made.save(out, min_version="1.5", object_stream_mode=disabled, deterministic_id=True)
    return out.getvalue()
