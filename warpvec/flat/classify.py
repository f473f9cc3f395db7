"""Choose the mode of a run from the picture: a photo, flat art, or black and white art.

Flat art has few paints. Seen closely, nearly all of it is still; where it is not, a strong edge runs between two
paints. A photo has weak steps everywhere, far from strong edges too, levels between the darkest and the lightest of a
small block, and soft shading. Four shares of the picture measure that, and a weighted sum of them decides.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

Levels = NDArray[np.int16]
Mask = NDArray[np.bool_]

SIDE = 512
"""Longest side in pixels of the copy that is looked at, which takes 0.1 s. Larger pictures are reduced by means."""

STILL, STRONG = 8, 64
"""Largest change of levels (of 255) in 3 x 3 pixels, after a median, of a still place; and smallest of a strong edge.
JPEG of quality 60 changes still places by up to 8."""

REACH = 6
"""Pixels around a strong edge in which weak steps may be traces of JPEG or of anti-aliasing."""

BLOCK = 8
"""Side of the blocks in pixels. Few of them in flat art have more than two paints."""

NEAR_SHARE, NEAR_LEVELS = 0.2, 8
"""A level is between the darkest and the lightest of its block if it is farther from both than this share of their
difference, and than these levels."""

BIAS, WEAK, BETWEEN, SHADING, LONELY = 20.7, 8.6, 49.0, 32.0, 12.0
"""Flat art has BIAS above the weighted sum of the four shares. They come from a logistic regression on the sixteen
pictures of flat art and 28 photos (Kodak, scikit-image), as they are, as JPEG of quality 60 to 95, reduced to 48 to 256
pixels, blurred, noisy, grey, filtered and cropped. Seven of 868 come out wrong, six of them with 48 to 128 pixels."""

COLOR_AREA = 0.002
"""Smallest share of the picture that counts as a colour in the reason."""

COLORS_SHOWN = 24
"""With more colours, the reason says that there are many."""

GREY_MAX = 24
"""Largest difference of the channels of a grey, as scans and JPEG show it."""

COLORED_MAX = 0.002
"""Largest share of coloured pixels in black and white art."""

MIDDLE = (0.25, 0.75)
"""Greys this far from ink to paper are neither of the two."""

MIDDLE_MAX, MIDDLE_PER_EDGE = 0.002, 0.5
"""Largest share of pixels in the middle in black and white art: of still ones, and of all ones for each pixel at a
strong edge."""

CLEAN_BLACK, CLEAN_WHITE, SCANNED_BLACK, SCANNED_WHITE = 16, 240, 96, 190
"""Levels of ink and paper: as drawn by a program, and as scanned, where both are uneven."""

SCAN_NOISE = 2
"""Median change of levels in 3 x 3 pixels far from strong edges, after a median, from which a picture is a scan. Drawn
ones have 0, and at most 1 as JPEG."""

SHADE, SHADE_MAX = 12, 0.005
"""Difference of levels from both ink and paper, and the largest share of pixels far from strong edges with more of it
in black and white art that is no scan: a light shade is a third colour."""

SHADE_STEP, SHADE_STEP_MAX = 20, 0.01
"""Change of levels in 3 x 3 pixels at the border of such a shade, and the largest share of pixels with more of it in
scans, whose paper may grow darker slowly."""

INK_MAX = 0.5
"""Largest share of ink: art is dark on light."""


class Choice(NamedTuple):
    """The mode that suits a picture, and the reason in a few words."""

    mode: str
    reason: str


class Shares(NamedTuple):
    """Four shares that are small in flat art.

    Attributes:
        weak: weak steps among all steps.
        between: pixels with a level between the darkest and the lightest of their block.
        shading: change in still places, of all change.
        lonely: weak steps far from strong edges, among these and strong ones.
    """

    weak: float
    between: float
    shading: float
    lonely: float


def choose_mode(image: NDArray[np.float32]) -> Choice:
    """Return the mode for ``image`` [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha or none.

    Transparent parts are seen over white, and pictures with some are not taken for black and white art.
    """
    levels = _copy_of(image)
    change = _changes(levels)
    is_still = change <= STILL
    percent = f"{100 * is_still.mean():.0f} % of the area is flat"
    if image.shape[2] == 3 and _is_black_and_white(levels, change):
        return Choice("mono", f"dark on light, {percent}")
    if flatness(shares_of(levels, change)) <= 0.0:
        return Choice("photo", f"textured or shaded, {percent}")
    count = _color_count(levels, is_still)
    colors = "1 colour" if count == 1 else f"{count} colours" if count <= COLORS_SHOWN else "shaded colours"
    return Choice("flat", f"{colors}, {percent}")


def flatness(shares: Shares) -> float:
    """Return a number above 0 for flat art and below 0 for photos."""
    weighted = WEAK * shares.weak + BETWEEN * shares.between + SHADING * shares.shading + LONELY * shares.lonely
    return BIAS - weighted


def shares_of(levels: Levels, change: Levels) -> Shares:
    """Return the shares of a picture by its ``levels`` [h, w, 3] and their ``change`` in 3 x 3 pixels [h, w]."""
    is_step, is_strong = change > STILL, change > STRONG
    if not change.any():
        return Shares(0.0, 0.0, 0.0, 0.0)
    if not is_step.any():  # nothing but soft shading
        return Shares(1.0, 0.0, 1.0, 1.0)
    is_lonely = is_step & ~_widened(is_strong, REACH)
    weak = float((is_step & ~is_strong).sum() / is_step.sum())
    shading = float(change[~is_step].sum() / change.sum())
    return Shares(weak, _between(levels), shading, float(is_lonely.sum() / max((is_lonely | is_strong).sum(), 1)))


def _copy_of(image: NDArray[np.float32]) -> Levels:
    """Return the levels in [0, 255] of a copy of at most ``SIDE`` pixels, over white, without single wrong pixels."""
    colors: NDArray[np.floating[Any]] = image[..., :3]
    if image.shape[2] == 4:
        colors = 1.0 + image[..., 3:] * (colors - 1.0)
    picture = Image.fromarray(np.rint(255.0 * colors.clip(0.0, 1.0)).astype(np.uint8))
    factor = SIDE / max(picture.size)
    if factor < 1.0:
        width, height = (max(1, round(side * factor)) for side in picture.size)
        picture = picture.resize((width, height), Image.Resampling.BOX)
    return np.asarray(picture.filter(ImageFilter.MedianFilter(3))).astype(np.int16)


def _changes(levels: Levels) -> Levels:
    """Return the largest difference of a channel in the 3 x 3 pixels around each [h, w]."""
    highest = lowest = np.pad(levels, ((1, 1), (1, 1), (0, 0)), mode="edge")
    for axis in (0, 1):
        parts = [slice(0, -2), slice(1, -1), slice(2, None)]
        places = [(slice(None),) * axis + (part,) for part in parts]
        highest = np.maximum(np.maximum(highest[places[0]], highest[places[1]]), highest[places[2]])
        lowest = np.minimum(np.minimum(lowest[places[0]], lowest[places[1]]), lowest[places[2]])
    change: Levels = (highest - lowest).max(2)
    return change


def _widened(mask: Mask, reach: int) -> Mask:
    """Return the pixels at most ``reach`` rows and columns from one of ``mask`` [h, w]."""
    for axis in (0, 1):
        padding = [(reach, reach) if each == axis else (0, 0) for each in (0, 1)]
        windows = np.lib.stride_tricks.sliding_window_view(np.pad(mask, padding), 2 * reach + 1, axis)
        mask = np.any(windows, axis=2)
    return mask


def _between(levels: Levels) -> float:
    """Return the share of pixels that are between the darkest and the lightest of their block, in the channel that
    varies most."""
    side = min(BLOCK, *levels.shape[:2])
    rows, columns = levels.shape[0] // side, levels.shape[1] // side
    cut = levels[: rows * side, : columns * side].reshape(rows, side, columns, side, 3)
    blocks = cut.transpose(0, 2, 1, 3, 4).reshape(rows * columns, side * side, 3)
    widest = (blocks.max(1) - blocks.min(1)).argmax(1)
    values = blocks[np.arange(len(blocks)), :, widest]
    low, high = values.min(1, keepdims=True), values.max(1, keepdims=True)
    near = np.maximum(NEAR_SHARE * (high - low), NEAR_LEVELS)
    return float(((values > low + near) & (values < high - near)).mean())


def _color_count(levels: Levels, is_still: Mask) -> int:
    """Return the number of different colours, to 1 of 16 levels, that cover a noticeable area; at least 1."""
    code = (levels[is_still] >> 4) @ np.array([256, 16, 1])
    areas = np.bincount(code) if len(code) else np.zeros(1)
    return max(1, int((areas >= COLOR_AREA * is_still.size).sum()))


def _is_black_and_white(levels: Levels, change: Levels) -> bool:
    """Return whether the picture has nothing but dark ink on light paper, with strong edges."""
    if ((levels.max(2) - levels.min(2)) > GREY_MAX).mean() > COLORED_MAX:
        return False
    grey: NDArray[np.float64] = levels.sum(2) / 3.0
    is_ink = grey < grey.min() + (grey.max() - grey.min()) / 2
    is_still, is_strong = change <= STILL, change > STRONG
    ink, paper = grey[is_ink & ~is_strong], grey[~is_ink & ~is_strong]
    if not len(ink) or not len(paper) or is_ink.mean() > INK_MAX:
        return False
    black, white = float(np.median(ink)), float(np.median(paper))
    share = (grey - black) / max(white - black, 1.0)
    is_middle = (share > MIDDLE[0]) & (share < MIDDLE[1])
    if (is_still & is_middle).mean() > MIDDLE_MAX or is_middle.mean() > MIDDLE_MAX + MIDDLE_PER_EDGE * is_strong.mean():
        return False
    is_far = ~_widened(is_strong, REACH)
    is_scan = bool(is_far.any()) and float(np.median(change[is_far])) >= SCAN_NOISE
    is_shade = np.minimum(np.abs(grey - black), np.abs(grey - white)) > SHADE
    third = (
        (is_far & (change > SHADE_STEP)).mean() > SHADE_STEP_MAX if is_scan else (is_far & is_shade).mean() > SHADE_MAX
    )
    if third:
        return False
    darkest, lightest = (SCANNED_BLACK, SCANNED_WHITE) if is_scan else (CLEAN_BLACK, CLEAN_WHITE)
    return black <= darkest and white >= lightest
