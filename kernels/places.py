"""Draw places for new paths: pixels in proportion to the blurred error, from given random numbers.

``warpvec/fit/placement.py`` says how; its results are these, to the last bit. A pixel that is drawn twice must be drawn
anew, with more random numbers: then, and if no error is left, a flag asks for that.

Sums are in float64. Those of blocks of pixels and their running sum come first, and a draw looks for the block, and
then for the pixel in it.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``blur_rows``, ``sum_blocks``, ``end_blocks``, ``draw_pixels`` and ``order_places``."""
    dtype, v = lanes.dtype, lanes.functions
    zero = wp.constant(dtype(0.0))
    module = stage_module("places", lanes)

    @wp.kernel(module=module)
    def blur_rows(
        first: int,
        error: wp.array2d(dtype=dtype),  # [h, w]; negative and non-finite values count as 0
        weights: wp.array(dtype=dtype),  # [2 r + 1]
        # outputs
        blurred: wp.array2d(dtype=dtype),  # [w, h] its transpose, blurred along the rows of ``error``
    ):
        """Blur at one pixel; the first and the last pixel of a row continue beyond it."""
        width = error.shape[1]
        item = first + wp.tid()
        row = item // width
        column = item - row * width
        reach = weights.shape[0] // 2
        total = dtype(0.0)
        for k in range(weights.shape[0]):
            value = error[row, wp.clamp(column + k - reach, 0, width - 1)]
            if not (value > zero and wp.isfinite(value)):
                value = dtype(0.0)
            total = v.fma(value, weights[k], total)
        blurred[column, row] = total

    @wp.kernel(module=module)
    def sum_blocks(
        first: int,
        block: int,  # pixels of a block
        weights: wp.array(dtype=dtype),  # [P]
        # outputs
        block_ends: wp.array(dtype=wp.float64),  # [blocks] sums, here
    ):
        """Add up the weights of one block."""
        item = first + wp.tid()
        total = wp.float64(0.0)
        for pixel in range(item * block, wp.min((item + 1) * block, weights.shape[0])):
            total += wp.float64(weights[pixel])
        block_ends[item] = total

    @wp.kernel(module=module)
    def end_blocks(
        first: int,
        # in and out
        block_ends: wp.array(dtype=wp.float64),  # [blocks] sums, and then running sums
    ):
        """Add up the sums of all blocks in their order: one work item."""
        total = wp.float64(0.0)
        for block in range(block_ends.shape[0]):
            total += block_ends[block]
            block_ends[block] = total

    @wp.kernel(module=module)
    def draw_pixels(
        first: int,
        block: int,
        weights: wp.array(dtype=dtype),  # [P]
        block_ends: wp.array(dtype=wp.float64),  # [blocks]
        uniform: wp.array2d(dtype=wp.float64),  # [K, 5] random numbers in [0, 1)
        # outputs
        pixels: wp.array(dtype=int),  # [K]
        redraw: wp.array(dtype=int),  # [1] is 1 if there is no error
    ):
        """Draw one pixel: the first whose running sum is above a random share of the sum, as that of its block is."""
        item = first + wp.tid()
        last = block_ends.shape[0] - 1
        if item == 0:
            redraw[0] = wp.where(block_ends[last] > wp.float64(0.0), 0, 1)
        aim = uniform[item, 0] * block_ends[last]
        low, high = int(0), int(last)
        while low < high:
            middle = (low + high) // 2
            if block_ends[middle] > aim:
                high = int(middle)
            else:
                low = middle + 1
        begin, end = low * block, wp.min((low + 1) * block, weights.shape[0])
        total = wp.float64(0.0)
        for pixel in range(begin, end):
            total += wp.float64(weights[pixel])
        aim = uniform[item, 1] * total
        total = wp.float64(0.0)
        found = int(begin)
        while found < end - 1:
            total += wp.float64(weights[found])
            if total > aim:
                break
            found += 1
        pixels[item] = found

    @wp.kernel(module=module)
    def order_places(
        first: int,
        width: int,  # of the image
        pixels: wp.array(dtype=int),  # [K]
        uniform: wp.array2d(dtype=wp.float64),  # [K, 5]
        # outputs
        center: wp.array2d(dtype=dtype),  # [K, 2] px
        redraw: wp.array(dtype=int),  # [1] is 1 if a pixel has been drawn twice
    ):
        """Place one pixel: its rank among all is where column 2 has its order, and columns 3 and 4 its place inside."""
        item = first + wp.tid()
        pixel = pixels[item]
        rank = int(0)
        for other in range(pixels.shape[0]):
            if pixels[other] < pixel:
                rank += 1
            if other != item and pixels[other] == pixel:
                redraw[0] = 1
        order = int(uniform[rank, 2])
        row = pixel // width
        center[order, 0] = dtype(wp.float64(pixel - row * width) + uniform[order, 3])
        center[order, 1] = dtype(wp.float64(row) + uniform[order, 4])

    return bundle(blur_rows, sum_blocks, end_blocks, draw_pixels, order_places)
