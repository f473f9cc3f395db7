"""What a file is worth: drawn by resvg, an independent renderer, and compared with the photo."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterator
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.files import gzip_bytes
from warpvec.rasterize import rasterize
from warpvec.svg import NUMBER, count_segments
from warpvec.svg_safety import Scan, read_text, scan
from warpvec.transparency import PAGES, is_transparent, over

MAX_PIXELS = 2**27
"""Above the largest photo we take (100 megapixels); resvg aborts the process where it cannot allocate."""

MAX_REACH = 2.0**24
"""Pixels from the origin to a point; resvg ends the process somewhere between 3e8 and 1e9."""

Image = NDArray[np.float64]
"""Of shape [h, w, c], in [0, 1]."""

SSIM_WINDOW = 7
"""Side of the square window of SSIM, scikit-image's default."""

# Stabilisers of SSIM for a data range of 1, from Wang et al. 2004: (K1 L)^2 and (K2 L)^2.
_SSIM_C1, _SSIM_C2 = 0.01**2, 0.03**2

# Pixels compared at a time, a few rows at least: their copies in float64 stay in the cache, which takes a third of the
# time of bands of 256 rows 8000 pixels wide.
_BAND_PIXELS, _BAND_ROWS_MIN = 2**16, 16

# CSS pixels per unit of length (CSS 2.1, section 4.3.2); em and ex at resvg's font size of 16.
_PIXELS_PER_UNIT = {
    "": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "in": 96.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "em": 16.0, "ex": 8.0,
}  # fmt: skip


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


