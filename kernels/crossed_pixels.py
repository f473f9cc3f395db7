"""The pixels that outlines cross, and how the windings there change with the curves, for the Gauss-Newton matrix.

A move of a curve by (u, v) changes the winding of a pixel by the integral of (x' v - y' u) dt over the part of the
curve in the pixel, as in ``coverage_adjoint.py``. Here it is summed over samples, because the matrix steers steps and
needs no exact areas. One work item walks over all curves: there are few.

A side of a stroke moves across itself as its centre line does, and by half of what the width grows. Joins are left out.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import bezier
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import bundle, make_lanes, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.vectors import as_real, unit_of, vec2

SAMPLE_GAP = 0.35
"""Largest distance of two samples of a curve in pixels, by its control polygon. Half the gap changes the PSNR after 30
iterations by less than 0.1 dB either way."""

SAMPLES_MIN, SAMPLES_MAX = 4, 4096
"""Fewest samples of a curve, and the most, which bound the work on one wild curve."""

FILL, STROKE, STROKE_START, CLOSING, LEFT_OUT = range(5)
"""What a row is: a curve of a fill or of a stroke, the first one of an open stroke, its last row, or left out."""

ROW_VALUES = 9
"""Values of a row: the coordinates of the four points of its curve, and the width of its stroke."""

ENTRIES, PIXELS = 0, 1
"""Indices of counts: of pairs of a curve and a pixel, and of pixels."""

_SPEED_MIN = 1e-9  # length of a tangent in pixels below which it has no direction
_CAP_PLACE = 1e-3  # parameter at which the direction of a cap is looked at

real = wp.float64
_LANES = make_lanes(1, real)
vec4 = _LANES.vec4
vec9 = wp.types.vector(ROW_VALUES, dtype=wp.float64)


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``cross_pixels``."""
    module = unit("normal_matrix")
    curves = bezier.make_functions(_LANES)
    gap_max = wp.constant(real(SAMPLE_GAP))
    speed_min = wp.constant(real(_SPEED_MIN))
    zero, half, one, three = (wp.constant(real(value)) for value in (0.0, 0.5, 1.0, 3.0))

    @wp.func
    def sample_count(length: real):
        return wp.clamp(int(wp.ceil(length / gap_max)), wp.static(SAMPLES_MIN), wp.static(SAMPLES_MAX))

    @wp.func
    def point_at(w: vec4, p0: vec2, p1: vec2, p2: vec2, p3: vec2):
        return w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3

    @wp.func
    def tangent_at(t: real, p0: vec2, p1: vec2, p2: vec2, p3: vec2):
        s = one - t
        return three * (s * s * (p1 - p0) + real(2.0) * s * t * (p2 - p1) + t * t * (p3 - p2))

    @wp.func
    def slopes_of(w: vec4, along: vec2, by_width: real):
        found = vec9()
        for k in range(4):
            found[2 * k] = -along[1] * w[k]
            found[2 * k + 1] = along[0] * w[k]
        found[8] = by_width
        return found

    @wp.func
    def add(
        row: int,
        place: vec2,
        slopes: vec9,
        size: wp.vec3i,
        entry_row: wp.array(dtype=int),
        entry_pixel: wp.array(dtype=int),
        entry_next: wp.array(dtype=int),
        entry_slopes: wp.array(dtype=vec9),
        pixel_entry: wp.array(dtype=int),
        pixels: wp.array(dtype=int),
        counts: wp.array(dtype=int),
    ):
        """Add a sample to the pair of its row and its pixel, which is a new one unless the sample before has it."""
        fits = place[0] >= zero and place[1] >= zero and place[0] < real(size[1]) and place[1] < real(size[2])
        if fits:
            x, y = int(place[0]), int(place[1])
            tile = (y // wp.static(TILE)) * size[0] + x // wp.static(TILE)
            pixel = tile * wp.static(TILE * TILE) + (x % wp.static(TILE)) * wp.static(TILE) + y % wp.static(TILE)
            entry = counts[wp.static(ENTRIES)]
            is_last = False
            if entry > 0 and entry <= entry_row.shape[0]:
                is_last = entry_row[entry - 1] == row and entry_pixel[entry - 1] == pixel
            if is_last:
                entry_slopes[entry - 1] = entry_slopes[entry - 1] + slopes
            else:
                counts[wp.static(ENTRIES)] = wp.min(entry, entry_row.shape[0]) + 1  # one too many: there is no room
                if entry < entry_row.shape[0]:
                    entry_row[entry] = row
                    entry_pixel[entry] = pixel
                    entry_slopes[entry] = slopes
                    before = pixel_entry[pixel]
                    entry_next[entry] = before
                    pixel_entry[pixel] = entry
                    if before < 0:
                        pixels[counts[wp.static(PIXELS)]] = pixel
                        counts[wp.static(PIXELS)] = counts[wp.static(PIXELS)] + 1

    @wp.kernel(module=module)
    def cross_pixels(
        first: int,
        row_count: int,  # R
        points: wp.array(dtype=wp.vec2f),  # [3 R] px
        row_next: wp.array(dtype=int),  # [R]
        row_previous: wp.array(dtype=int),  # [R]
        row_path: wp.array(dtype=int),  # [R]
        row_kind: wp.array(dtype=int),  # [R] FILL, STROKE, ...
        path_width: wp.array(dtype=float),  # [N] px; of strokes only
        path_is_round: wp.array(dtype=int),  # [N] whether the caps are no straight lines; of strokes only
        size: wp.vec3i,  # columns of tiles, width and height of the canvas
        # outputs
        entry_row: wp.array(dtype=int),  # [M]
        entry_pixel: wp.array(dtype=int),  # [M] TILE TILE times the tile, plus the place in it, column by column
        entry_next: wp.array(dtype=int),  # [M] the entry before in the same pixel, or -1
        entry_slopes: wp.array(dtype=vec9),  # [M] change of the winding with the values of the row
        pixel_entry: wp.array(dtype=int),  # [tiles TILE TILE] the last entry of each pixel, or -1, as at the beginning
        pixels: wp.array(dtype=int),  # [M] the pixels
        counts: wp.array(dtype=int),  # [2] of entries, which may be more than there is room for, and of pixels
    ):
        """Walk along all curves, and note the pixels that they cross."""
        for row in range(row_count):
            kind = row_kind[row]
            if kind != wp.static(LEFT_OUT):
                radius, is_round = zero, int(0)
                if kind != wp.static(FILL):
                    radius = half * real(path_width[row_path[row]])
                    is_round = path_is_round[row_path[row]]
                curve = row
                if kind == wp.static(CLOSING):  # its curve is none; the one before ends in a cap
                    curve = row_previous[row]
                following = row_next[curve]
                a, b = points[3 * curve], points[3 * curve + 1]
                c, d = points[3 * curve + 2], points[3 * following]
                p0, p1, p2, p3 = as_real(a), as_real(b), as_real(c), as_real(d)
                count = sample_count(wp.length(p1 - p0) + wp.length(p2 - p1) + wp.length(p3 - p2))
                gap = one / real(count)
                if kind == wp.static(FILL):
                    for i in range(count):
                        t = (real(i) + half) * gap
                        w = curves.weights(t)
                        along = gap * tangent_at(t, p0, p1, p2, p3)
                        add(
                            row, point_at(w, p0, p1, p2, p3), slopes_of(w, along, zero), size, entry_row, entry_pixel,
                            entry_next, entry_slopes, pixel_entry, pixels, counts,
                        )  # fmt: skip
                elif kind != wp.static(CLOSING):
                    for side in range(2):
                        sign = one - real(2 * side)  # the right side runs back
                        for i in range(count):
                            t = (real(i) + half) * gap
                            w, tangent = curves.weights(t), tangent_at(t, p0, p1, p2, p3)
                            ahead = unit_of(tangent, speed_min)
                            normal = vec2(-ahead[1], ahead[0])
                            turned = unit_of(tangent_at(t + half * gap, p0, p1, p2, p3), speed_min)
                            turned = turned - unit_of(tangent_at(t - half * gap, p0, p1, p2, p3), speed_min)
                            bend = radius * vec2(-turned[1], turned[0])  # the change of the normal, times the radius
                            along = sign * (gap * tangent + sign * bend)
                            outward = sign * normal
                            by_width = half * (along[0] * outward[1] - along[1] * outward[0])
                            add(
                                row, point_at(w, p0, p1, p2, p3) + radius * outward, slopes_of(w, along, by_width),
                                size, entry_row, entry_pixel, entry_next, entry_slopes, pixel_entry, pixels, counts,
                            )  # fmt: skip
                if kind == wp.static(CLOSING) or kind == wp.static(STROKE_START):
                    at, w, out = (
                        p0,
                        vec4(one, zero, zero, zero),
                        -unit_of(tangent_at(real(_CAP_PLACE), p0, p1, p2, p3), speed_min),
                    )
                    if kind == wp.static(CLOSING):
                        at, w = p3, vec4(zero, zero, zero, one)
                        out = unit_of(tangent_at(one - real(_CAP_PLACE), p0, p1, p2, p3), speed_min)
                    across = vec2(-out[1], out[0])
                    count = sample_count(real(wp.pi) * radius)
                    gap = one / real(count)
                    for i in range(count):
                        share = (real(i) + half) * gap
                        outward = (one - real(2.0) * share) * across
                        along = -real(2.0) * radius * gap * across
                        if is_round != 0:
                            angle = real(wp.pi) * share
                            outward = wp.cos(angle) * across + wp.sin(angle) * out
                            along = radius * real(wp.pi) * gap * (wp.cos(angle) * out - wp.sin(angle) * across)
                        by_width = half * (along[0] * outward[1] - along[1] * outward[0])
                        add(
                            curve, at + radius * outward, slopes_of(w, along, by_width), size, entry_row, entry_pixel,
                            entry_next, entry_slopes, pixel_entry, pixels, counts,
                        )  # fmt: skip

    return bundle(cross_pixels)
