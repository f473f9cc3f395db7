"""Adjoint of stage 0 of the splat renderer, for paths of three opacities: sums over Gaussians -> adjoints of opacities.

The sum w of a row's Gaussians is dL/d(row opacity) times that opacity o, and so dL/d(its logit) is w (1 - o).
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import LOGIT_MARGIN
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``sum_rows`` and ``gather_opacities_adjoint``."""
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    zero, one, margin = (wp.constant(dtype(value)) for value in (0.0, 1.0, LOGIT_MARGIN))
    module = stage_module("row_opacity_adjoint", lanes)

    @wp.func
    def of_opacity(adj_logit: dtype, opacity: dtype):
        """Return dL/d(opacity); 0 where the logit is bounded."""
        is_free = opacity > margin and opacity < one - margin and wp.isfinite(adj_logit)
        return wp.where(is_free, adj_logit / (opacity * (one - opacity)), zero)

    @wp.kernel(module=module)
    def sum_rows(
        first: int,
        row_opacity: wp.array(dtype=dtype),  # [N rows]
        term_count: int,
        block_count: int,
        splat_sums: wp.array(dtype=vector),  # [N, rows, terms, samples], of which the first is w
        # outputs
        adj_logit: wp.array(dtype=dtype),  # [N rows]
    ):
        """Add up dL/d(logit) of one row of one path."""
        row = first + wp.tid()
        total = v.spread(zero)
        for block in range(block_count):
            total = v.add(total, splat_sums[row * term_count * block_count + block])
        adj_logit[row] = v.total(total) * (one - row_opacity[row])

    @wp.kernel(module=module)
    def gather_opacities_adjoint(
        first: int,
        opacity: wp.array(dtype=dtype),  # [N] in the middle
        side_opacity: wp.array2d(dtype=dtype),  # [N, 2] at side A and side B
        row_share: wp.array2d(dtype=dtype),  # [rows, 3] of the middle, side A and side B
        row_count: int,
        adj_logit: wp.array(dtype=dtype),  # [N rows]
        # outputs
        adj_opacity: wp.array(dtype=dtype),  # [N]
        adj_side_opacity: wp.array2d(dtype=dtype),  # [N, 2]
    ):
        """Compute the adjoints of the three opacities of one path."""
        path = first + wp.tid()
        middle, side_a, side_b = dtype(zero), dtype(zero), dtype(zero)
        for row in range(row_count):
            value = adj_logit[path * row_count + row]
            middle += row_share[row, 0] * value
            side_a += row_share[row, 1] * value
            side_b += row_share[row, 2] * value
        adj_opacity[path] = of_opacity(middle, opacity[path])
        adj_side_opacity[path, 0] = of_opacity(side_a, side_opacity[path, 0])
        adj_side_opacity[path, 1] = of_opacity(side_b, side_opacity[path, 1])

    return bundle(sum_rows, gather_opacities_adjoint)
