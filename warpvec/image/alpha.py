"""Images with alpha: straight and premultiplied colours, and the pages that they are judged on.

Outside the renderers colours are straight, as in a PNG. Whatever is averaged, filtered or compared is premultiplied or
on a page, so that the colour of what cannot be seen counts nowhere. An error of a transparent image is the mean of
those over a black and over a white page: with the error c of the premultiplied colours and a of alpha, the mean of c^2
and (c - a)^2, which is zero for equal images alone. An image over any other page is a blend of these two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from torch import Tensor

Pixels = TypeVar("Pixels", "NDArray[Any]", "Tensor")

MATTES = (0.0, 1.0)
"""Grey of the pages: the darkest and the lightest."""

ALPHA_MIN = 0.5 / 255
"""Below half a level of 8 bits an image has no colour to speak of: what filters leave of it is rounding."""


def is_transparent(image: NDArray[Any] | Tensor) -> bool:
    """Whether ``image`` is RGBA [h, w, 4], not RGB."""
    return bool(image.shape[2] == 4)


def over(image: Pixels, page: float) -> Pixels:
    """What ``image`` [h, w, 4], straight, shows on ``page`` [h, w, 3]; blended as encoded, as SVG viewers do."""
    color, alpha = image[..., :3], image[..., 3:]
    return color * alpha + (1.0 - alpha) * page


def premultiplied(image: Pixels) -> Pixels:
    """``image`` [h, w, 4], straight, with its colours times alpha."""
    result = image + 0.0
    result[..., :3] *= image[..., 3:]
    return result


def straight(image: Pixels) -> Pixels:
    """``image`` [h, w, 4], premultiplied, with colours as they are: in [0, 1], and 0 where alpha is all but 0.

    Where a filter has left an alpha above 1, it is divided by before it is clipped, or colours would come out brighter.
    """
    result, alpha = image.clip(0.0, 1.0), image[..., 3:]
    result[..., :3] = (image[..., :3] / alpha.clip(ALPHA_MIN)).clip(0.0, 1.0) * (alpha >= ALPHA_MIN)
    return result
