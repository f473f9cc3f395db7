"""Turn the opacity curvature of paths into their removal costs: how much the squared error rises without each of them.

``kernels/compositing_adjoint.py`` explains the curvature. Without a path of opacity o, the error changes by o times its
derivative less, and o^2 times the curvature more.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

# Each operation rounds, as in torch, so that the CPU's files keep their bytes.
_COST = """
    #pragma clang fp contract(off)
    const {c_type} square = o * o * curvature * error_scale;
    const {c_type} slope = o * adj_opacity;
    return square - slope;
"""


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``cost_removals``."""
    dtype = lanes.dtype
    c_type = "float" if dtype is wp.float32 else "double"
    module = stage_module("removal_costs", lanes)

    @wp.func_native(_COST.format(c_type=c_type))
    def removal_cost(o: dtype, adj_opacity: dtype, curvature: dtype, error_scale: dtype) -> dtype: ...

    @wp.kernel(module=module)
    def cost_removals(
        first: int,
        opacity: wp.array(dtype=dtype),  # [N]
        adj_opacity: wp.array(dtype=dtype),  # [N]
        error_scale: dtype,  # dL/d(squared error)
        # in and out
        cost: wp.array(dtype=dtype),  # [N] the curvature, and then the removal cost
    ):
        """Compute the removal cost of one path."""
        path = first + wp.tid()
        cost[path] = removal_cost(opacity[path], adj_opacity[path], cost[path], error_scale)

    return bundle(cost_removals)