def psnr(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Peak signal-to-noise ratio in dB over all channels of two images [h, w, c]; infinite where they are equal.

    Each is uint8, or float in [0, 1]. Images of four channels are RGBA, straight: their error is the mean of those of
    what they show on a black and on a white page.
    """
    _check_images(a, b)
    squares = math.fsum(np.square(x - y).sum() for x, y in _bands(a, b))
    return 10.0 * math.log10(_value_count(a.shape) / squares) if squares else math.inf


def ssim(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Mean structural similarity (Wang et al. 2004) of two images [h, w, c], each uint8 or float in [0, 1].

    Images of four channels are compared on a black and on a white page, as by `psnr`, and the mean is over both.

    Agrees with scikit-image's ``structural_similarity(a, b, channel_axis=2, data_range=1)``: uniform 7x7 windows
    inside the image, sample covariance. On an image smaller than the window, where scikit-image gives up, the
    window is cut to the image.
    """
    _check_images(a, b)
    rows, columns = min(SSIM_WINDOW, a.shape[0]), min(SSIM_WINDOW, a.shape[1])
    maps = (_ssim_map(x, y, rows, columns) for x, y in _bands(a, b, overlap=rows - 1))
    window_count = _value_count((a.shape[0] - rows + 1, a.shape[1] - columns + 1, a.shape[2]))
    return math.fsum(float(similarity.sum()) for similarity in maps) / window_count


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


def stated_size(root: dict[str, str]) -> tuple[float, float]:
    """Width and height in pixels: as stated, else of the view box. What resvg itself would take, or larger."""
    sides = _view_box(root)[2:]
    width, height = (pixels(root.get(name, ""), side) for name, side in zip(("width", "height"), sides, strict=True))
    if any(sides):
        scale = max((width or sides[0]) / sides[0], (height or sides[1]) / sides[1])
        width, height = width or sides[0] * scale, height or sides[1] * scale
    if not width or not height:
        raise InputError("SVG must state its size as width and height or viewBox, this one does not; ask for a size")
    return width, height


def _view_box(root: dict[str, str]) -> list[float]:
    """Left, top, width and height; zeros where there is none to speak of."""
    box = [float(number) for number in re.findall(NUMBER, root.get("viewBox", ""))]
    return box if len(box) == 4 and min(box[2:]) > 0 else [0.0] * 4


def _is_harmless(contents: Scan, width: float, height: float) -> bool:
    """Whether resvg may draw it at ``width`` x ``height`` in this process: its cost is known, its points are near."""
    if not contents.plain:
        return False
    left, top, *sides = _view_box(contents.root)
    unit_count = min(sides) or min(pixels(contents.root.get(name, ""), 0.0) for name in ("width", "height"))
    scale = max(width, height) / unit_count if unit_count else math.inf
    return (contents.reach() + abs(left) + abs(top)) * scale <= MAX_REACH


def pixels(length: str, whole: float) -> float:
    """``length`` in pixels, per cent being of ``whole``; 0 where it states none."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*(%|[a-z]*)\s*", length)
    return float(match[1]) * (_PIXELS_PER_UNIT | {"%": whole / 100}).get(match[2], 0.0) if match else 0.0


def check_pixels(width: float, height: float) -> None:
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS):
        raise InputError(f"SVG must be drawn at 1 to {MAX_PIXELS} pixels, got {width:g} x {height:g}; ask for a size")


def _fitted(image: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """``image`` on exactly ``width`` x ``height``: resvg keeps proportions, which may fall a pixel short."""
    rows, columns = height - image.shape[0], width - image.shape[1]
    if not (0 <= rows <= 1 and 0 <= columns <= 1):
        got = f"{image.shape[1]} x {image.shape[0]}"
        raise InputError(f"SVG must have the proportions of {width} x {height}, got {got}; is it of another photo?")
    return np.pad(image, ((0, rows), (0, columns), (0, 0)), mode="edge")


def _draw_like(svg: str | bytes, photo: NDArray[Any]) -> NDArray[np.uint8]:
    return draw(svg, photo.shape[1], photo.shape[0], transparent=is_transparent(photo))


def _check_images(a: NDArray[Any], b: NDArray[Any]) -> None:
    if a.shape != b.shape or a.ndim != 3 or not a.size:
        raise InputError(f"images to compare must share one shape [h, w, c], got {list(a.shape)} and {list(b.shape)}")
    for image in (a, b):
        if image.dtype != np.uint8 and image.dtype.kind != "f":
            raise InputError(f"images to compare must be uint8 or float in [0, 1], got {image.dtype}; scale them first")


def _bands(a: NDArray[Any], b: NDArray[Any], overlap: int = 0) -> Iterator[tuple[Image, Image]]:
    """Both images as float64 in bands of rows, each ``overlap`` rows into the next; RGBA on its pages [h, w, 6]."""
    row_count = max(_BAND_ROWS_MIN, _BAND_PIXELS // a.shape[1])
    for top in range(0, len(a) - overlap, row_count):
        rows = slice(top, top + row_count + overlap)
        yield _on_pages(_as_float(a[rows], b.dtype)), _on_pages(_as_float(b[rows], a.dtype))


def _on_pages(image: Image) -> Image:
    return np.concatenate([over(image, page) for page in PAGES], axis=2) if is_transparent(image) else image


def _value_count(shape: tuple[int, ...]) -> int:
    """Values that are compared in images of ``shape`` [h, w, c]."""
    return shape[0] * shape[1] * (3 * len(PAGES) if shape[2] == 4 else shape[2])


def _as_float(image: NDArray[Any], other: np.dtype[Any]) -> Image:
    """``image`` in [0, 1]; 8 bits rounded to the precision of the ``other`` that it is compared with."""
    if image.dtype != np.uint8:
        return image.astype(np.float64)
    # So that equal pixels are equal.
    return image / 255.0 if other == np.uint8 else (image / 255.0).astype(other).astype(np.float64)


def _ssim_map(a: Image, b: Image, rows: int, columns: int) -> Image:
    """SSIM of every window of ``rows`` x ``columns`` (Wang et al. 2004, equation 13)."""
    mean_a, mean_b = (_window_mean(x, rows, columns) for x in (a, b))
    # A window of one pixel has no variance to correct.
    unbiased = rows * columns / max(rows * columns - 1, 1)
    variances = unbiased * (_window_mean(a * a + b * b, rows, columns) - mean_a**2 - mean_b**2)
    covariance = unbiased * (_window_mean(a * b, rows, columns) - mean_a * mean_b)
    luminance = (2 * mean_a * mean_b + _SSIM_C1) / (mean_a**2 + mean_b**2 + _SSIM_C1)
    return luminance * (2 * covariance + _SSIM_C2) / (variances + _SSIM_C2)


def _window_mean(x: Image, rows: int, columns: int) -> Image:
    height, width = x.shape[0] - rows + 1, x.shape[1] - columns + 1
    down = functools.reduce(np.add, (x[row : row + height] for row in range(rows)))
    both = functools.reduce(np.add, (down[:, column : column + width] for column in range(columns)))
    return both / (rows * columns)
