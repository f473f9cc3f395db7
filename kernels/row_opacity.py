"""Stage 0 of the splat renderer: opacities of paths -> opacities of their rows of Gaussians.

A path has one opacity, which all of its rows share, or three: at side A, in the middle and at side B. Then the logit of
a row is a blend of theirs, as in Bezier Splatting's code.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import LOGIT_MARGIN
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return ``logit``, which forward and adjoint share."""
    dtype = lanes.dtype
    one, margin = wp.constant(dtype(1.0)), wp.constant(dtype(LOGIT_MARGIN))

    @wp.func
    def logit(opacity: dtype):
        bounded = wp.clamp(opacity, margin, one - margin)
        return wp.log(bounded / (one - bounded))

    return bundle(logit)


@made_once
def make_kernels(lanes: Lanes, with_sides: bool) -> SimpleNamespace:
    """Return ``spread_opacity``; ``with_sides`` paths have three opacities."""
    dtype = lanes.dtype
    logit = make_functions(lanes).logit
    one = wp.constant(dtype(1.0))
    module = stage_module("row_opacity" + "_sides" * with_sides, lanes)

    @wp.kernel(module=module)
    def spread_opacity(
        first: int,
        opacity: wp.array(dtype=dtype),  # [N] in the middle
        side_opacity: wp.array2d(dtype=dtype),  # [N, 2] at side A and side B, ``with_sides`` only
        row_share: wp.array2d(dtype=dtype),  # [rows, 3] of the middle, side A and side B, ``with_sides`` only
        row_count: int,
        # outputs
        row_opacity: wp.array(dtype=dtype),  # [N rows]
    ):
        """Compute the opacity of one row of one path."""
        item = first + wp.tid()
        path = item // row_count
        if wp.static(with_sides):
            row = item % row_count
            value = row_share[row, 0] * logit(opacity[path])
            value += row_share[row, 1] * logit(side_opacity[path, 0])
            value += row_share[row, 2] * logit(side_opacity[path, 1])
            row_opacity[item] = one / (one + wp.exp(-value))
        else:
            row_opacity[item] = opacity[path]

    return bundle(spread_opacity)
