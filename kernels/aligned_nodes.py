"""The nodes of a drawing with smooth ones smooth again, and the control points of its curves.

The same as `warpvec.geometry.joints.Joints.segments`, in one launch: that takes some forty small steps.
"""

from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.kernels.constants import DIRECTION_MIN
from warpvec.kernels.lanes import bundle, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.real_lanes import C_NAME


@made_once
def make_kernels(dtype: Any) -> SimpleNamespace:
    """Return ``align_nodes`` for values of ``dtype``."""
    vec2 = wp.types.vector(2, dtype=dtype)
    third, two_thirds = wp.constant(dtype(1.0 / 3.0)), wp.constant(dtype(2.0 / 3.0))
    module = unit(f"aligned_nodes.{C_NAME[dtype]}")

    @wp.func
    def direction_at(
        node: int,
        row_next: wp.array(dtype=int),
        row_previous: wp.array(dtype=int),
        is_line: wp.array(dtype=wp.bool),
        anchor: wp.array(dtype=vec2),
        leaving: wp.array(dtype=vec2),
        arriving: wp.array(dtype=vec2),
    ):
        """Return the mean direction of the outline at a node, or that of the line beside it."""
        before = row_previous[node]
        ahead, behind = vec2(leaving[node]), -vec2(arriving[node])
        if is_line[node]:
            ahead = anchor[row_next[node]] - anchor[node]
        if is_line[before]:
            behind = anchor[node] - anchor[before]
        mean = ahead + behind
        if is_line[node]:
            mean = vec2(ahead)
        if is_line[before]:
            mean = vec2(behind)
        return mean / wp.max(wp.length(mean), wp.static(dtype(DIRECTION_MIN)))

    @wp.kernel(module=module)
    def align_nodes(
        first: int,
        row_next: wp.array(dtype=int),  # [R]
        row_previous: wp.array(dtype=int),  # [R]
        is_line: wp.array(dtype=wp.bool),  # [R]
        is_smooth: wp.array(dtype=wp.bool),  # [R]
        least: wp.array(dtype=vec2),  # [R] least lengths of the leaving and the arriving handle
        anchor: wp.array(dtype=vec2),  # [R] px
        leaving: wp.array(dtype=vec2),  # [R] px, from the anchor
        arriving: wp.array(dtype=vec2),  # [R] px, from the anchor
        # outputs
        aligned_leaving: wp.array(dtype=vec2),  # [R]
        aligned_arriving: wp.array(dtype=vec2),  # [R]
        points: wp.array2d(dtype=vec2),  # [R, 3] px
    ):
        row = first + wp.tid()
        after = row_next[row]
        here, end = anchor[row], anchor[after]
        own, across, other = vec2(leaving[row]), vec2(arriving[row]), vec2(arriving[after])
        if is_smooth[row]:
            unit = direction_at(row, row_next, row_previous, is_line, anchor, leaving, arriving)
            own = wp.max(wp.dot(own, unit), least[row][0]) * unit
            across = wp.min(wp.dot(across, unit), -least[row][1]) * unit
        if is_smooth[after]:
            unit = direction_at(after, row_next, row_previous, is_line, anchor, leaving, arriving)
            other = wp.min(wp.dot(other, unit), -least[after][1]) * unit
        aligned_leaving[row] = own
        aligned_arriving[row] = across
        points[row, 0] = here
        if is_line[row]:
            points[row, 1] = here + (end - here) * third
            points[row, 2] = here + (end - here) * two_thirds
        else:
            points[row, 1] = here + own
            points[row, 2] = end + other

    return bundle(align_nodes)
