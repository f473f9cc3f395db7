"""Lanes that read and write places of their own: below zero, at the same place, and in ranges without an entry."""

from typing import Any

import numpy as np
import warp as wp
from sweep import sweep

from warpvec.kernels.lanes import make_lanes
from warpvec.rendering.launch import start_warp

COUNT, PLACES = 48, 8


def make_kernel(width: int, dtype: Any) -> Any:
    """Return a kernel whose lanes each read a point, and write at the place that its row gives, out of ``PLACES``."""
    lanes = make_lanes(width, dtype)
    v = lanes.functions
    module = wp.get_module(f"warpvec.tests.index_lanes.{lanes.name}")
    module.options.update(enable_backward=False)

    @wp.kernel(module=module)
    def probe(
        points: wp.array(dtype=lanes.vec2),
        # outputs
        sums: wp.array(dtype=lanes.vector), steps: wp.array(dtype=int), places: wp.array(dtype=int),
        ranges: wp.array(dtype=int), is_below: wp.array(dtype=int),
    ):  # fmt: skip
        group = wp.tid()
        lane = v.lane_numbers(group * wp.static(width))
        x, y = v.gather_x(points, lane), v.gather_y(points, lane)
        column, row = v.floor_whole(x), v.whole_shift(v.floor_whole(y), v.spread_whole(2))
        place = v.whole_and(row, v.spread_whole(wp.static(PLACES - 1)))
        v.scatter_add(sums, place, x, place, y)
        v.scatter_steps(steps, place, column)
        v.mark_places(places, v.whole_and(column, v.spread_whole(5)), place, place)
        v.mark_ranges(ranges, v.whole_and(column, v.spread_whole(7)), v.whole_add(place, v.spread_whole(-2)))
        if v.any_less(x, y):
            is_below[group] = 1

    return probe


@sweep("dtype", [wp.float32, wp.float64])
@sweep("width", [16, 1])
def test_each_lane_reads_and_writes_its_own_places(width: int, dtype: Any) -> None:
    start_warp()
    x = np.random.default_rng(0).integers(-80, 80, (2, COUNT)) / 8  # exact sums in any order
    x[1, :32] = np.minimum(x[0], x[1])[:32]
    x[1, 31] = x[0, 31] + 1  # below in the last lane of its group alone; the first group has none
    real, groups = wp.dtype_to_numpy(dtype), COUNT // width
    lane = dtype if width == 1 else wp.types.vector(width, dtype=dtype)
    points = wp.array(np.ascontiguousarray(x.T, dtype=real), dtype=wp.types.vector(2, dtype=dtype))
    shape = (16,) if width == 1 else (1, 16)
    sums = wp.array(np.zeros(shape, real), dtype=lane)
    steps, places, ranges, is_below = (wp.zeros(size, dtype=int) for size in (PLACES, PLACES, PLACES, groups))
    outputs = [sums, steps, places, ranges, is_below]
    wp.launch(make_kernel(width, dtype), dim=groups, inputs=[points], outputs=outputs, device="cpu")

    column = np.floor(x[0]).astype(int)
    place = np.floor(x[1] / 4).astype(int) % PLACES
    want_sums, want_steps, want_places, want_ranges = np.zeros(16), *np.zeros((3, PLACES), int)
    np.add.at(want_sums, place, x.sum(0))
    np.add.at(want_steps, place, column)
    np.bitwise_or.at(want_places, place, column & 5)
    for first, last in zip(column % 8, place - 2, strict=True):
        want_ranges[first : max(last + 1, 0)] = 1
    wants = [want_sums, want_steps, want_places, want_ranges, (x[0] < x[1]).reshape(groups, width).any(1)]
    for got, want in zip(outputs, wants, strict=True):
        np.testing.assert_array_equal(got.numpy().ravel(), want)
