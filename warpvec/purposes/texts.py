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
    wide, high = stated_size(root)
    pixels = (round(wide), round(high))
    scene = loaded.scene.scaled(pixels[0] / loaded.width, pixels[1] / loaded.height)
    found = replaced(scene, purpose, *pixels)
    sides = loaded.sides
    if sides is not None and purpose.per_inch is not None:
        sides = in_pixels_of(sides, purpose.per_inch)
    options: dict[str, Any] = {
        "has_arcs": purpose.has_arcs, "profile": purpose.profile, "closes_exactly": loaded.closes_exactly,
    }  # fmt: skip
    if loaded.minified:
        options |= {"has_groups": purpose.has_groups, "sides": sides or tuple(map(str, pixels))}
    else:
        title, metadata = description_of(text.encode())
        options |= {"title": title, "metadata": metadata, "layer_names": loaded.layer_names, "sides": sides}
    units = _units(loaded, found.scene, root, purpose, pixels)
    made = (_written(found.scene, loaded, pixels, each, options) for each in units)
    return Fitted(min(made, key=len), found.words)


def _written(
    scene: Scene, loaded: LoadedSvg, pixels: tuple[int, int], units: tuple[int, int], options: dict[str, Any]
) -> str:
    """Return the text of ``scene``, in ``pixels`` along the sides of the canvas, of a file with so many ``units``."""
    width, height = units
    scene = scene.scaled(width / pixels[0], height / pixels[1])
    decimals = (loaded.precision or 0) + more_decimals(loaded.width / width) - more_decimals(width / loaded.width)
    if loaded.minified:
        return write_minified(scene, width, height, precision=decimals, **options)
    return write_svg(scene, width, height, precision=max(decimals, _PRECISION), **options)


def _units(
    loaded: LoadedSvg, scene: Scene, root: dict[str, str], purpose: Purpose, pixels: tuple[int, int]
) -> list[tuple[int, int]]:
    """Return the units along the sides of the file for ``purpose``: those of the file ``loaded``, pixels, or both.

    Files of lengths in the world keep theirs. Of the shortest files of fills the shorter text is taken: ten units in a
    pixel need no points, and pixels no zeros.
    """
    own = (round(loaded.width), round(loaded.height))
    if purpose.has_units or physical_size(root) is not None:
        return [own]
    return [own, pixels] if loaded.minified and scene.strokes is None else [pixels]
