"""The Gauss-Newton matrix J^T J of a drawing, from the derivatives of the pixels that its outlines cross.

A pixel's derivative by the values of a row is its change with the winding, in four planes, times the winding's change
with these values (``crossed_pixels.py``). The products of two rows, and of a row and the colour of a path, are added
up in blocks, which hash tables find. A block becomes entries of the matrix by the derivative of the rows by the values
of the drawing (``row_slopes.py``). One work item does all, because there is little to do and much to share.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.crossed_pixels import ROW_VALUES, vec9
from warpvec.kernels.lanes import bundle, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.pixel_weights import SHARE_MIN, vec4

ROW_PAIRS, ROW_COLORS, COLOR_PAIRS, TRIPLES = range(4)
"""Indices of counts: of blocks of two rows, of a row and three values of paints, of two paths; of what is written."""

real = wp.float64


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``multiply_pixels``, ``multiply_paints`` and ``write_matrix``."""
    module = unit("normal_matrix")
    values = wp.constant(ROW_VALUES)
    zero = wp.constant(real(0.0))

    @wp.func
    def find(
        key: wp.int64,
        number: int,  # which of the tables
        tables: wp.array2d(dtype=int),
        keys: wp.array2d(dtype=wp.int64),
        counts: wp.array(dtype=int),
    ):
        """Return the block of a key, -1 if there is no room for one more, and whether it is new."""
        mask = tables.shape[1] - 1
        at = int((key * wp.int64(2654435761)) >> wp.int64(12)) & mask
        while tables[number, at] >= 0 and keys[number, wp.max(tables[number, at], 0)] != key:
            at = (at + 1) & mask
        found, is_new = int(tables[number, at]), bool(False)
        if found < 0:
            count = counts[number]
            counts[number] = wp.min(count, keys.shape[1]) + 1  # one too many says that there is no room
            if count < keys.shape[1]:
                tables[number, at] = count
                keys[number, count] = key
                found, is_new = count, True
        return found, is_new

    @wp.func
    def add_color(
        row: int,
        value: int,
        weight: real,
        slopes: vec9,
        group_count: int,
        tables: wp.array2d(dtype=int),
        keys: wp.array2d(dtype=wp.int64),
        counts: wp.array(dtype=int),
        row_colors: wp.array(dtype=vec9),
    ):
        """Add to the block of a row and the three values of paints of which ``value`` is one."""
        group = value // 3
        key = wp.int64(row) * wp.int64(group_count) + wp.int64(group)
        block, is_new = find(key, wp.static(ROW_COLORS), tables, keys, counts)
        if block >= 0:
            if is_new:
                for k in range(3):
                    row_colors[3 * block + k] = vec9()
            row_colors[3 * block + value - 3 * group] = row_colors[3 * block + value - 3 * group] + weight * slopes

    @wp.kernel(module=module)
    def multiply_pixels(
        first: int,
        pixel_count: int,
        row_count: int,
        path_count: int,
        group_count: int,  # groups of three values of paints
        is_flat: int,  # whether all paints are flat; else their products are left to `multiply_paints`
        pixels: wp.array(dtype=int),
        pixel_entry: wp.array(dtype=int),
        entry_next: wp.array(dtype=int),
        entry_row: wp.array(dtype=int),
        entry_slopes: wp.array(dtype=vec9),
        entry_planes: wp.array(dtype=vec4),
        share_bounds: wp.array(dtype=int),
        share_path: wp.array(dtype=int),
        share_value: wp.array(dtype=real),
        pixel_open: wp.array(dtype=real),
        # in and out
        tables: wp.array2d(dtype=int),
        keys: wp.array2d(dtype=wp.int64),
        counts: wp.array(dtype=int),
        # outputs
        row_pairs: wp.array2d(dtype=vec9),  # [blocks, ROW_VALUES] the row of the lower number first
        row_colors: wp.array(dtype=vec9),  # [3 blocks] of three values each
        color_pairs: wp.array(dtype=real),  # [blocks] of two paths, or of one and the background
    ):
        """Add up the products of all pixels in blocks; those without room are counted only."""
        for index in range(pixel_count):
            begin, end = share_bounds[index], share_bounds[index + 1]
            one_entry = pixel_entry[pixels[index]]
            while one_entry >= 0:
                other = one_entry
                while other >= 0:
                    weight = wp.dot(entry_planes[one_entry], entry_planes[other])
                    if weight != zero:
                        entry_a, entry_b = one_entry, other
                        if entry_row[one_entry] > entry_row[other]:
                            entry_a, entry_b = other, one_entry
                        low = entry_slopes[entry_a]
                        high = entry_slopes[entry_b]
                        row_a = entry_row[entry_a]
                        row_b = entry_row[entry_b]
                        key = wp.int64(row_a) * wp.int64(row_count) + wp.int64(row_b)
                        block, is_new = find(key, wp.static(ROW_PAIRS), tables, keys, counts)
                        if block >= 0:
                            if is_new:
                                for k in range(values):
                                    row_pairs[block, k] = vec9()
                            for k in range(values):
                                row_pairs[block, k] = row_pairs[block, k] + (weight * low[k]) * high
                            if row_a == row_b and other != one_entry:
                                for k in range(values):
                                    row_pairs[block, k] = row_pairs[block, k] + (weight * high[k]) * low
                    other = entry_next[other]
                if is_flat != 0:
                    row = entry_row[one_entry]
                    planes = entry_planes[one_entry]
                    slopes = entry_slopes[one_entry]
                    for k in range(3):
                        for at in range(begin, end):
                            weight = planes[k] * share_value[at]
                            add_color(
                                row, 3 * share_path[at] + k, weight, slopes, group_count, tables, keys, counts,
                                row_colors,
                            )  # fmt: skip
                        if pixel_open[index] > wp.static(real(SHARE_MIN)):
                            weight = planes[k] * pixel_open[index]
                            add_color(
                                row, 4 * path_count + k, weight, slopes, group_count, tables, keys, counts,
                                row_colors,
                            )  # fmt: skip
                one_entry = entry_next[one_entry]
            if is_flat != 0:
                for at in range(begin, end + 1):
                    for to in range(at, end + 1):
                        path_a, share_a = int(path_count), real(pixel_open[index])
                        path_b, share_b = int(path_count), real(pixel_open[index])
                        if at < end:
                            path_a, share_a = int(share_path[at]), real(share_value[at])
                        if to < end:
                            path_b, share_b = int(share_path[to]), real(share_value[to])
                        if share_b > wp.static(real(SHARE_MIN)):
                            key = wp.int64(path_a) * wp.int64(path_count + 1) + wp.int64(path_b)
                            block, is_new = find(key, wp.static(COLOR_PAIRS), tables, keys, counts)
                            if block >= 0:
                                if is_new:
                                    color_pairs[block] = zero
                                color_pairs[block] = color_pairs[block] + share_a * share_b

    @wp.kernel(module=module)
    def multiply_paints(
        first: int,
        pixel_count: int,
        group_count: int,
        bounds: wp.array(dtype=int),  # [3 P + 1] the entries of each row of the next two: red, green, then blue
        columns: wp.array(dtype=int),  # the value of a paint
        slopes_by: wp.array(dtype=real),  # change of the pixel with it
        pixels: wp.array(dtype=int),
        pixel_entry: wp.array(dtype=int),
        entry_next: wp.array(dtype=int),
        entry_row: wp.array(dtype=int),
        entry_slopes: wp.array(dtype=vec9),
        entry_planes: wp.array(dtype=vec4),
        tables: wp.array2d(dtype=int),
        keys: wp.array2d(dtype=wp.int64),
        counts: wp.array(dtype=int),
        # outputs
        row_colors: wp.array(dtype=vec9),
    ):
        """Add the products of rows with the values of paints."""
        for index in range(pixel_count):
            entry = pixel_entry[pixels[index]]
            while entry >= 0:
                planes = entry_planes[entry]
                slopes = entry_slopes[entry]
                for k in range(3):
                    if planes[k] != zero:
                        for at in range(bounds[k * pixel_count + index], bounds[k * pixel_count + index + 1]):
                            weight = planes[k] * slopes_by[at]
                            add_color(
                                entry_row[entry], columns[at], weight, slopes, group_count, tables, keys, counts,
                                row_colors,
                            )  # fmt: skip
                entry = entry_next[entry]

    @wp.func
    def write(
        row: int,
        column: int,
        value: real,
        counts: wp.array(dtype=int),
        triple_row: wp.array(dtype=int),
        triple_column: wp.array(dtype=int),
        triple_value: wp.array(dtype=real),
    ):
        """Write an entry of the matrix."""
        at = counts[wp.static(TRIPLES)]
        triple_row[at] = row
        triple_column[at] = column
        triple_value[at] = value
        counts[wp.static(TRIPLES)] = at + 1

    @wp.kernel(module=module)
    def write_matrix(
        first: int,
        row_count: int,
        path_count: int,
        group_count: int,
        first_paint: int,  # the value that is the first of the paints
        factor: real,
        keys: wp.array2d(dtype=wp.int64),
        row_pairs: wp.array2d(dtype=vec9),
        row_colors: wp.array(dtype=vec9),
        color_pairs: wp.array(dtype=real),
        column_count: wp.array(dtype=int),  # [R] see ``row_slopes.py``
        column_value: wp.array2d(dtype=int),  # [R, COLUMNS_MAX]
        column_slopes: wp.array2d(dtype=vec9),  # [R, COLUMNS_MAX]
        # in and out
        counts: wp.array(dtype=int),
        # outputs: entries of the matrix, some more than once
        triple_row: wp.array(dtype=int),
        triple_column: wp.array(dtype=int),
        triple_value: wp.array(dtype=real),
    ):
        """Write the entries of all blocks, and those of their transposes."""
        for block in range(counts[wp.static(ROW_PAIRS)]):
            key = keys[wp.static(ROW_PAIRS), block]
            row_a = int(key / wp.int64(row_count))
            row_b = int(key % wp.int64(row_count))
            for j in range(column_count[row_b]):
                by = vec9()
                slopes = column_slopes[row_b, j]
                for k in range(values):
                    by[k] = wp.dot(row_pairs[block, k], slopes)
                for i in range(column_count[row_a]):
                    value = factor * wp.dot(column_slopes[row_a, i], by)
                    if value != zero:
                        value_a = column_value[row_a, i]
                        value_b = column_value[row_b, j]
                        write(value_a, value_b, value, counts, triple_row, triple_column, triple_value)
                        if row_a != row_b:
                            write(value_b, value_a, value, counts, triple_row, triple_column, triple_value)
        for block in range(counts[wp.static(ROW_COLORS)]):
            key = keys[wp.static(ROW_COLORS), block]
            row_a = int(key / wp.int64(group_count))
            to = first_paint + 3 * int(key % wp.int64(group_count))
            for k in range(3):
                for i in range(column_count[row_a]):
                    value = factor * wp.dot(column_slopes[row_a, i], row_colors[3 * block + k])
                    if value != zero:
                        own = column_value[row_a, i]
                        write(own, to + k, value, counts, triple_row, triple_column, triple_value)
                        write(to + k, own, value, counts, triple_row, triple_column, triple_value)
        for block in range(counts[wp.static(COLOR_PAIRS)]):
            key = keys[wp.static(COLOR_PAIRS), block]
            path_a = int(key / wp.int64(path_count + 1))
            path_b = int(key % wp.int64(path_count + 1))
            at, to = first_paint + 3 * path_a, first_paint + 3 * path_b
            if path_a == path_count:
                at += path_count
            if path_b == path_count:
                to += path_count
            for k in range(3):
                write(at + k, to + k, factor * color_pairs[block], counts, triple_row, triple_column, triple_value)
                if at != to:
                    write(to + k, at + k, factor * color_pairs[block], counts, triple_row, triple_column, triple_value)

    return bundle(multiply_pixels, multiply_paints, write_matrix)
