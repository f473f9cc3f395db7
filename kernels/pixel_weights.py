"""The weights of crossed pixels in the Gauss-Newton matrix, from the derivatives of ``pixel_slopes.py``.

Crossed pixels get two things: how their planes change with the winding of each path, and the share that each path
shows. Of other pixels only the sums of squared shares count, because only colours act there.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import bundle, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.pixel_slopes import SLOPE_PLANES

SHARE_MIN = 1e-3
"""A path that shows less of itself in a pixel counts as hidden there."""

vec4 = wp.vec4d
real = wp.float64


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``weigh_pixels`` and ``measure_tiles``."""
    module = unit("normal_matrix")
    tile_pixels = wp.constant(TILE * TILE)
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    @wp.kernel(module=module)
    def weigh_pixels(
        first: int,
        begin: int,  # first pixel of these tiles
        end: int,  # the one after the last
        first_tile: int,
        tile_hit: wp.array(dtype=int),  # [tiles + 1] first hit of each tile; the tiles are counted from the first one
        hit_path: wp.array(dtype=int),  # [H]
        hit_is_partial: wp.array(dtype=wp.uint8),  # [H]
        hit_share: wp.array(dtype=float),  # [H TILE TILE]
        hit_slopes: wp.array(dtype=float),  # [H SLOPE_PLANES TILE TILE]
        matte_scale: real,  # factor of the last plane
        pixels: wp.array(dtype=int),  # [P]
        pixel_entry: wp.array(dtype=int),
        entry_next: wp.array(dtype=int),
        entry_row: wp.array(dtype=int),  # [M]
        row_path: wp.array(dtype=int),  # [R]
        # outputs
        entry_planes: wp.array(dtype=vec4),  # [M] change of the planes with the winding
        share_bounds: wp.array(dtype=int),  # [P + 1] the shares of each pixel
        share_path: wp.array(dtype=int),
        share_value: wp.array(dtype=real),
        pixel_open: wp.array(dtype=real),  # [P] share of the background
        squares: wp.array(dtype=real),  # [N + 1] takes away the squared shares; the last is the background's
    ):
        """Weigh the crossed pixels of some tiles. `measure_tiles` adds what all pixels show."""
        written = share_bounds[begin]
        for index in range(begin, end):
            pixel = pixels[index]
            tile = pixel // tile_pixels
            place = pixel - tile * tile_pixels
            hit_begin, hit_end = tile_hit[tile - first_tile], tile_hit[tile - first_tile + 1]
            open = one
            for hit in range(hit_begin, hit_end):
                share = real(hit_share[hit * tile_pixels + place])
                open -= share
                squares[hit_path[hit]] = squares[hit_path[hit]] - share * share
                if share > wp.static(real(SHARE_MIN)):
                    share_path[written] = hit_path[hit]
                    share_value[written] = share
                    written += 1
            share_bounds[index + 1] = written
            pixel_open[index] = open
            squares[squares.shape[0] - 1] = squares[squares.shape[0] - 1] - open * open
            entry = pixel_entry[pixel]
            while entry >= 0:
                planes, path = vec4(), row_path[entry_row[entry]]
                for hit in range(hit_begin, hit_end):
                    if hit_path[hit] == path and hit_is_partial[hit] != wp.uint8(0):
                        at = hit * wp.static(SLOPE_PLANES) * tile_pixels + place
                        planes = vec4(
                            real(hit_slopes[at]),
                            real(hit_slopes[at + tile_pixels]),
                            real(hit_slopes[at + 2 * tile_pixels]),
                            matte_scale * real(hit_slopes[at + 3 * tile_pixels]),
                        )
                entry_planes[entry] = planes
                entry = entry_next[entry]

    @wp.kernel(module=module)
    def measure_tiles(
        first: int,
        first_tile: int,
        tile_count: int,
        columns: int,
        width: int,
        height: int,
        has_background: int,  # whether the background counts
        tile_hit: wp.array(dtype=int),
        hit_path: wp.array(dtype=int),
        hit_share: wp.array(dtype=float),
        # outputs
        squares: wp.array(dtype=real),  # [N + 1] adds the sums of squared shares in all pixels
    ):
        """Add the squared shares of the paths, and of the background if it counts, in some tiles."""
        for index in range(tile_count):
            begin, end = tile_hit[index], tile_hit[index + 1]
            for hit in range(begin, end):
                total = zero
                for place in range(tile_pixels):
                    share = hit_share[hit * tile_pixels + place]
                    total += real(share * share)
                squares[hit_path[hit]] = squares[hit_path[hit]] + total
            if has_background != 0:
                tile = first_tile + index
                inside_x = wp.min(wp.static(TILE), width - wp.static(TILE) * (tile % columns))
                inside_y = wp.min(wp.static(TILE), height - wp.static(TILE) * (tile // columns))
                total = real(inside_x * inside_y)
                if end > begin:
                    for place in range(tile_pixels):
                        covered = float(0.0)
                        for hit in range(begin, end):
                            covered += hit_share[hit * tile_pixels + place]
                        total += real(covered) * (real(covered) - real(2.0))
                squares[squares.shape[0] - 1] = squares[squares.shape[0] - 1] + total

    return bundle(weigh_pixels, measure_tiles)
