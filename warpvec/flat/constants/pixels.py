"""The numbers of flat art: pixels that are meant."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PixelConstants:
    """When the pixels of a picture are meant, and which of their colours are one. Levels are of 255."""

    # Colours (cells.py)

    colors_max: int = 256
    """Most colours of a drawing of pixels; more are reduced to as many."""

    jpeg_levels: int = 16
    """Largest difference of a channel between colours that JPEG has made of one. The colours of a picture of 16 x 16
    pixels, enlarged 20 times and saved as JPEG 70, differ by up to 11."""

    jpeg_rare_share: float = 0.03
    """A colour with a smaller share of the pixels joins a frequent one within twice these levels."""

    # Which pixels are meant (choice.py)

    chosen_colors_max: int = 32
    chosen_side_max: int = 192
    given_side_max: int = 32
    small_side: int = 64
    """Most colours and longest side in pixels of pixel art and codes, whose largest have 177; and longest side of
    pictures that were not enlarged, and of small ones."""

    between_levels: int = 8
    between_share_max: float = 0.05
    """A pixel is anti-aliased if its colour lies between those of two opposite neighbours, by so many levels; and the
    largest share of such pixels among those at edges. Icons of 16 to 64 px that a renderer drew have 0.15 and more,
    unless all edges lie on the grid."""

    run_max: float = 4.0
    small_run_max: float = 6.0
    """Longest mean distance in pixels between corners of outlines, in large and in small pictures. Drawings of long
    lines and of rectangles have more; a code has 2."""

    corners_min: int = 24
    """Fewest corners: less is a mark of a few rectangles."""

    rectangle_run_min: float = 2.0
    """Least mean distance in pixels between corners of a mark of few rectangles. A disc of 8 px or more without
    anti-aliasing has 1.82 or less."""

    code_corners: float = 0.15
    """Fewest corners for each pixel in a picture of two colours: a QR code with its margin has 0.4, a disc without
    anti-aliasing 0.03."""


PIXELS = PixelConstants()
