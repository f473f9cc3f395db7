"""Sums over neighbouring scalar lanes: in the registers of a CUDA warp, or one lane after another on the CPU."""

from typing import Any

import warp as wp

from warpvec.kernels.constants import REDUCED_LANES

# Module constants, because a literal passed to a decorator inside a function breaks Warp's dedenting of the source.
_WARP_SUM = """
#if defined(__CUDA_ARCH__)
for (int offset = 16; offset; offset >>= 1) value += __shfl_xor_sync(0xffffffffu, value, offset);
#endif
return value;
"""
_IS_CUDA = """
#if defined(__CUDA_ARCH__)
return 1;
#else
return 0;
#endif
"""


def group_reduction(dtype: Any) -> Any:
    """Return a function that adds the values of REDUCED_LANES neighbouring lanes to one entry of an array of sums."""

    @wp.func_native(_WARP_SUM)
    def warp_sum(value: dtype) -> dtype: ...

    @wp.func_native(_IS_CUDA)
    def is_cuda() -> int: ...

    @wp.func
    def reduce_group(sums: wp.array2d(dtype=dtype), row: int, term: int, value: dtype, lane: int):
        is_first = lane % wp.static(REDUCED_LANES) == 0
        if is_cuda() == 1:
            group_sum = warp_sum(value)
            if is_first:
                sums[row, term] = group_sum
        else:
            # On the CPU lanes run one after another: the first lane of a group starts the sum.
            if is_first:
                sums[row, term] = value
            else:
                sums[row, term] = sums[row, term] + value

    return reduce_group
