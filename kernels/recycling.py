"""Take paths out of a fit's memory and put others in, without a look of the host: which paths go, and where rows lie.

The memory has room for more paths than there are (``warpvec/fit/arena.py``). `choose_paths` marks the paths of the
lowest removal costs. Exclusive sums of the marks and of the segments of the paths that stay say where each lies after
that. `place_paths` writes these places, and the tables of the paths' segments. New paths come last.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``choose_paths``, ``place_paths`` and ``place_room``."""
    dtype = lanes.dtype
    module = stage_module("recycling", lanes)

    @wp.func
    def ranked(cost: dtype):
        """Return a cost that can be compared: the highest if it is no number, so that as many as wanted go."""
        return wp.where(wp.isnan(cost), dtype(wp.inf), cost)

    @wp.kernel(module=module)
    def choose_paths(
        first: int,
        drop_count: int,  # paths that go
        path_count: int,  # room for paths
        counts: wp.array(dtype=int),  # [1] paths that there are
        cost: wp.array(dtype=dtype),  # [N] removal costs; not read if none goes
        path_first_segment: wp.array(dtype=int),  # [path_count + 2] the last path has the room
        # outputs
        kept_paths: wp.array(dtype=int),  # [path_count + 1] 1 for a path that stays; the last is 0
        kept_segments: wp.array(dtype=int),  # [path_count + 1] its segments
        path_start: wp.array(dtype=int),  # [path_count + 1] a copy of ``path_first_segment``
    ):
        """Mark one path: it goes if fewer than ``drop_count`` have a lower cost, or an equal one and a lower index."""
        path = first + wp.tid()
        start = path_first_segment[path]
        path_start[path] = start
        kept_paths[path] = 0
        kept_segments[path] = 0
        if path >= counts[0]:
            return
        lower = int(0)
        if drop_count > 0:
            own = ranked(cost[path])
            for other in range(counts[0]):
                theirs = ranked(cost[other])
                if theirs < own or (theirs == own and other < path):
                    lower += 1
        if lower >= drop_count:
            kept_paths[path] = 1
            kept_segments[path] = path_first_segment[path + 1] - start

    @wp.kernel(module=module)
    def place_paths(
        first: int,
        new_count: int,  # paths that come
        new_segments: int,  # segments of each of them
        path_count: int,  # room for paths; rows of new paths follow those of the room
        segment_count: int,  # room for segments, likewise
        kept_paths: wp.array(dtype=int),  # [path_count + 1]
        path_sums: wp.array(dtype=int),  # [path_count + 1] their exclusive sums
        kept_segments: wp.array(dtype=int),  # [path_count + 1]
        segment_sums: wp.array(dtype=int),  # [path_count + 1]
        path_start: wp.array(dtype=int),  # [path_count + 1]
        # outputs
        counts: wp.array(dtype=int),  # [1] paths that there are then
        path_source: wp.array(dtype=wp.int64),  # [path_count] which path was here, or comes
        segment_source: wp.array(dtype=wp.int64),  # [segment_count] the same of segments
        path_first_segment: wp.array(dtype=int),  # [path_count + 1]
        segment_path: wp.array(dtype=int),  # [segment_count]
        segment_next: wp.array(dtype=int),  # [segment_count]
        segment_previous: wp.array(dtype=int),  # [segment_count]
    ):
        """Place one path: an old one that stays, or a new one."""
        item = first + wp.tid()
        kept, segments = path_sums[path_count], segment_sums[path_count]
        if item == 0:
            counts[0] = kept + new_count
        if item < path_count and kept_paths[item] == 0:
            return
        fresh = item - path_count
        path = kept + fresh
        start = segments + fresh * new_segments
        count = int(new_segments)
        source = segment_count + fresh * new_segments
        if item < path_count:
            path = path_sums[item]
            start = segment_sums[item]
            count = kept_segments[item]
            source = path_start[item]
        path_source[path] = wp.int64(item)
        path_first_segment[path] = start
        for k in range(count):
            row = start + k
            segment_source[row] = wp.int64(source + k)
            segment_path[row] = path
            segment_next[row] = wp.where(k + 1 < count, row + 1, start)
            segment_previous[row] = wp.where(k > 0, row - 1, start + count - 1)

    @wp.kernel(module=module)
    def place_room(
        first: int,
        new_segments: int,  # segments of all paths that come
        path_count: int,
        segment_count: int,
        counts: wp.array(dtype=int),  # [1] paths that there are now
        segment_sums: wp.array(dtype=int),  # [path_count + 1]
        # outputs
        path_source: wp.array(dtype=wp.int64),  # [path_count]
        segment_source: wp.array(dtype=wp.int64),  # [segment_count] one after the last for a segment off the canvas
        path_first_segment: wp.array(dtype=int),  # [path_count + 1] without segments, but for the last path
        segment_path: wp.array(dtype=int),  # [segment_count]
        segment_next: wp.array(dtype=int),  # [segment_count]
        segment_previous: wp.array(dtype=int),  # [segment_count]
    ):
        """Place one entry of the room behind the paths: its segments are those of one more path."""
        item = first + wp.tid()
        rows = segment_sums[path_count] + new_segments
        if item >= counts[0] and item <= path_count:
            path_first_segment[item] = rows
            if item < path_count:
                path_source[item] = wp.int64(item)
        if item >= rows and item < segment_count:
            segment_source[item] = wp.int64(segment_count + new_segments)
            segment_path[item] = path_count
            segment_next[item] = wp.where(item + 1 < segment_count, item + 1, rows)
            segment_previous[item] = wp.where(item > rows, item - 1, segment_count - 1)

    return bundle(choose_paths, place_paths, place_room)
