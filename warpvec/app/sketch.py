"""A rough drawing that is there at once: areas of few colours, which the page shows until a fit has a drawing."""

from __future__ import annotations

from itertools import pairwise
from typing import cast

import contourpy
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from warpvec.arrays import Floats, Mask
from warpvec.image.picture import mean_image
from warpvec.image.write import to_8_bits

SIDE = 320
"""Longest side in pixels of the copy whose areas are outlined: 30 ms for most pictures, and 150 ms for noise."""

COLORS = 16
"""Most colours. Half of the icons and logos of the bench have at most 8, and a gradient needs steps."""

_OPAQUE = 128
"""Alpha in levels from which an area is drawn."""


def sketch(pixels: NDArray[np.float32]) -> str:
    """Return the SVG text of a rough drawing of ``pixels`` [h, w, 3 or 4], at their size.

    Each path is the area of its colour and of all above it, so that there are no gaps.
    """
    height, width = pixels.shape[:2]
    copy = Image.fromarray(to_8_bits(mean_image(pixels, SIDE)))
    chosen = copy.quantize(COLORS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    palette = np.array(chosen.getpalette("RGBA"), int).reshape(-1, 4)
    places = np.asarray(chosen.filter(ImageFilter.ModeFilter(3)))  # single pixels would be half of the outlines
    counts = np.bincount(places.ravel(), minlength=len(palette))
    order = [place for place in np.argsort(-counts) if counts[place] and palette[place, 3] >= _OPAQUE]
    scale = (width / places.shape[1], height / places.shape[0])
    paths = [
        f'<path fill="#{"{:02x}{:02x}{:02x}".format(*palette[place, :3])}" d="{_outlines(shown, scale)}"/>'
        for k, place in enumerate(order)
        if (shown := np.isin(places, order[k:])).any()
    ]
    size = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{"".join(paths)}</svg>'


def _outlines(mask: Mask, scale: tuple[float, float]) -> str:
    """Return the path data of the outlines of ``mask`` [h, w], halfway between pixels, holes included."""
    levels = np.pad(mask, 1, mode="edge").astype(float)
    generator = contourpy.contour_generator(z=levels, fill_type=contourpy.FillType.ChunkCombinedOffset)
    (points,), (starts,) = cast("tuple[list[Floats], list[Floats]]", generator.filled(0.5, 2.0))
    # Sample (1, 1) is the centre of the first pixel; what touches the edge of the picture goes beyond it.
    places = ((points - 0.5) * scale).clip(0.0, (scale[0] * mask.shape[1], scale[1] * mask.shape[0]))
    words = [f"{x:.1f} {y:.1f}" for x, y in places]
    return "".join(f"M{'L'.join(words[start : stop - 1])}Z" for start, stop in pairwise(starts.astype(int)))
