"""Make the text of an SVG fit for a purpose: of a drawing that was edited, or that becomes another file."""

from __future__ import annotations

from typing import Any, NamedTuple

from warpvec.geometry.scene import Scene
from warpvec.purposes.replaced import replaced
from warpvec.purposes.table import WEB, Purpose
from warpvec.svg.description import description_of
from warpvec.svg.document import parse_svg
from warpvec.svg.minify import write_minified
from warpvec.svg.read import LoadedSvg, read_svg
from warpvec.svg.units import in_pixels_of, more_decimals, physical_size, stated_size
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
    root = parse_svg(text).root
    pixels = tuple(map(round, stated_size(root)))
    scene = loaded.scene.scaled(pixels[0] / loaded.width, pixels[1] / loaded.height)
    found = replaced(scene, purpose, *pixels)
    sides = loaded.sides
    keeps_units = _keeps_units(loaded, found.scene, root, purpose)
    width, height = (round(loaded.width), round(loaded.height)) if keeps_units else pixels
    scene = found.scene.scaled(width / pixels[0], height / pixels[1])
    decimals = (loaded.precision or 0) + more_decimals(loaded.width / width) - more_decimals(width / loaded.width)
    if sides is not None and purpose.per_inch is not None:
        sides = in_pixels_of(sides, purpose.per_inch)
    options: dict[str, Any] = {
        "has_arcs": purpose.has_arcs, "profile": purpose.profile, "closes_exactly": loaded.closes_exactly,
    }  # fmt: skip
    if loaded.minified:
        options |= {"precision": decimals, "has_groups": purpose.has_groups}
        made = write_minified(scene, width, height, sides or (str(width), str(height)), **options)
    else:
        title, metadata = description_of(text.encode())
        precision = max(decimals, _PRECISION)
        options |= {"title": title, "metadata": metadata, "layer_names": loaded.layer_names}
        made = write_svg(scene, width, height, precision=precision, sides=sides, **options)
    return Fitted(made, found.words)


def _keeps_units(loaded: LoadedSvg, scene: Scene, root: dict[str, str], purpose: Purpose) -> bool:
    """Return whether the file for ``purpose`` has the units of the file ``loaded``, else pixels.

    Files of lengths in the world keep theirs. So do the shortest files of fills, which would be a quarter longer.
    """
    is_short = loaded.minified and scene.strokes is None
    return purpose.has_units or is_short or physical_size(root) is not None
