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

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.checks import counted
from warpvec.flat.constants.mode_choice import MODE_CHOICE
from warpvec.flat.two_levels import edge_count, has_two_levels
from warpvec.image.spread import spread

Levels = NDArray[np.int16]


class ModeChoice(NamedTuple):
    """The mode that suits a picture, and the reason in a few words.

    Attributes:
        mode: its name.
        reason: why it suits.
        is_doubtful: whether it is a photo if that is shorter to say.
    """

    mode: str
    reason: str
    is_doubtful: bool = False


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


def choose_mode(image: Floats32, was_noisy: bool = False) -> ModeChoice:
    """Return the mode for ``image`` [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha or none.

    Transparent parts are seen over white, and pictures with some are not taken for black and white art. Light on dark
    is such art only if it has two levels, without dither: the drawing is black, with holes. Where the four shares leave
    a doubt, the picture is flat art if plain areas say it more briefly than a photo. One as small as an icon is no
    photo.

    Args:
        image: the picture.
        was_noisy: whether it had noise, which is gone.
    """
    levels = _copy_of(image)
    change = spread(levels)
    is_still = change <= MODE_CHOICE.still_change
    percent = f"{100 * is_still.mean():.0f} % of the area is flat"
    if image.shape[2] == 3 and _is_black_and_white(levels, change, was_noisy):
        return ModeChoice("mono", f"dark on light, {percent}")
    if image.shape[2] == 3 and _is_of_two_levels(image) and _is_black_and_white(255 - levels, change, was_noisy):
        return ModeChoice("mono", f"light on dark, {percent}")
    score = flatness(shares_of(levels, change))
    if score <= 0.0 and max(image.shape[:2]) <= MODE_CHOICE.icon_side:
        return ModeChoice("flat", f"as small as an icon, {percent}")
    if score <= MODE_CHOICE.photo_flatness:
        return ModeChoice("photo", f"textured or shaded, {percent}")
    if score <= 0.0:
        return ModeChoice("flat", f"plain areas explain it, {percent}", is_doubtful=True)
    count = _color_count(levels, is_still)
    colors = "shaded colours" if count > MODE_CHOICE.colors_shown else f"mostly {counted(count, 'colour')}"
    return ModeChoice("flat", f"{colors}, {percent}")


def shares_of_image(image: Floats32) -> Shares:
    """Return the shares of ``image`` [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha or none."""
    levels = _copy_of(image)
    return shares_of(levels, spread(levels))


def flatness(shares: Shares) -> float:
    """Return a number above 0 for flat art and below 0 for photos."""
    weighted = (
        MODE_CHOICE.weak_weight * shares.weak
        + MODE_CHOICE.between_weight * shares.between
        + MODE_CHOICE.shading_weight * shares.shading
        + MODE_CHOICE.lonely_weight * shares.lonely
    )
    return MODE_CHOICE.bias - weighted


def shares_of(levels: Levels, change: Levels) -> Shares:
    """Return the shares of a picture by its ``levels`` [h, w, 3] and their ``change`` in 3 x 3 pixels [h, w]."""
    is_step, is_strong = change > MODE_CHOICE.still_change, change > MODE_CHOICE.strong_change
    if not change.any():
        return Shares(0.0, 0.0, 0.0, 0.0)
    if not is_step.any():  # nothing but soft shading
        return Shares(1.0, 0.0, 1.0, 1.0)
    is_lonely = is_step & ~_widened(is_strong, MODE_CHOICE.edge_reach)
    weak = float((is_step & ~is_strong).sum() / is_step.sum())
    shading = float(change[~is_step].sum() / change.sum())
    return Shares(weak, _between(levels), shading, float(is_lonely.sum() / max((is_lonely | is_strong).sum(), 1)))


def _copy_of(image: Floats32) -> Levels:
    """Return the levels in [0, 255] of a copy of at most ``side`` pixels, over white, without single wrong pixels."""
    colors = np.empty((*image.shape[:2], 3), np.uint8)
    for channel in range(3):  # by planes: NumPy takes longer for the few channels of each pixel
        plane: NDArray[np.floating[Any]] = image[..., channel]
        if image.shape[2] == 4:
            plane = 1.0 + image[..., 3] * (plane - 1.0)
        colors[..., channel] = np.rint(255.0 * plane.clip(0.0, 1.0))
    picture = Image.fromarray(colors)
    factor = MODE_CHOICE.side / max(picture.size)
    if factor < 1.0:
        width, height = (max(1, round(side * factor)) for side in picture.size)
        picture = picture.resize((width, height), Image.Resampling.BOX)
    return np.asarray(picture.filter(ImageFilter.MedianFilter(3))).astype(np.int16)


