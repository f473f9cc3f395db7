"""What a file is worth: drawn by resvg, an independent renderer, and compared with the photo."""

from __future__ import annotations

import math
import re
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.files import gzip_bytes
from warpvec.image.alpha import is_transparent
from warpvec.image.metrics import psnr, ssim
from warpvec.svg.resvg import rasterize
from warpvec.svg.scan import Scan, read_text, scan
from warpvec.svg.units import NUMBER, check_pixels, parse_length, stated_size, view_box

MAX_REACH = 2.0**24
"""Pixels from the origin to a point; resvg ends the process somewhere between 3e8 and 1e9."""


class FileFacts(TypedDict):
    """What an SVG consists of: <path> elements, segments they draw, bytes of text, bytes when gzipped."""

    paths: int
    segments: int
    bytes: int
    gzip_bytes: int


def draw(
    svg: str | bytes, width: int | None = None, height: int | None = None, *, transparent: bool = False
) -> NDArray[np.uint8]:
    """The file drawn by resvg over white: sRGB [height, width, 3]; or, ``transparent``, with straight alpha [..., 4].

    ``svg`` is text, or the bytes of an ``.svg`` or ``.svgz`` file. Without both ``width`` and ``height``, in pixels,
    the size is the one that the file states.

    Raises:
        InputError: not an SVG, not of the proportions asked for (a pixel of rounding is allowed), or refused as
            unsafe: entities, references to other files, too large, too deep.
    """
    text = read_text(svg)
    contents = scan(text)
    if width is None or height is None:
        size = stated_size(contents.root)
        check_pixels(*size)
        return rasterize(text, transparent=transparent, sandboxed=not _is_harmless(contents, *size))
    check_pixels(width, height)
    harmless = _is_harmless(contents, width, height)
    return _fitted(rasterize(text, width, height, transparent=transparent, sandboxed=not harmless), width, height)


def measure(svg: str | bytes, photo: NDArray[Any]) -> dict[str, float]:
    """PSNR (dB) and SSIM of the file, drawn at the photo's size, against ``photo`` [h, w, 3], or [h, w, 4] with alpha.

    It is drawn over white, or with its own alpha where the photo has alpha: then both are compared over black and over
    white. The drawing has 8 bits, as a viewer shows it. The photo is taken as read, 8 bit or float in [0, 1] and not
    rounded, so that a 16-bit photo is not flattered; for 8-bit photos this is the usual 8-bit figure.

    Raises:
        InputError: as `draw`.
    """
    drawing = _draw_like(svg, photo)
    return {"psnr": psnr(drawing, photo), "ssim": ssim(drawing, photo)}


def measure_psnr(svg: str | bytes, photo: NDArray[Any]) -> float:
    """The PSNR of `measure` alone; SSIM takes longer than to draw the file."""
    return psnr(_draw_like(svg, photo), photo)


def count_paths(svg: str | bytes) -> int:
    """Number of <path> elements.

    Raises:
        InputError: not an SVG, or refused as unsafe.
    """
    return len(scan(read_text(svg)).path_data)


def file_facts(svg: str | bytes) -> FileFacts:
    """Counts and sizes of any SVG; those of the text and of its gzip, whichever of the two is given.

    A segment is one curve, line or arc of a path; closing a path counts as none.

    Raises:
        InputError: not an SVG, or refused as unsafe.
    """
    text = read_text(svg)
    data, path_data = text.encode(), scan(text).path_data
    segment_count = sum(map(count_segments, path_data))
    return FileFacts(paths=len(path_data), segments=segment_count, bytes=len(data), gzip_bytes=len(gzip_bytes(data)))


def _is_harmless(contents: Scan, width: float, height: float) -> bool:
    """Whether resvg may draw it at ``width`` x ``height`` in this process: its cost is known, its points are near."""
    if not contents.plain:
        return False
    left, top, *sides = view_box(contents.root)
    unit_count = min(sides) or min(parse_length(contents.root.get(name, ""), 0.0) for name in ("width", "height"))
    scale = max(width, height) / unit_count if unit_count else math.inf
    return (contents.reach() + abs(left) + abs(top)) * scale <= MAX_REACH


def _fitted(image: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """``image`` on exactly ``width`` x ``height``: resvg keeps proportions, which may fall a pixel short."""
    rows, columns = height - image.shape[0], width - image.shape[1]
    if not (0 <= rows <= 1 and 0 <= columns <= 1):
        got = f"{image.shape[1]} x {image.shape[0]}"
        raise InputError(f"SVG must have the proportions of {width} x {height}, got {got}; is it of another photo?")
    return np.pad(image, ((0, rows), (0, columns), (0, 0)), mode="edge")


def _draw_like(svg: str | bytes, photo: NDArray[Any]) -> NDArray[np.uint8]:
    return draw(svg, photo.shape[1], photo.shape[0], transparent=is_transparent(photo))


_GAP = r"[\s,]*+"

_NUMBERS = re.compile(NUMBER)

# The two flags of an arc are single digits that need no separator: "a1 1 0 01.5.5". Where there is no arc a number is
# skipped, not a digit, so that the time is linear.
_ARC = re.compile(f"({_GAP.join([NUMBER] * 3 + ['[01]'] * 2 + [NUMBER] * 2)})|{NUMBER}")

_COMMAND = re.compile(r"([MLHVCSQTAZ])([^MLHVCSQTAZ]*+)", re.IGNORECASE)

_NUMBERS_PER_SEGMENT = {"L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2}


def count_segments(path_data: str) -> int:
    """Lines, curves and arcs that any SVG path data draws; closing a path counts as none."""
    return sum(_count_of_command(letter.upper(), numbers) for letter, numbers in _COMMAND.findall(path_data))


def _count_of_command(letter: str, numbers: str) -> int:
    if letter == "Z":
        return 0
    if letter == "A":
        return sum(match[1] is not None for match in _ARC.finditer(numbers))
    count = len(_NUMBERS.findall(numbers))
    # The pairs that follow the first of a move are lines.
    return max(count // 2 - 1, 0) if letter == "M" else count // _NUMBERS_PER_SEGMENT[letter]


def evaluate(svg: str | bytes, photo: NDArray[Any]) -> dict[str, Any]:
    """Counts, sizes, PSNR (dB) and SSIM of any SVG, drawn by resvg at the size of ``photo`` [h, w, 3].

    Keys: curves (its <path> elements), segments, bytes, gzip_bytes, psnr, ssim, transparent: whether the photo is
    [h, w, 4], with straight alpha, and PSNR and SSIM are those over black and over white.

    Raises:
        InputError: not an SVG, refused as unsafe, or not of the photo's proportions.
    """
    facts = file_facts(svg)
    sizes = {"curves": facts["paths"], "segments": facts["segments"], "bytes": facts["bytes"]}
    quality = {**measure(svg, photo), "transparent": is_transparent(photo)}
    return {**sizes, "gzip_bytes": facts["gzip_bytes"], **quality}
