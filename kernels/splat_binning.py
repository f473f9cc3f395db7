"""Stage 2 of the splat renderer: Gaussians -> (path, tile) pairs and their class. No gradient.

Pairs are numbered and sorted as in the exact renderer (see ``binning``): by tile, then in z order. A pair is partial if
the box of one of its path's groups of Gaussians reaches a pixel centre of the tile; otherwise it is empty.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import COORDINATE_MAX, EMPTY, PARTIAL, SPLAT_GROUP, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once
from warpvec.kernels.splatting import PLANES


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return ``covered``, which finds the pixels that a range of coordinates reaches."""
    dtype = lanes.dtype
    half = wp.constant(dtype(0.5))

    @wp.func
    def covered(low: dtype, high: dtype, pixel_count: int):
        """Return the first pixel, and one past the last, with its centre in [low, high], of ``pixel_count``."""
        start = int(wp.clamp(wp.ceil(low - half), dtype(0.0), dtype(pixel_count)))
        stop = int(wp.clamp(wp.floor(high - half) + dtype(1.0), dtype(0.0), dtype(pixel_count)))
        return start, stop

    return bundle(covered)


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``bound_groups``, ``bound_splats`` and ``classify_splats``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    covered = make_functions(lanes).covered
    far = wp.constant(dtype(COORDINATE_MAX))
    planes, group_size = wp.constant(PLANES), wp.constant(SPLAT_GROUP)
    module = stage_module("splat_binning", lanes)

    @wp.func
    def joined(a: wp.vec4i, b: wp.vec4i):
        """Return the smallest box around two boxes, each left, top, right, bottom."""
        return wp.vec4i(wp.min(a[0], b[0]), wp.min(a[1], b[1]), wp.max(a[2], b[2]), wp.max(a[3], b[3]))

    @wp.kernel(module=module)
    def bound_groups(
        first: int,
        splats: wp.array(dtype=dtype),  # [N, rows, PLANES, samples]
        sample_count: int,
        sample_stride: int,  # samples, padded
        group_count: int,
        height: int,
        width: int,
        # outputs
        group_box: wp.array(
            dtype=wp.vec4i
        ),  # [N rows, groups + 1] px left, top, right, bottom, the last two exclusive; last: the whole row
    ):
        """Find the box of pixels that each group of a row reaches."""
        row = first + wp.tid()
        row_box = wp.vec4i(width, height, 0, 0)
        for group in range(group_count):
            low = vec2(far, far)
            high = vec2(-far, -far)
            start = row * planes * sample_stride + group * group_size
            for index in range(start, start + wp.min(group_size, sample_count - group * group_size)):
                reach_x = splats[index + 5 * sample_stride]
                if reach_x >= dtype(0.0):
                    center = vec2(splats[index], splats[index + sample_stride])
                    reach = vec2(reach_x, splats[index + 6 * sample_stride])
                    low = wp.min(low, center - reach)
                    high = wp.max(high, center + reach)
            left, right = covered(low[0], high[0], width)
            top, bottom = covered(low[1], high[1], height)
            box = wp.vec4i(width, height, 0, 0)
            if left < right and top < bottom:
                box = wp.vec4i(left, top, right, bottom)
            group_box[row * (group_count + 1) + group] = box
            row_box = joined(row_box, box)
        group_box[row * (group_count + 1) + group_count] = row_box

    @wp.kernel(module=module)
    def bound_splats(
        first: int,
        group_box: wp.array(dtype=wp.vec4i),  # [N rows, groups + 1] px
        row_count: int,
        group_count: int,
        # outputs
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N] left, top, right, bottom in tiles, the last two exclusive
        path_strip_count: wp.array(dtype=int),  # [N + 1]
        path_pair_count: wp.array(dtype=int),  # [N + 1]
    ):
        """Find the box of tiles of each path; it is empty if the path reaches no pixel centre."""
        path = first + wp.tid()
        box = group_box[path * row_count * (group_count + 1) + group_count]
        for row in range(path * row_count, (path + 1) * row_count):
            box = joined(box, group_box[row * (group_count + 1) + group_count])
        left, top = box[0] // TILE, box[1] // TILE
        right, bottom = wp.max((box[2] + TILE - 1) // TILE, left), wp.max((box[3] + TILE - 1) // TILE, top)
        path_tile_box[path] = wp.vec4i(left, top, right, bottom)
        path_strip_count[path] = bottom - top
        path_pair_count[path] = (bottom - top) * (right - left)

    @wp.kernel(module=module)
    def classify_splats(
        first: int,
        group_box: wp.array(dtype=wp.vec4i),  # [N rows, groups + 1] px
        row_count: int,
        group_count: int,
        tile_columns: int,
        tile_count: int,
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_strip: wp.array(dtype=int),  # [N + 1]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        strip_path: wp.array(dtype=int),  # [strips] -1: no path
        # outputs
        pair_path: wp.array(dtype=int),  # [K]
        pair_class: wp.array(dtype=int),  # [K]
        pair_is_partial: wp.array(dtype=int),  # [K + 1]
        pair_key: wp.array(dtype=int),  # [K] tile, or tile_count for an empty pair
        pair_index: wp.array(dtype=int),  # [K] the pair itself, to be sorted by key
    ):
        """Find the class and the sort key of each pair of a strip."""
        strip = first + wp.tid()
        path = strip_path[strip]
        if path < 0:
            return
        box = path_tile_box[path]
        tile_row = box[1] + strip - path_first_strip[path]
        columns = box[2] - box[0]
        pair0 = path_first_pair[path] + (strip - path_first_strip[path]) * columns
        for pair in range(pair0, pair0 + columns):
            pair_is_partial[pair] = 0
        top, bottom = tile_row * TILE, (tile_row + 1) * TILE
        for row in range(path * row_count, (path + 1) * row_count):
            row_box = group_box[row * (group_count + 1) + group_count]
            if row_box[1] < bottom and row_box[3] > top:
                for group in range(row * (group_count + 1), row * (group_count + 1) + group_count):
                    reached = group_box[group]
                    if reached[1] < bottom and reached[3] > top:
                        for tile in range(reached[0] // TILE, (reached[2] - 1) // TILE + 1):
                            pair_is_partial[pair0 + tile - box[0]] = 1
        for column in range(columns):
            pair = pair0 + column
            is_partial = pair_is_partial[pair] == 1
            pair_path[pair] = path
            pair_class[pair] = wp.where(is_partial, PARTIAL, EMPTY)
            pair_key[pair] = wp.where(is_partial, tile_row * tile_columns + box[0] + column, tile_count)
            pair_index[pair] = pair

    return bundle(bound_groups, bound_splats, classify_splats)
