"""Capacity checks between stages 1 to 3, for steps whose counts the host does not read back.

The host gives a step a capacity for its vertices, strips, pairs and slots. If a count exceeds its capacity, the step
goes on with an empty scene, which every later kernel can draw, and the overflow is flagged. Entries up to the capacity
that no path uses have no effect: such strips have the path -1, and such pairs are empty and sort last.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import EMPTY
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

VERTICES, STRIPS, PAIRS, SLOTS = 0, 1, 2, 3
"""Indices into ``overflow``."""


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``admit_vertices``, ``admit_pairs`` and ``admit_slots``."""
    module = stage_module("capacity", lanes)

    @wp.func
    def is_within(total: int, capacity: int):
        """Return whether a total fits; a total of 2^31 or more has wrapped around to a negative number."""
        return total >= 0 and total <= capacity

    @wp.func
    def path_of(strip: int, path_first_strip: wp.array(dtype=int), path_count: int):
        """Return the path that owns a strip: the last path that begins at or before it (binary search)."""
        low = int(0)
        high = path_count
        while high - low > 1:
            middle = (low + high) // 2
            if path_first_strip[middle] <= strip:
                low = middle
            else:
                high = middle
        return low

    @wp.kernel(module=module)
    def admit_vertices(
        first: int,
        sums: wp.array(dtype=int),  # [N S + 1] where each segment's vertices begin, if they fit
        total: int,  # N S
        capacity: int,
        # outputs
        segment_first_vertex: wp.array(dtype=int),  # [N S + 1]
        overflow: wp.array(dtype=int),  # [4]
    ):
        """Admit the vertices if they fit; else give every segment none."""
        segment = first + wp.tid()
        fits = is_within(sums[total], capacity)
        segment_first_vertex[segment] = wp.where(fits, sums[segment], 0)
        if segment == 0:
            overflow[VERTICES] = wp.where(fits, 0, 1)

    @wp.kernel(module=module)
    def admit_pairs(
        first: int,
        strip_sums: wp.array(dtype=int),  # [N + 1]
        pair_sums: wp.array(dtype=int),  # [N + 1]
        path_count: int,
        strip_capacity: int,
        pair_capacity: int,
        class_count: int,  # at least one row of tiles: Gaussians of a path without pairs read that far
        tile_count: int,
        # in and out
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        # outputs
        path_first_strip: wp.array(dtype=int),  # [N + 1]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        strip_path: wp.array(dtype=int),  # [strip_capacity] -1: no path
        pair_class: wp.array(dtype=int),  # [class_count]
        pair_is_partial: wp.array(dtype=int),  # [pair_capacity + 1]
        pair_key: wp.array(dtype=int),  # [pair_capacity]
        pair_index: wp.array(dtype=int),  # [pair_capacity]
        overflow: wp.array(dtype=int),  # [4]
    ):
        """Admit the strips and pairs if both fit; all pairs are empty until they are classified."""
        item = first + wp.tid()
        strip_count, pair_count = strip_sums[path_count], pair_sums[path_count]
        strips_fit, pairs_fit = is_within(strip_count, strip_capacity), is_within(pair_count, pair_capacity)
        fits = strips_fit and pairs_fit
        if item <= path_count:
            path_first_strip[item] = wp.where(fits, strip_sums[item], 0)
            path_first_pair[item] = wp.where(fits, pair_sums[item], 0)
        if item < path_count and not fits:
            path_tile_box[item] = wp.vec4i(0, 0, 0, 0)
        if item < strip_capacity:
            path = int(-1)
            if fits and item < strip_count:
                path = path_of(item, strip_sums, path_count)
            strip_path[item] = path
        if item <= pair_capacity:
            pair_is_partial[item] = 0
        if item < class_count:
            pair_class[item] = EMPTY
        if item < pair_capacity:
            pair_key[item] = tile_count
            pair_index[item] = item
        if item == 0:
            overflow[STRIPS] = wp.where(strips_fit, 0, 1)
            overflow[PAIRS] = wp.where(pairs_fit, 0, 1)

    @wp.kernel(module=module)
    def admit_slots(
        first: int,
        sums: wp.array(dtype=int),  # [pair_capacity + 1] exclusive count of partial pairs
        pair_capacity: int,
        slot_capacity: int,
        tile_count: int,
        # in and out
        pair_class: wp.array(dtype=int),  # [pair_capacity]
        pair_key: wp.array(dtype=int),  # [pair_capacity]
        # outputs
        pair_slot: wp.array(dtype=int),  # [pair_capacity + 1]
        overflow: wp.array(dtype=int),  # [4]
    ):
        """Admit the slots if they fit; else make all pairs empty."""
        pair = first + wp.tid()
        fits = is_within(sums[pair_capacity], slot_capacity)
        pair_slot[pair] = wp.where(fits, sums[pair], 0)
        if pair < pair_capacity and not fits:
            pair_class[pair] = EMPTY
            pair_key[pair] = tile_count
        if pair == 0:
            overflow[SLOTS] = wp.where(fits, 0, 1)

    return bundle(admit_vertices, admit_pairs, admit_slots)
