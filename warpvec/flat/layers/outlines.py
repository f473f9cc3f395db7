"""The outlines of a layer: precise where they show, simple where a layer above hides them."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.curves.contours import contours_of, signed_area
from warpvec.flat.layers.covering import Cover, cover_of, is_lettering
from warpvec.flat.layers.fine_outlines import fine_contours_of
from warpvec.flat.layers.hidden_borders import is_in, with_simple_hidden_borders
from warpvec.flat.layers.stacking import StackedLayer
from warpvec.flat.layers.straight_sides import with_straight_sides
from warpvec.flat.regions.regions import Regions
from warpvec.watch.watch import UNWATCHED, Watch


class Outline(NamedTuple):
    """A closed polyline.

    Attributes:
        points: [n, 2] in pixels, x right, y down; holes run the other way.
        scale: enlargement at which curves are fitted to it: above 1 if it was found on a grid finer than pixels, around
            a thin part or in a small picture.
    """

    points: Floats
    scale: float = 1.0


def outlines(regions: Regions, layer: StackedLayer, watch: Watch = UNWATCHED, is_small: bool = False) -> list[Outline]:
    """Return the outlines of ``layer``, on a finer grid if the picture ``is_small``.

    Once the ``watch`` is over, the parts that are left are outlined together, and end where others lie above them.
    """
    found: list[Outline] = []
    for index, part in enumerate(layer.parts):
        if watch.is_over():
            rest = [region for each in layer.parts[index:] for region in each]
            return found + _outlines_of_part(regions, rest, (), is_small)
        found += _outlines_of_part(regions, part, layer.above, is_small)
    return found


def _outlines_of_part(
    regions: Regions, members: Collection[int], above: Collection[int], is_small: bool
) -> list[Outline]:
    cover = cover_of(regions, members, above)
    is_exact = bool((cover.coverage == cover.shown).all())  # beneath others it is a guess
    is_word = is_exact and is_lettering(regions, members)
    is_line = not is_word and regions.noise == 0.0 and _is_thin_line(cover)  # noise makes rough sides of a line
    is_fine = is_word or is_line or (is_exact and is_small)
    loops, area_min = _loops_of(cover, is_word or is_line, is_word, is_fine)
    if cover.above.any() and not (is_word or is_line):
        shows = ndimage.maximum_filter(cover.shown, 3) >= CURVES.contour_level
        loops = [with_simple_hidden_borders(loop, ~is_in(shows, loop), cover) for loop in loops]
    scale = DRAWING.small_scale if is_fine else 1.0
    if is_word or is_line:
        scale = _scale_of(loops, float(cover.coverage.sum()))
    return [Outline(loop + cover.corner, scale) for loop in loops if abs(signed_area(loop)) >= area_min]


def _loops_of(cover: Cover, is_thin: bool, is_word: bool, is_fine: bool) -> tuple[list[Floats], float]:
    """Return the outlines in the box of ``cover``, on a finer grid if ``is_fine``, and the area of the smallest."""
    if is_thin:
        loops = fine_contours_of(cover.coverage)
        loops = [with_straight_sides(loop) for loop in loops] if is_word else loops
        area_min = LETTERING.loop_area_min
    else:
        loops = fine_contours_of(cover.coverage, 0.0) if is_fine else contours_of(cover.coverage)
        is_tiny = max((abs(signed_area(loop)) for loop in loops), default=0.0) < LAYERS.loop_area_min
        area_min = LAYERS.only_loop_area_min if is_tiny else LAYERS.loop_area_min
    return [loop for loop in loops if abs(signed_area(loop)) >= area_min], area_min


def _is_thin_line(cover: Cover) -> bool:
    """Return whether a layer is a line narrower than a pixel.

    Little of it is hidden, little fills whole pixels, and hardly any lies inside, as it does in a blurred shape.
    """
    coverage, area = cover.coverage, cover.coverage.sum()
    if coverage.size > LETTERING.thin_line_box:
        return False
    inside = ndimage.binary_erosion(coverage >= CURVES.contour_level)
    if area < LETTERING.thin_line_area or inside.sum() > LETTERING.thin_line_inside * area:
        return False
    full, hidden = coverage[coverage >= LETTERING.pure_share].sum(), (coverage - cover.shown).sum()
    return bool(max(full, hidden) <= LETTERING.thin_line_max * area)


def _scale_of(loops: list[Floats], area: float) -> float:
    """Return the enlargement for the outlines of a thin part of this ``area``, by its mean width."""
    length = sum(float(np.hypot(*(loop - np.roll(loop, 1, 0)).T).sum()) for loop in loops)
    is_wide = 2.0 * area > LETTERING.wide * length
    return LETTERING.wide_scale if is_wide else LETTERING.scale
