"""Find the photos in a drawing: a picture in a screenshot, a portrait on a card, a product on plain ground.

A drawing has still areas: one colour, or a gradient, which a plane explains. What is left over is edges, which are
thin, and photos, which are wide, full of weak changes, and have a short outline.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers32, Mask
from warpvec.condition.jpeg import Jpeg
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.mode_choice import MODE_CHOICE
from warpvec.flat.constants.textures import TEXTURES
from warpvec.flat.explanation import is_shorter_as_photo
from warpvec.flat.mode_choice import Levels, flatness, shares_of_image
from warpvec.flat.mono import otsu_threshold
from warpvec.flat.regions.regions import find_regions, unexplained
from warpvec.image.spread import largest_channel, spread


def find_textures(image: Floats32, is_jpeg: bool = False, jpeg: Jpeg | None = None) -> Mask | None:
    """Return which pixels [h, w] of ``image`` [h, w, 3] in [0, 1] belong to photos, their mixed edges included.

    None stands for a picture that has no photo in it, or is nothing but one.

    Args:
        image: the picture.
        is_jpeg: whether the picture was a JPEG, in which nothing is quite still.
        jpeg: the JPEG, if the blocks of the picture are still its own.
    """
    if min(image.shape[:2]) < TEXTURES.side_min or max(image.shape[:2]) <= TEXTURES.thumbnail_side:
        return None
    levels = np.rint(255.0 * image[..., :3]).astype(np.int16)
    change = spread(levels)
    is_drawn = _drawn(levels, change, is_jpeg)
    if is_drawn.mean() < TEXTURES.drawn_min:
        return None
    parts, count = ndimage.label(_wide(~is_drawn))
    found = np.zeros(parts.shape, bool)
    area_min = max((TEXTURES.jpeg_area_min if is_jpeg else TEXTURES.area_min) * parts.size, TEXTURES.side_min**2)
    for number, place in enumerate(ndimage.find_objects(parts), 1):
        is_part = parts[place] == number
        if (
            is_part.sum() >= area_min
            and _is_texture(is_part, change[place])
            and _is_rough(is_part, levels[place])
            and _has_many_levels(levels[place][is_part])
            and not _is_flat_box(image[place])
            and not _is_drawing(is_part, image[place])  # these two last, as they take longest
            and _is_photo(place, image, jpeg)
        ):
            found[place] |= is_part
    return _with_edges(found, ~is_drawn) if count and found.any() else None


def _drawn(levels: Levels, change: Levels, is_jpeg: bool) -> Mask:
    """Return the pixels [h, w] of still areas that a plane explains."""
    limit = TEXTURES.jpeg_still_change if is_jpeg else TEXTURES.still_change
    parts, count = ndimage.label(change <= limit)
    if not count:
        return np.zeros(change.shape, bool)
    rest_max = TEXTURES.jpeg_rest_max if is_jpeg else TEXTURES.rest_max
    area = np.bincount(parts.ravel())
    is_drawn = (area >= TEXTURES.still_area) & (_rest_of_planes(levels, parts) <= rest_max)
    is_drawn[0] = False
    # A still place has still surroundings, up to the edge.
    return np.asarray(ndimage.binary_dilation(is_drawn[parts], np.ones((3, 3), bool)))


def _rest_of_planes(levels: Levels, parts: Integers32) -> Floats:
    """Return the root mean square [P + 1] that the best plane leaves of the ``levels`` in each of the ``parts``."""

    def means(values: Floats) -> Floats:
        return np.asarray(np.bincount(index, values.ravel())) / area

    index = parts.ravel()
    area = np.maximum(np.bincount(index), 1).astype(np.float64)
    places: Floats = np.indices(parts.shape).astype(np.float64)
    down, across = places[0], places[1]
    x: Floats = across - means(across)[parts]
    y: Floats = down - means(down)[parts]
    xx, xy, yy = means(x * x), means(x * y), means(y * y)
    scale = np.maximum(xx * yy - xy * xy, 1e-6)
    worst = np.zeros(len(area))
    for channel in range(3):
        level = levels[..., channel].astype(np.float64)
        level = level - means(level)[parts]
        vx, vy, vv = means(level * x), means(level * y), means(level * level)
        x_slope, y_slope = (vx * yy - vy * xy) / scale, (vy * xx - vx * xy) / scale
        worst = np.maximum(worst, vv - x_slope * vx - y_slope * vy)
    return np.sqrt(np.maximum(worst, 0.0))


def _wide(is_other: Mask) -> Mask:
    """Return the parts of ``is_other`` [h, w] that are wider than edges and letters, without holes."""
    reach = TEXTURES.core_reach
    square = np.ones((2 * reach + 1, 2 * reach + 1), bool)
    padded = np.pad(is_other, reach, mode="edge")
    core = ndimage.binary_opening(padded, square)[reach:-reach, reach:-reach]
    return with_filled_holes(core)


def _is_texture(is_part: Mask, change: Levels) -> bool:
    """Return whether a part [h, w] of a picture, with its ``change``, is a photo by its outline and its texture."""
    area = int(is_part.sum())
    inside = ndimage.binary_erosion(np.pad(is_part, 1))[1:-1, 1:-1]
    length = int((is_part & ~inside).sum())
    if length > TEXTURES.roundness_max * (4.0 * np.pi * area) ** 0.5:
        return False
    own = change[is_part]
    is_textured = own > TEXTURES.textured_change
    is_weak = is_textured & (own < MODE_CHOICE.strong_change)
    return bool(
        (own > TEXTURES.changing_change).mean() >= TEXTURES.changing_min
        and is_textured.mean() >= TEXTURES.textured_min
        and is_weak.mean() >= TEXTURES.weak_min
    )


def _is_rough(is_part: Mask, levels: Levels) -> bool:
    """Return whether the ``levels`` of a part [h, w] differ from those around them. Those of a shadow do not."""
    inside = ndimage.binary_erosion(is_part, iterations=TEXTURES.core_reach)
    rough = largest_channel(np.abs(levels - ndimage.uniform_filter(levels.astype(np.float64), (3, 3, 1))))
    return bool(inside.any() and (rough[inside] > TEXTURES.rough_change).mean() >= TEXTURES.rough_min)


def _has_many_levels(levels: Levels) -> bool:
    """Return whether ``levels`` [n, 3] are more than a dark and a light one, as those around the edge of a JPEG are."""
    gray = levels.mean(1)
    is_dark = gray < 255.0 * otsu_threshold(gray / 255.0)
    if is_dark.all() or not is_dark.any():
        return True
    dark, light = np.median(gray[is_dark]), np.median(gray[~is_dark])
    off = np.abs(gray - np.where(is_dark, dark, light))
    return bool((off > TEXTURES.off_share * (light - dark)).mean() >= TEXTURES.off_min)


def _is_flat_box(image: Floats32) -> bool:
    """Return whether the box ``image`` [h, w, 3] around a part would be flat art beyond doubt."""
    shares = shares_of_image(image)
    return flatness(shares) > TEXTURES.flatness_max and shares.shading < TEXTURES.shading_min


def _is_drawing(is_part: Mask, image: Floats32) -> bool:
    """Return whether few regions of flat art leave little of a part [h, w] of ``image`` [h, w, 3].

    The price alone takes a soft shadow in a JPEG for a photo: regions have no soft paths.
    """
    middle = _middle(is_part.shape)
    is_part, image = is_part[middle], image[middle]
    inside = ndimage.binary_erosion(is_part, iterations=TEXTURES.core_reach)
    if not inside.any():
        return False
    image = np.ascontiguousarray(image[..., :3])
    regions = find_regions(image)
    count, left = len(np.unique(regions.label[inside])), unexplained(regions.mixed(), image, inside)
    is_little = left <= TEXTURES.drawing_rest_max and count**0.5 * left <= TEXTURES.drawing_root_max
    return is_little and count * left <= TEXTURES.drawing_product_max


def _is_photo(place: tuple[slice, ...], image: Floats32, jpeg: Jpeg | None) -> bool:
    """Return whether a photo says the middle of the part of ``image`` [h, w, 3] at a ``place`` more briefly.

    The middle lies on the grid of a JPEG.
    """
    sides = [min(each.stop - each.start, TEXTURES.judged_side) for each in place]
    starts = [(each.start + each.stop - side) // 2 // 16 * 16 for each, side in zip(place, sides, strict=True)]
    middle = tuple(slice(start, start + side) for start, side in zip(starts, sides, strict=True))
    return is_shorter_as_photo(np.ascontiguousarray(image[middle]), jpeg)


def _middle(shape: tuple[int, ...]) -> tuple[slice, ...]:
    """Return the middle of an area of this ``shape``, at most as large as one that is judged in a second or two."""
    starts = [max(side - TEXTURES.judged_side, 0) // 2 for side in shape]
    return tuple(slice(start, start + TEXTURES.judged_side) for start in starts)


def _with_edges(found: Mask, is_other: Mask) -> Mask:
    """Return ``found`` [h, w] with the pixels near it that are not drawn: mixed edges, and corners."""
    reach = TEXTURES.core_reach
    wider = ndimage.binary_dilation(found, np.ones((3, 3), bool), iterations=reach, mask=found | is_other)
    return with_filled_holes(wider)
