"""Turn a path under the even-odd rule into one of the same area under the non-zero rule.

Loops that do not cross are turned: a loop inside of an odd number of other loops runs against the loop around it.
Loops that cross are cut at the crossings, by Skia.
"""

from __future__ import annotations

from warpvec.svg.foreign.polygons import area, polygon_of, winding
from warpvec.svg.foreign.shapes import Loop, reversed_loop
from warpvec.svg.foreign.skia import Combiner


def to_nonzero(loops: list[Loop], combiner: Combiner) -> tuple[list[Loop], bool]:
    """Return the loops of an even-odd path so that the non-zero rule fills the same area, and whether that is sure."""
    crossings = combiner.crossing_count(loops)
    if crossings == 0:
        return _oriented(loops), True
    apart = combiner.even_odd(loops)
    return (loops, False) if apart is None else (apart, True)


def _oriented(loops: list[Loop]) -> list[Loop]:
    """Turn loops that do not cross, so that each loop runs against the loop around it."""
    if len(loops) == 1:
        return loops
    polygons = [polygon_of(loop) for loop in loops]
    depths = [
        sum(winding(outer, polygon[0]) % 2 for j, outer in enumerate(polygons) if j != i)
        for i, polygon in enumerate(polygons)
    ]
    return [
        loop if (area(polygon) > 0.0) == (depth % 2 == 0) else reversed_loop(loop)
        for loop, polygon, depth in zip(loops, polygons, depths, strict=True)
    ]
