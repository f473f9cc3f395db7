"""Put the three opacities of paths side by side, and apart: in the middle [N] and at the sides [N, 2] <-> all [N, 3].

The renderer has them apart, the regularizers and the optimizer side by side.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``join_opacities`` and ``part_opacities``."""
    dtype = lanes.dtype
    module = stage_module("opacity_columns", lanes)

    @wp.kernel(module=module)
    def join_opacities(
        first: int,
        opacity: wp.array(dtype=dtype),  # [N] in the middle
        side_opacity: wp.array2d(dtype=dtype),  # [N, 2] at side A and side B
        # outputs
        joined: wp.array2d(dtype=dtype),  # [N, 3]
    ):
        """Put the opacities of one path, or their adjoints, side by side."""
        path = first + wp.tid()
        joined[path, 0] = opacity[path]
        joined[path, 1] = side_opacity[path, 0]
        joined[path, 2] = side_opacity[path, 1]

    @wp.kernel(module=module)
    def part_opacities(
        first: int,
        joined: wp.array2d(dtype=dtype),  # [N, 3]
        # outputs
        opacity: wp.array(dtype=dtype),  # [N]
        side_opacity: wp.array2d(dtype=dtype),  # [N, 2]
    ):
        """Write the opacities of one path to where the renderer has them."""
        path = first + wp.tid()
        opacity[path] = joined[path, 0]
        side_opacity[path, 0] = joined[path, 1]
        side_opacity[path, 1] = joined[path, 2]

    return bundle(join_opacities, part_opacities)
