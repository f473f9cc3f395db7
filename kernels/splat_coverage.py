"""Stage 3 of the splat renderer: Gaussians -> coverage of the pixels of each pair, and the lowest visible hit.

All Gaussians of a path share its colour and opacity. In any order, they cover a pixel by 1 - prod(1 - alpha), which is
the alpha of equation (3). A tile works front to back and stops at the path behind which every pixel's transmittance is
below TRANSMITTANCE_MIN.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import compositing, splat_binning
from warpvec.kernels.constants import SPLAT_ALPHA_MAX, SPLAT_ALPHA_MIN, SPLAT_GROUP, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once
from warpvec.kernels.splatting import PLANES


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return ``gaussian``, which forward and adjoint share."""
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    half = wp.constant(dtype(0.5))

    @wp.func
    def gaussian(opacity: dtype, dx: dtype, dy: vector, pxx: dtype, pxy: dtype, pyy: dtype):
        """Return opacity exp(-q / 2) at the offsets dx, dy from the center, before the bounds on alpha."""
        linear = v.fma(dy, v.spread(-half * pyy), v.spread(-pxy * dx))
        return v.mul(v.spread(opacity), v.exponential(v.fma(dy, linear, v.spread(-half * pxx * dx * dx))))

    return bundle(gaussian)


