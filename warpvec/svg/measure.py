"""Measure an SVG: count its elements, draw it with resvg, and compare the rendering with an image.

resvg is a renderer independent of warpvec. `evaluate` gives all figures of a file, `file_facts` and `file_quality` one
half of them each. All of them take text, the bytes of an ``.svg`` or ``.svgz`` file, or a `Document`.
"""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.files import gzip_bytes
from warpvec.image.alpha import is_transparent
from warpvec.image.metrics import psnr, ssim
from warpvec.svg.document import SVG_NAMESPACE, Document, SvgSource, parse_svg
from warpvec.svg.found import found_words, kind_words, stroke_looks
from warpvec.svg.resvg import rasterize
from warpvec.svg.segments import LETTERS, count_path
from warpvec.svg.units import NUMBER, check_pixels, parse_length, physical_size, stated_size, view_box

MAX_REACH = 2.0**24
"""Largest distance of a point from the origin in pixels; resvg ends the process somewhere between 3e8 and 1e9."""

MAX_COST, MAX_COST_PER_PIXEL = 2**29, 32
"""Pixels that may be painted in this process, which has no time limit: as many, and as many for each pixel of the
rendering. A pixel takes up to 17 ns. warpvec paints a picture with 4,096 paths 5 to 20 times over."""

EDGE_COST = 100
"""Number of painted pixels that take as long as one row of one segment. Stripes of half a pixel take the longest."""

MAX_STRETCH = 1.05
"""Largest ratio of two sides' scales that counts as rounding: one pixel of a 2 x 1 icon would be half of it."""

_NUMBERS = re.compile(NUMBER)

FORM_COUNTS = {"circles": "circle", "ellipses": "ellipse", "rects": "rect"}
"""Name of a count of forms -> element of SVG."""

_OWN_DATA = re.compile(r"M[^A-Za-z]*+c[^A-Za-z]*+z")

_OWN_SIZES = re.compile(r"(?:-?(?:\d{1,15}(?:\.\d{1,7})?|\.\d{1,7})(?: |\Z)){4,8}", re.ASCII)

_FORM_EDGES = 8
"""Most segments of a form: those of a rectangle with round corners."""

_CLOSED_AGAIN = re.compile(r"[zZ][\s,]*+[zZ]")
"""resvg calls itself for each of these and ends the process when its stack overflows, at some 10,000."""

MAX_COMMANDS = 2**23
"""Most commands in the paths of a file, twice the segments of the largest fit: to count their segments takes 9 s."""


def evaluate(svg: SvgSource, image: NDArray[Any]) -> dict[str, Any]:
    """Return counts, sizes and quality of an SVG, drawn by resvg at the size of ``image`` [h, w, 3 or 4].

    Keys: ``curves`` (the number of painted elements), the other counts and the sizes of `file_facts`, ``psnr`` and
    ``ssim`` as in `file_quality`, and ``transparent``, which is true if the image has an alpha channel.

    Raises:
        InputError: as `draw`.
    """
    document = parse_svg(svg)
    counts = file_facts(document)
    quality = {**file_quality(document, image), "transparent": is_transparent(image)}
    return {"curves": counts.pop("paths"), **counts, **quality}


