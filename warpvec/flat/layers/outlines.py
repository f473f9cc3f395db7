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
from warpvec.flat.layers.modules import without_modules
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
        is_exact: whether its points are the corners of a shape of whole pixels, which lines join.
    """

    points: Floats
    scale: float = 1.0
    is_exact: bool = False


def outlines(regions: Regions, layer: StackedLayer, watch: Watch = UNWATCHED, is_fine: bool = False) -> list[Outline]:
    """Return the outlines of ``layer``. With ``is_fine``, those of all that is seen whole are found on a finer grid.

    Once the ``watch`` is over, the parts that are left are outlined together, and end where others lie above them.
    """
    found: list[Outline] = []
    for index, part in enumerate(layer.parts):
        if watch.is_over():
            rest = [region for each in layer.parts[index:] for region in each]
            return found + _outlines_of_part(regions, rest, (), is_fine)
        found += _outlines_of_part(regions, part, layer.above, is_fine)
    return found


def _outlines_of_part(
    regions: Regions, members: Collection[int], above: Collection[int], is_fine: bool
) -> list[Outline]:
    cover = cover_of(regions, members, above)
    modules, cover = without_modules(cover)
    found = [Outline(loop, is_exact=True) for loop in modules]
    is_exact = bool((cover.coverage == cover.shown).all())  # beneath others it is a guess
    is_word = is_exact and is_lettering(regions, members)
    is_line = not is_word and regions.noise == 0.0 and _is_thin_line(cover)  # noise makes rough sides of a line
    if is_word or is_line:
        found += _thin_outlines(cover, is_word)
    else:
        found += _usual_outlines(cover, is_fine and is_exact)
    return [outline._replace(points=outline.points + cover.corner) for outline in found]


def _thin_outlines(cover: Cover, is_word: bool) -> list[Outline]:
    """Return the outlines of a word or a thin line, on a finer grid, in the box of ``cover``."""
    loops = fine_contours_of(cover.coverage)
    if is_word:
        loops = [with_straight_sides(loop) for loop in loops]
    loops = _of_area(loops, LETTERING.loop_area_min)
    scale = _scale_of(loops, float(cover.coverage.sum()))
    return [Outline(loop, scale) for loop in loops]


def _usual_outlines(cover: Cover, is_fine: bool) -> list[Outline]:
    """Return the outlines of other parts in the box of ``cover``, on a finer grid if ``is_fine``."""
    loops = fine_contours_of(cover.coverage, 0.0) if is_fine else contours_of(cover.coverage)
    is_tiny = max((abs(signed_area(loop)) for loop in loops), default=0.0) < LAYERS.loop_area_min
    area_min = LAYERS.only_loop_area_min if is_tiny else LAYERS.loop_area_min
    loops = _of_area(loops, area_min)
    if cover.above.any():
        shows = ndimage.maximum_filter(cover.shown, 3) >= CURVES.contour_level
        loops = _of_area([with_simple_hidden_borders(loop, ~is_in(shows, loop), cover) for loop in loops], area_min)
    scale = DRAWING.small_scale if is_fine else 1.0
    return [Outline(loop, scale) for loop in loops]


def _of_area(loops: list[Floats], least: float) -> list[Floats]:
    """Return the ``loops`` of at least so many square pixels."""
    return [loop for loop in loops if abs(signed_area(loop)) >= least]


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
