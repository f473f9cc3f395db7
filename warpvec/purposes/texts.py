"""Make the text of an SVG fit for a purpose: of a drawing that was edited, or that becomes another file."""

from __future__ import annotations

from typing import Any, NamedTuple

from warpvec.purposes.replaced import replaced
from warpvec.purposes.table import WEB, Purpose
from warpvec.svg.description import description_of
from warpvec.svg.document import parse_svg
from warpvec.svg.minify import write_minified
from warpvec.svg.read import read_svg
from warpvec.svg.units import in_pixels_of, stated_size
from warpvec.svg.write import write_svg

_PRECISION = 2
"""Fewest decimals of coordinates where a unit is a pixel: a form with whole sides has an outline of other numbers."""


class Fitted(NamedTuple):
    """The text of an SVG for a purpose, and in words what is drawn by other means in it."""

    text: str
    words: list[str]


def text_for(text: str, purpose: Purpose) -> Fitted:
    """Return the SVG ``text`` with what a file for ``purpose`` may use; a text that has no more stays as it is.

    Raises:
        InputError: the text is not an SVG that can be read, or a package is missing.
    """
    if purpose == WEB:
        return Fitted(text, [])
    purpose.check_packages("the drawing")
    loaded = read_svg(text)
    pixels = tuple(map(round, stated_size(parse_svg(text).root)))
    scene = loaded.scene.scaled(pixels[0] / loaded.width, pixels[1] / loaded.height)
    found = replaced(scene, purpose, *pixels)
    width, height = round(loaded.width), round(loaded.height)
    scene = found.scene.scaled(width / pixels[0], height / pixels[1])
    sides = loaded.sides
    if sides is not None and purpose.per_inch is not None:
        sides = in_pixels_of(sides, purpose.per_inch)
    options: dict[str, Any] = {"has_arcs": purpose.has_arcs, "profile": purpose.profile}
    if loaded.minified:
        options |= {"precision": loaded.precision, "has_groups": purpose.has_groups}
        made = write_minified(scene, width, height, sides or (str(width), str(height)), **options)
    else:
        title, metadata = description_of(text.encode())
        precision = max(loaded.precision or 0, _PRECISION)
        options |= {"title": title, "metadata": metadata, "layer_names": loaded.layer_names}
        made = write_svg(scene, width, height, precision=precision, sides=sides, **options)
    return Fitted(made, found.words)