def file_facts(svg: SvgSource) -> dict[str, Any]:
    """Count what is in an SVG. The sizes are the same if ``svg`` is gzipped.

    Keys: ``paths`` (painted elements), ``gradients`` (those with one), ``segments``, ``parameters`` (the numbers that
    shape them, as `warpvec.svg.parameters` counts them), ``soft`` (elements with a filter),
    ``strokes`` (those with a stroke, forms included),
    ``circles``, ``ellipses`` and ``rects`` (the paths that are one), ``stroke_looks`` and ``found`` (the looks of the
    strokes, and all of this in words: `warpvec.svg.found`), ``kinds`` (the parts of these words by kind of path),
    ``millimeters`` (width and height, None for a size in pixels), ``bytes``, and ``gzip_bytes``.
    A segment is one curve, line or arc of a path. The line that closes a path counts if it has a length. A circle, an
    ellipse or a rectangle has four, a rectangle with round corners eight. A line has 2 parameters, a quadratic 4, a
    cubic 6, an arc 7, a circle 3, an ellipse 4, a rectangle 6, moves and closes none.

    Raises:
        InputError: ``svg`` is not an SVG, is refused as unsafe, or has more than ``MAX_COMMANDS`` commands.
    """
    document = parse_svg(svg)
    data, path_data = document.text.encode(), document.path_data
    if sum(numbers.count(letter) for numbers in path_data for letter in LETTERS) > MAX_COMMANDS:
        raise InputError("SVG", f"must have at most {MAX_COMMANDS} commands in its paths", "more", "simplify it")
    counts = [count_path(data) for data in path_data]
    parameters = sum(count.parameters for count in counts) + document.painted.form_parameter_count
    shapes, scale = document.painted.shapes, _pixels_per_unit(document.root)
    return {
        "paths": document.painted.count,
        "gradients": document.painted.gradient_count,
        "segments": sum(count.segments for count in counts) + document.painted.form_segment_count,
        "strokes": document.painted.stroke_count,
        "soft": document.painted.soft_count,
        "parameters": parameters,
        **{name: document.painted.names[element] for name, element in FORM_COUNTS.items()},
        "stroke_looks": stroke_looks(shapes, scale),
        "found": found_words(shapes, scale, parameters),
        "kinds": kind_words(shapes, scale),
        "millimeters": physical_size(document.root),
        "bytes": len(data),
        "gzip_bytes": len(gzip_bytes(data)),
    }


def _pixels_per_unit(root: dict[str, str]) -> float:
    """Return the pixels of a user unit; 1 where the root states no view box. Without a size a unit is a pixel."""
    across = view_box(root)[2]
    return stated_size(root)[0] / across if across else 1.0


def file_quality(svg: SvgSource, image: NDArray[Any]) -> dict[str, float]:
    """Return ``psnr`` (dB) and ``ssim`` of an SVG, drawn by `draw_like`, against ``image`` [h, w, 3 or 4].

    An image with alpha is compared over black and over white. The rendering has 8 bits, as a viewer shows it. The image
    is not rounded, so that a 16-bit image is not flattered; for 8-bit images this is the usual 8-bit figure.

    Raises:
        InputError: as `draw`.
    """
    rendering = draw_like(svg, image)
    return {"psnr": psnr(rendering, image), "ssim": ssim(rendering, image)}


def draw_like(svg: SvgSource, image: NDArray[Any]) -> NDArray[np.uint8]:
    """Draw an SVG at the size of ``image`` [h, w, 3 or 4], over white or with alpha, as ``image`` has it.

    Raises:
        InputError: as `draw`.
    """
    return draw(svg, image.shape[1], image.shape[0], transparent=is_transparent(image))


def draw(
    svg: SvgSource, width: int | None = None, height: int | None = None, *, transparent: bool = False
) -> NDArray[np.uint8]:
    """Draw an SVG with resvg: sRGB over white [height, width, 3], or with straight alpha [..., 4] if ``transparent``.

    ``width`` and ``height`` are in pixels. Without both, the file's own size is used.

    Raises:
        InputError: ``svg`` is not an SVG, has other proportions than asked for (a pixel of rounding is allowed), or is
            refused as unsafe: entities, references to other files, too large, too deep.
    """
    document = parse_svg(svg)
    if width is not None and height is not None:
        check_pixels(width, height)
        return _draw_at(document, width, height, transparent)
    size = stated_size(document.root)
    check_pixels(*size)
    return rasterize(document.text, transparent=transparent, sandboxed=not _is_harmless(document, *size))


def _draw_at(document: Document, width: int, height: int, transparent: bool) -> NDArray[np.uint8]:
    """Draw at exactly ``width`` x ``height``: padded by up to a pixel, or stretched by up to a pixel of rounding."""
    sandboxed = not _is_harmless(document, width, height)
    rendering = rasterize(document.text, width, height, transparent=transparent, sandboxed=sandboxed)
    # resvg keeps the proportions of the file, so that a side may be a pixel short.
    rows, columns = height - rendering.shape[0], width - rendering.shape[1]
    if 0 <= rows <= 1 and 0 <= columns <= 1:
        return np.pad(rendering, ((0, rows), (0, columns), (0, 0)), mode="edge")
    rule = f"must have the proportions of {width} x {height}"
    try:
        stated = stated_size(document.root)
    except InputError:
        remedy = "add width and height, or a viewBox, to its <svg>"
        raise InputError("SVG", rule, "no stated size", remedy) from None
    if not _differs_by_rounding(stated, width, height):
        raise InputError("SVG", rule, f"{stated[0]:g} x {stated[1]:g}", "give the image it was made from")
    text = _stretched(document, stated, width, height)
    return rasterize(text, width, height, transparent=transparent, sandboxed=sandboxed)


