"""Images of a document: which are meant, where their pixels are, and in which file."""

from __future__ import annotations

import os
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Container, Iterable
from typing import Any

from warpvec_placement import Box, Size, image_box, read_length
from warpvec_refusal import Refusal

SVG = "{http://www.w3.org/2000/svg}"
_HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_ABSOLUTE = "{http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd}absref"
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_UNDRAWN = {SVG + name for name in ("defs", "clipPath", "mask", "pattern", "marker", "symbol")}


def drawn(root: Any, tags: Container[str]) -> list[Any]:
    """Return the elements with one of ``tags`` that are drawn, from bottom to top."""
    found: list[Any] = []
    for child in root.iterchildren(SVG + "*"):
        if child.tag not in _UNDRAWN:
            found += [child] if child.tag in tags else []
            found += drawn(child, tags)
    return found


def chosen(root: Any, ids: Container[str], tags: Container[str]) -> list[Any]:
    """Return the `drawn` elements whose id, or the id of a group around them, is among ``ids``."""
    return [each for each in drawn(root, tags) if any(one.get("id") in ids for one in (each, *each.iterancestors()))]


def name_of(element: Any) -> str:
    """Return the name that Inkscape shows for ``element``."""
    return str(element.get(_LABEL) or element.get("id"))


def image_file(image: Any, document_folders: Iterable[str | None], folder: str) -> str:
    """Return the file of an image: the linked file, or a new file in ``folder`` for an embedded image.

    Args:
        document_folders: the folders that links may be relative to, the likeliest first.

    Raises:
        Refusal: there is no file, or it is not on this computer.
    """
    link = next((image.get(name) for name in _HREFS if image.get(name)), "")
    if link.startswith("data:"):
        return _embedded(link, os.path.join(folder, "image"))
    parts = urllib.parse.urlparse(link)
    is_local = parts.scheme in ("", "file") or len(parts.scheme) == 1  # a letter is a drive of Windows
    if not is_local:
        raise Refusal(f"The image is a link to {link}. Save that file, and import it.")
    path = link if len(parts.scheme) == 1 else urllib.request.url2pathname(parts.path)
    candidates = [os.path.join(start, path) for start in document_folders if start]
    candidates.append(image.get(_ABSOLUTE) or "")
    for candidate in candidates:
        if os.path.isfile(candidate):
            return os.path.abspath(candidate)
    raise Refusal("The linked image {} is missing. Open Edit > Links to find it.".format(path or "(without a name)"))


def _embedded(link: str, path: str) -> str:
    try:
        with urllib.request.urlopen(link) as stream:  # a data: link is in memory, nothing is fetched
            data = stream.read()
    except (ValueError, urllib.error.URLError):
        raise Refusal("The embedded image is damaged. Import it again.") from None
    with open(path, "wb") as file:
        file.write(data)
    return path


def box_of(image: Any, pixels: Size) -> Box:
    """Return the box of ``image`` in the user units inside of its transform."""
    x, y, width, height = (image.get(name) for name in ("x", "y", "width", "height"))
    return image_box(x, y, width, height, pixels, _viewport(image))


def _viewport(image: Any) -> Size:
    """Return the size in user units of the SVG around ``image``."""
    svg = next(image.iterancestors(SVG + "svg"))
    numbers = svg.get("viewBox", "").replace(",", " ").split()
    if len(numbers) == 4:
        return Size(float(numbers[2]), float(numbers[3]))
    return Size(*(read_length(svg.get(name, "100%"), whole) for name, whole in (("width", 300.0), ("height", 150.0))))
