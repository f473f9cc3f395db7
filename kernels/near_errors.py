"""The error of a picture in the pixels that each curve passes, and in those beside them."""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import bezier
from warpvec.kernels.lanes import bundle, make_lanes, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.vectors import vec2

real = wp.float64


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``add_near_errors``."""
    module = unit("near_errors")
    curves = bezier.make_functions(make_lanes(1, real))
    zero = wp.constant(real(0.0))

    @wp.kernel(module=module)
    def add_near_errors(
        first: int,
        row_count: int,  # R
        height: int,
        width: int,
        spacing: real,  # largest distance of two points of a curve in px, by its control polygon
        points_max: int,
        control: wp.array2d(dtype=vec2),  # [R, 4] px
        error: wp.array2d(dtype=float),  # [h, w]
        # in and out
        seen: wp.array(dtype=int),  # [h w] -1 at the beginning, then the last curve that has passed
        # outputs
        sums: wp.array(dtype=real),  # [R]
    ):
        """Walk along all curves, one after another, so that each counts a pixel once."""
        for row in range(row_count):
            p0 = control[row, 0]
            p1 = control[row, 1]
            p2 = control[row, 2]
            p3 = control[row, 3]
            reach = wp.length(p1 - p0) + wp.length(p2 - p1) + wp.length(p3 - p2)
            count = wp.clamp(int(wp.ceil(reach / spacing)), 1, points_max)
            total = real(zero)
            for k in range(count + 1):
                w = curves.weights(real(k) / real(count))
                point = w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3
                x, y = int(wp.floor(point[0])), int(wp.floor(point[1]))
                for i in range(wp.max(x - 1, 0), wp.min(x + 2, width)):
                    for j in range(wp.max(y - 1, 0), wp.min(y + 2, height)):
                        if seen[j * width + i] != row:
                            seen[j * width + i] = row
                            total += real(error[j, i])
            sums[row] = total

    return bundle(add_near_errors)
