"""The outlines of a layer: precise where they show, simple where a layer above hides them."""

from __future__ import annotations

from collections.abc import Collection

from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.curves.contours import contours_of, signed_area
from warpvec.flat.layers.covering import cover_of
from warpvec.flat.layers.hidden_borders import is_in, with_simple_hidden_borders
from warpvec.flat.layers.stacking import StackedLayer
from warpvec.flat.regions.regions import Regions


def outlines(regions: Regions, layer: StackedLayer) -> list[Floats]:
    """Return the closed polylines [n, 2] of ``layer`` in pixels, x right, y down; holes run the other way."""
    return [loop for part in layer.parts for loop in _outlines_of_part(regions, part, layer.above)]


def _outlines_of_part(regions: Regions, members: Collection[int], above: Collection[int]) -> list[Floats]:
    cover = cover_of(regions, members, above)
    loops = contours_of(cover.coverage)
    is_tiny = max((abs(signed_area(loop)) for loop in loops), default=0.0) < LAYERS.loop_area_min
    area_min = LAYERS.only_loop_area_min if is_tiny else LAYERS.loop_area_min
    loops = [loop for loop in loops if abs(signed_area(loop)) >= area_min]
    if cover.above.any():
        shows = ndimage.maximum_filter(cover.shown, 3) >= CURVES.contour_level
        loops = [with_simple_hidden_borders(loop, ~is_in(shows, loop), cover) for loop in loops]
    return [loop + cover.corner for loop in loops if abs(signed_area(loop)) >= area_min]
