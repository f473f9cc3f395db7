"""Convert images with alpha between straight and premultiplied colours, and composite them over mattes.

Outside the renderers colours are straight, as in a PNG. Images are averaged, filtered and compared with premultiplied
colours or over a matte, so that the colour of invisible pixels never counts. The error of a transparent image is the
mean of its errors over a black and over a white matte. If c is the error of the premultiplied colours and a the error
of alpha, this is the mean of c^2 and (c - a)^2, which is zero for equal images only. An image over any other matte is a
blend of these two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from torch import Tensor

Pixels = TypeVar("Pixels", "NDArray[Any]", "Tensor")

MATTES = (0.0, 1.0)
"""Grey values of the mattes that transparent images are compared over: black and white."""

ALPHA_MIN = 0.5 / 255
"""Smallest alpha with a colour: half of an 8-bit level. Below it a filtered colour is only rounding error."""


def is_transparent(image: NDArray[Any] | Tensor) -> bool:
    """Return whether ``image`` is RGBA [h, w, 4], not RGB."""
    return bool(image.shape[2] == 4)


def over(image: Pixels, matte: float) -> Pixels:
    """Return straight ``image`` [h, w, 4] over the grey ``matte`` [h, w, 3], blended as encoded, as SVG viewers do."""
    if isinstance(image, np.ndarray):
        found = np.empty((*image.shape[:-1], 3), image.dtype)
        _blend(image, matte, found)
        return found
    color, alpha = image[..., :3], image[..., 3:]
    return color * alpha + (1.0 - alpha) * matte


def _blend(image: NDArray[Any], matte: float, found: NDArray[Any]) -> None:
    """Write `over` to ``found`` [h, w, 3] by planes: NumPy takes four times as long for the few channels of a pixel."""
    alpha = image[..., 3]
    behind = (1.0 - alpha) * matte
    for channel in range(3):
        found[..., channel] = image[..., channel] * alpha + behind


def over_mattes(image: NDArray[Any]) -> NDArray[Any]:
    """Return straight ``image`` [h, w, 4] over each of ``MATTES``, side by side [h, w, 6]; an opaque one as it is."""
    if not is_transparent(image):
        return image
    found = np.empty((*image.shape[:2], 3 * len(MATTES)), image.dtype)
    for number, matte in enumerate(MATTES):
        _blend(image, matte, found[..., 3 * number : 3 * number + 3])
    return found


def from_mattes(image: NDArray[Any]) -> NDArray[Any]:
    """Return the straight image [h, w, 4] that is ``image`` [h, w, 6] over ``MATTES``."""
    black, white = image[..., :3], image[..., 3:]
    return straight(np.concatenate([black, 1.0 - (white - black).mean(2, keepdims=True)], 2))


def premultiplied(image: Pixels) -> Pixels:
    """Return straight ``image`` [h, w, 4] with its colours multiplied by alpha."""
    result = image + 0.0
    for channel in range(3):  # by planes, as in `_blend`
        result[..., channel] *= image[..., 3]
    return result


def straight(image: Pixels) -> Pixels:
    """Return premultiplied ``image`` [h, w, 4] with straight colours in [0, 1], 0 where alpha is below ``ALPHA_MIN``.

    A filter may leave an alpha above 1. Colours are divided by that alpha, and then the alpha is clipped: this makes no
    colour brighter.
    """
    result, alpha = image.clip(0.0, 1.0), image[..., 3:]
    result[..., :3] = (image[..., :3] / alpha.clip(ALPHA_MIN)).clip(0.0, 1.0) * (alpha >= ALPHA_MIN)
    return result