def _widened(mask: Mask, reach: int) -> Mask:
    """Return the pixels at most ``reach`` rows and columns from one of ``mask`` [h, w]."""
    for axis in (0, 1):
        padding = [(reach, reach) if each == axis else (0, 0) for each in (0, 1)]
        windows = np.lib.stride_tricks.sliding_window_view(np.pad(mask, padding), 2 * reach + 1, axis)
        mask = np.any(windows, axis=2)
    return mask


def _between(levels: Levels) -> float:
    """Return the share of pixels that are between the darkest and the lightest of their block.

    It is that of the channel that varies most.
    """
    side = min(MODE_CHOICE.block_side, *levels.shape[:2])
    rows, columns = levels.shape[0] // side, levels.shape[1] // side
    cut = levels[: rows * side, : columns * side].reshape(rows, side, columns, side, 3)
    blocks = cut.transpose(0, 2, 1, 3, 4).reshape(rows * columns, side * side, 3)
    widest = (blocks.max(1) - blocks.min(1)).argmax(1)
    values = blocks[np.arange(len(blocks)), :, widest]
    low, high = values.min(1, keepdims=True), values.max(1, keepdims=True)
    near = np.maximum(MODE_CHOICE.near_share * (high - low), MODE_CHOICE.near_levels)
    return float(((values > low + near) & (values < high - near)).mean())


def _color_count(levels: Levels, is_still: Mask) -> int:
    """Return the number of different colours, to 1 of 16 levels, that cover a noticeable area; at least 1."""
    code = (levels[is_still] >> 4) @ np.array([256, 16, 1])
    areas = np.bincount(code) if len(code) else np.zeros(1)
    return max(1, int((areas >= MODE_CHOICE.color_area * is_still.size).sum()))


def is_gray(image: Floats32) -> bool:
    """Return whether ``image`` [h, w, 3] in [0, 1] has no colours but those that scans and JPEG give to greys."""
    return bool((255.0 * np.ptp(image[..., :3], 2) > MODE_CHOICE.grey_max).mean() <= MODE_CHOICE.colored_max)


def _is_of_two_levels(image: Floats32) -> bool:
    """Return whether ``image`` [h, w, 3] has two levels only, and is not dithered."""
    grey = image.mean(2, dtype=np.float64)
    return edge_count(grey < 0.5) <= MODE_CHOICE.edges_max * grey.size and has_two_levels(grey)


def _is_one_paint(ink: Floats) -> bool:
    """Return whether the greys of ``ink`` [n] are one colour, as somebody drew it: ink on paper is uneven."""
    low, high = np.quantile(ink, [0.05, 0.95])
    return bool(high - low <= MODE_CHOICE.still_change)


def _is_black_and_white(levels: Levels, change: Levels, was_noisy: bool) -> bool:
    """Return whether the picture has nothing but dark ink on light paper, with strong edges."""
    if ((levels.max(2) - levels.min(2)) > MODE_CHOICE.grey_max).mean() > MODE_CHOICE.colored_max:
        return False
    grey: Floats = levels.sum(2) / 3.0
    is_ink = grey < grey.min() + (grey.max() - grey.min()) / 2
    is_still, is_strong = change <= MODE_CHOICE.still_change, change > MODE_CHOICE.strong_change
    ink, paper = grey[is_ink & ~is_strong], grey[~is_ink & ~is_strong]
    if not len(ink) or not len(paper) or is_ink.mean() > MODE_CHOICE.ink_max:
        return False
    black, white = float(np.median(ink)), float(np.median(paper))
    share = (grey - black) / max(white - black, 1.0)
    is_middle = (share > MODE_CHOICE.middle_range[0]) & (share < MODE_CHOICE.middle_range[1])
    if (
        (is_still & is_middle).mean() > MODE_CHOICE.middle_max
        or is_middle.mean() > MODE_CHOICE.middle_max + MODE_CHOICE.middle_per_edge * is_strong.mean()
    ):
        return False
    is_far = ~_widened(is_strong, MODE_CHOICE.edge_reach)
    is_rough = was_noisy or (bool(is_far.any()) and float(np.median(change[is_far])) >= MODE_CHOICE.scan_noise)
    is_scan = is_rough and not _is_one_paint(ink)
    is_shade = np.minimum(np.abs(grey - black), np.abs(grey - white)) > MODE_CHOICE.shade_levels
    if is_scan:
        is_shaded = (is_far & (change > MODE_CHOICE.shade_step)).mean() > MODE_CHOICE.shade_step_share_max
        darkest, lightest = MODE_CHOICE.scanned_black, MODE_CHOICE.scanned_white
    else:
        is_shaded = (is_far & is_shade).mean() > MODE_CHOICE.shade_share_max
        darkest, lightest = MODE_CHOICE.clean_black, MODE_CHOICE.clean_white
    return not is_shaded and black <= darkest and white >= lightest