def _differs_by_rounding(stated: tuple[float, float], width: int, height: int) -> bool:
    """Return whether the ``stated`` size of a file and ``width`` x ``height`` differ by at most a pixel of either."""
    stated_width, stated_height = stated
    across, down = width / stated_width, height / stated_height
    if max(across, down) > MAX_STRETCH * min(across, down):
        return False
    # By how many pixels a side misses that of the other size, scaled by the other side: of the image, and of the file.
    pixels = (abs(across - down) * stated_height, abs(across - down) * stated_width)
    stated_pixels = (abs(1 - down / across) * stated_height, abs(1 - across / down) * stated_width)
    return min(*pixels, *stated_pixels) <= 1


def _stretched(document: Document, stated: tuple[float, float], width: int, height: int) -> str:
    """Return the text with the root, of the ``stated`` size, inside an <svg> that maps it to ``width`` x ``height``."""
    across, down = stated
    data, (start, stop) = document.text.encode(), document.root_range
    outer = (
        f'<warpvec:svg xmlns:warpvec="{SVG_NAMESPACE}" width="{width}" height="{height}"'
        f' viewBox="0 0 {across!r} {down!r}" preserveAspectRatio="none">'
    )
    return b"".join([data[:start], outer.encode(), data[start:stop], b"</warpvec:svg>", data[stop:]]).decode()


def _is_harmless(document: Document, width: float, height: float) -> bool:
    """Return whether resvg may draw it in this process: at a known cost, with all points within ``MAX_REACH``."""
    if not document.plain:
        return False
    left, top, *sides = view_box(document.root)
    unit_count = min(sides) or min(parse_length(document.root.get(name, ""), 0.0) for name in ("width", "height"))
    scale = max(width, height) / unit_count if unit_count else math.inf
    most = MAX_COST + MAX_COST_PER_PIXEL * width * height
    if any(map(_CLOSED_AGAIN.search, document.path_data)):
        return False
    if len(document.text) > most / EDGE_COST or _cost(document, width, height, scale) > most:
        return False
    return (document.reach() + abs(left) + abs(top)) * scale <= MAX_REACH


def _cost(document: Document, width: float, height: float, scale: float) -> float:
    """Return an upper bound of what it costs to draw the paths and forms, in painted pixels.

    A shape that is not like warpvec's own ones counts as large as the rendering.
    """
    cost = sum(_form_cost(numbers, width, height, scale) for numbers in document.forms)
    for numbers in document.path_data:
        points = _own_points(numbers)
        if points is None:
            cost += height * (width + EDGE_COST * sum(1 for _ in _NUMBERS.finditer(numbers)))
        else:
            across, down = np.minimum(np.ptp(points, axis=0) * scale + 2, (width, height))
            cost += down * (across + EDGE_COST * len(points) / 3)
    return float(cost)


def _form_cost(numbers: str, width: float, height: float, scale: float) -> float:
    """Return the cost of a form by its position, its sizes and, if it is turned, a point."""
    if not _OWN_SIZES.fullmatch(numbers):
        return width * height
    first, second, *turn = (float(number) for number in numbers.split()[2:])
    if turn:
        first = second = first + second
    across, down = min(2 * first * scale + 2, width), min(2 * second * scale + 2, height)
    return down * (across + EDGE_COST * _FORM_EDGES)


def _own_points(path_data: str) -> NDArray[np.float64] | None:
    """Return the control points [n, 2] of one closed loop of relative cubics, None for other path data."""
    if not _OWN_DATA.fullmatch(path_data):
        return None
    numbers = np.array([float(match[0]) for match in _NUMBERS.finditer(path_data)])
    if len(numbers) % 6 != 2:
        return None
    start, cubics = numbers[:2], numbers[2:].reshape(-1, 3, 2)
    stops = start + np.cumsum(cubics[:, 2], axis=0)
    starts = np.concatenate([start[None], stops[:-1]]) if len(stops) else stops
    return np.concatenate([start[None], (starts[:, None] + cubics).reshape(-1, 2)])
