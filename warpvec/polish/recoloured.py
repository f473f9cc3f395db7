"""Find the shapes of a drawing that were recoloured before it was saved: their colours are not those of the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

Pixels = NDArray[np.float32]

RECOLOURED = 24.0 / 255.0
"""Difference of a channel from which on a colour is another one: as in `viewer/assets/replacing.js`."""

_PRECISION = 2
"""Decimals of the coordinates of drawings of other programs."""


def in_colors_of(photo: Pixels, text: str) -> str:
    """Return the SVG ``text`` with its opaque paths of one colour in the colours that ``photo`` [h, w, c] has there.

    Only those change that differ from the median of the pixels where they are seen. So what the user has recoloured is
    told from what a fit has drawn, also after the drawing was saved and opened again.
    """
    loaded = read_svg(text)
    scene, height, width = loaded.scene.cpu(), *photo.shape[:2]
    size = round(loaded.width), round(loaded.height)
    precision = _PRECISION if loaded.precision is None else loaded.precision
    colors = scene.color.clone()
    seen = _seen(draw(write_svg(_numbered(scene), *size, precision=precision), width, height))
    for path in np.flatnonzero(_is_plain(scene)):
        pixels = photo[..., :3][seen == path]
        if len(pixels):
            median = torch.from_numpy(np.median(pixels, 0))
            if float((median - colors[path]).abs().max()) > RECOLOURED:
                colors[path] = median
    if torch.equal(colors, scene.color):
        return text
    scene = replace(scene, color=colors)
    return write_svg(scene, *size, precision=precision, closes_exactly=loaded.closes_exactly)


def _is_plain(scene: Scene) -> NDArray[np.bool_]:
    """Return which paths are opaque and of one colour."""
    kinds = None if scene.gradients is None else scene.gradients.kind == FLAT
    plain: NDArray[np.bool_] = (scene.opacity >= 1.0).numpy() & (True if kinds is None else kinds.numpy())
    return plain


def _numbered(scene: Scene) -> Scene:
    """Return ``scene`` with the number of each path, from 1, as its colour, in place of all paints."""
    number = torch.arange(1, len(scene) + 1)
    levels = torch.stack([number >> 16, number >> 8 & 255, number & 255], 1)
    opaque = torch.ones_like(scene.opacity)
    plain = replace(scene, color=levels / 255.0, opacity=opaque, gradients=None, softness=None)
    return plain if scene.transparent else replace(plain, background=torch.zeros(3))


def _seen(drawn: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the path [h, w] that is seen in each pixel of a numbered scene; -1 for none, and at all edges."""
    number = drawn[..., :3].astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])
    is_inner = minimum_filter(number, 3) == maximum_filter(number, 3)
    found: NDArray[np.int64] = np.where(is_inner, number - 1, -1)
    return found