@made_once
def make_kernels(lanes: Lanes, with_shares: bool = False) -> SimpleNamespace:
    """Return ``cover_splats``; ``with_shares`` it also writes for which share of a pixel the path's colour answers.

    That share weighs what each Gaussian adds to the coverage. What it adds depends on the order: the sides come first,
    then the lines from one side to the other, as in Bezier Splatting's code.
    """
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    gaussian = make_functions(lanes).gaussian
    covered = splat_binning.make_functions(lanes).covered
    pixels = compositing.make_functions(lanes)
    zero, half, one = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0))
    alpha_min, alpha_max = wp.constant(dtype(SPLAT_ALPHA_MIN)), wp.constant(dtype(SPLAT_ALPHA_MAX))
    planes, group_size = wp.constant(PLANES), wp.constant(SPLAT_GROUP)
    tile_vectors, tile_threads = wp.constant(lanes.tile_vectors), wp.constant(lanes.tile_threads)
    local_array = lanes.tile_vectors > 1
    module = stage_module("splat_coverage" + "_shares" * with_shares, lanes)

    @wp.kernel(module=module)
    def cover_splats(
        first: int,
        tile_first_hit: wp.array(dtype=int),  # [tiles + 1]
        hit_pair: wp.array(dtype=int),  # [K]
        pair_path: wp.array(dtype=int),  # [K]
        pair_slot: wp.array(dtype=int),  # [K + 1]
        splats: wp.array(dtype=dtype),  # [N, rows, PLANES, samples]
        group_box: wp.array(dtype=wp.vec4i),  # [N rows, groups + 1] px
        row_opacity: wp.array(dtype=dtype),  # [N rows]
        row_count: int,
        sample_count: int,
        sample_stride: int,
        group_count: int,
        tile_columns: int,
        height: int,
        width_px: int,
        transmittance_min: dtype,
        color_weight: wp.array2d(dtype=dtype),  # [rows, samples], ``with_shares`` only
        # outputs
        slot_coverage: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
        slot_transmittance: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width] of the path alone
        slot_share: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width], ``with_shares`` only
        pair_is_visible: wp.array(dtype=int),  # [K]
        tile_first_visible: wp.array(dtype=int),  # [tiles]
    ):
        """Find the coverage of the pairs of one tile (CPU) or one pixel of it (scalar lanes), front to back."""
        item = first + wp.tid()
        tile = item // tile_threads
        lane = item % tile_threads
        left, top = (tile % tile_columns) * TILE, (tile // tile_columns) * TILE
        # The columns that this thread owns, and the row of its first lane.
        own_left = left + lane // TILE
        own_right = own_left + tile_vectors
        row0 = dtype(top + lane % TILE) + half
        start = tile_first_hit[tile]
        hit = tile_first_hit[tile + 1]
        if wp.static(local_array):
            light = wp.zeros(shape=(tile_vectors,), dtype=vector)
            passed = wp.zeros(shape=(tile_vectors,), dtype=vector)
            if wp.static(with_shares):
                share = wp.zeros(shape=(tile_vectors,), dtype=vector)
        else:
            light = v.spread(one)
            passed = v.spread(one)
            if wp.static(with_shares):
                share = v.spread(zero)
        for i in range(tile_vectors):
            v.put(light, i, pixels.on_canvas(tile, lane * tile_vectors + i, tile_columns, height, width_px))
        is_lit = int(1)
        while hit > start and is_lit == 1:
            hit -= 1
            pair = hit_pair[hit]
            path = pair_path[pair]
            for i in range(tile_vectors):
                v.put(passed, i, v.spread(one))
                if wp.static(with_shares):
                    v.put(share, i, v.spread(zero))
            for turn in range(row_count):
                own_row = turn
                if wp.static(with_shares):
                    own_row = wp.where(turn < 2, turn * (row_count - 1), turn - 1)
                row = path * row_count + own_row
                o = row_opacity[row]
                row_box = group_box[row * (group_count + 1) + group_count]
                if row_box[0] < left + TILE and row_box[2] > left and row_box[1] < top + TILE and row_box[3] > top:
                    for group in range(group_count):
                        box = group_box[row * (group_count + 1) + group]
                        if box[0] < left + TILE and box[2] > left and box[1] < top + TILE and box[3] > top:
                            splat0 = row * planes * sample_stride + group * group_size
                            count = wp.min(group_size, sample_count - group * group_size)
                            for splat in range(splat0, splat0 + count):
                                x, reach_x = splats[splat], splats[splat + 5 * sample_stride]
                                y, reach_y = splats[splat + sample_stride], splats[splat + 6 * sample_stride]
                                near, far = covered(x - reach_x, x + reach_x, width_px)
                                near, far = wp.max(near, own_left), wp.min(far, own_right)
                                if near < far and y - reach_y < dtype(top + TILE) and y + reach_y > dtype(top):
                                    pxx = splats[splat + 2 * sample_stride]
                                    pxy = splats[splat + 3 * sample_stride]
                                    pyy = splats[splat + 4 * sample_stride]
                                    dy = v.ramp_from(row0 - y)
                                    for column in range(near, far):
                                        alpha = gaussian(o, dtype(column) + half - x, dy, pxx, pxy, pyy)
                                        alpha = v.minimum(alpha, v.spread(alpha_max))
                                        alpha = v.where_less(alpha, v.spread(alpha_min), v.spread(zero), alpha)
                                        p = v.get(passed, column - own_left)
                                        if wp.static(with_shares):
                                            part = color_weight[own_row, group * group_size + splat - splat0]
                                            s = v.get(share, column - own_left)
                                            added = v.fma(v.spread(part), v.mul(p, alpha), s)
                                            v.put(share, column - own_left, added)
                                        v.put(passed, column - own_left, v.fnma(p, alpha, p))
            brightest = v.spread(zero)
            slot0 = pixels.winding_index(pair_slot[pair], lane * tile_vectors)
            for i in range(tile_vectors):
                p = v.get(passed, i)
                slot_transmittance[slot0 + i] = p
                slot_coverage[slot0 + i] = v.sub(v.spread(one), p)
                if wp.static(with_shares):
                    slot_share[slot0 + i] = v.get(share, i)
                rest = v.mul(v.get(light, i), p)
                v.put(light, i, rest)
                brightest = v.maximum(brightest, rest)
            is_lit = v.any_of_tile(wp.where(v.lane_max(brightest) >= transmittance_min, 1, 0))
            pair_is_visible[pair] = 1
        tile_first_visible[tile] = hit
        for hidden in range(start, hit):
            pair_is_visible[hit_pair[hidden]] = 0

    return bundle(cover_splats)
