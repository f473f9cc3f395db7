"""An existing drawing: read the SVG, place the scene on the picture, and keep the form of the file."""

from __future__ import annotations

from dataclasses import replace

from warpvec.drawing.encoding import Encoding, flat_units
from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.image.picture import Picture
from warpvec.svg.description import description_of
from warpvec.svg.read import LoadedSvg, read_svg
from warpvec.svg.units import more_decimals


def read_drawing(data: bytes, name: str = "svg") -> LoadedSvg:
    """Read the SVG to begin with; messages call it ``name``.

    Raises:
        InputError: it is not an SVG, or it has no filled paths.
    """
    try:
        drawing = read_svg(data)
    except InputError as error:
        raise error.renamed({"SVG": name}) from error
    if not len(drawing.scene):
        raise InputError(name, "must contain filled paths", "an SVG without any", "vectorize the image from scratch")
    return drawing


def place_on_picture(drawing: LoadedSvg, picture: Picture, name: str = "svg") -> Scene:
    """Return the scene of the drawing in pixels of the picture; messages call the drawing ``name``.

    Raises:
        InputError: their proportions differ by more than a pixel of rounding.
    """
    height, width = picture.height, picture.width
    if abs(drawing.width * height / drawing.height - width) > max(1.0, width / height):
        size = f"{drawing.width:g} x {drawing.height:g}"
        rule = f"must have the proportions of the photo, {width} x {height}"
        raise InputError(name, rule, size, "give the photo that it was made from")
    return drawing.scene.scaled(width / drawing.width, height / drawing.height)


def precision_of(drawing: LoadedSvg) -> int | None:
    """Return the decimals of warpvec's own file, as numbers in pixels would have them; None for other files."""
    if drawing.precision is None:
        return None
    return max(0, drawing.precision - more_decimals(_pixels_per_unit(drawing)))


def _pixels_per_unit(drawing: LoadedSvg) -> float:
    """Return the pixels per unit of warpvec's own file: above 1 if it is in units of a grid."""
    sides = drawing.sides
    return float(sides[0]) / drawing.width if sides is not None and sides[0].isdecimal() else 1.0


def encoding_like(drawing: LoadedSvg, data: bytes, usual: Encoding) -> Encoding:
    """Return the encoding of the ``usual`` file with what it keeps of a drawing given as ``data``.

    It keeps the size, units, title, metadata and names of layers. A drawing whose sides are not whole numbers gets
    those of the picture. Units larger than a pixel get more decimals; in warpvec's own files, those of a grid.
    """
    picture, settings = usual.picture, usual.settings
    is_whole = drawing.width.is_integer() and drawing.height.is_integer()
    size = (int(drawing.height), int(drawing.width)) if is_whole else (picture.height, picture.width)
    unit = _pixels_per_unit(drawing)
    more = more_decimals(picture.width / size[1] if drawing.precision is None else unit)
    title, metadata = description_of(data)
    encoding = replace(
        usual, size=size, precision=settings.precision + more, title=title, metadata=metadata, sides=drawing.sides,
        layer_names=drawing.layer_names, keeps_paths=True, closes_exactly=drawing.closes_exactly,
        grid=max(size) if unit > 1.0 else 0,
    )  # fmt: skip
    if not settings.minify:
        return encoding
    is_exact = drawing.precision is not None and not settings.units
    if encoding.grid:
        encoding = replace(encoding, is_minified=True)
    else:
        encoding = encoding.finer(10**encoding.precision if is_exact else flat_units(settings))
    generation = drawing.scene.generation
    has_layers = drawing.minified and int(generation.max()) > int(generation.min())
    return replace(encoding, keeps_layers=has_layers or settings.lod)
