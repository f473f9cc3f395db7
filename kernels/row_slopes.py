"""How the curves of a drawing follow the values that a fit moves: anchors, and handles that smooth nodes align.

A row is a curve of four points, its end included. It depends on few values: each has a column with the derivatives of
the row's values. Handles of a smooth node are projected onto its mean direction, which turns with both of them and with
the ends of a line beside it.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import DIRECTION_MIN
from warpvec.kernels.crossed_pixels import vec9
from warpvec.kernels.lanes import bundle, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.vectors import as_real

POINT_COLUMNS, COLUMNS_MAX = 16, 23
"""Most coordinates of points that a curve depends on, and most values: with a width and six numbers of a form."""

mat22 = wp.mat22d
real = wp.float64


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``follow_points`` and ``gather_adjoint``."""
    module = unit("normal_matrix")
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    @wp.func
    def put(
        row: int,
        place: int,  # of the point in the curve
        column: int,
        block: mat22,
        table: wp.array2d(dtype=vec9),
    ):
        """Add how a point of a row follows the two coordinates from a column on."""
        for j in range(2):
            found = table[row, column + j]
            found[2 * place] = found[2 * place] + block[0, j]
            found[2 * place + 1] = found[2 * place + 1] + block[1, j]
            table[row, column + j] = found

    @wp.func
    def handle_at(
        row: int,
        node: int,
        side: int,  # 0 for the leaving handle, 1 for the arriving one
        first_anchor: int,  # column of the anchor of the node before; those of this one and the next follow
        first_handle: int,  # column of the leaving handle; that of the arriving one follows
        row_next: wp.array(dtype=int),
        row_previous: wp.array(dtype=int),
        is_line: wp.array(dtype=wp.bool),
        is_smooth: wp.array(dtype=wp.bool),
        least: wp.array(dtype=wp.vec2f),
        is_held: wp.array2d(dtype=wp.bool),
        anchor: wp.array(dtype=wp.vec2f),
        leaving: wp.array(dtype=wp.vec2f),
        arriving: wp.array(dtype=wp.vec2f),
        table: wp.array2d(dtype=vec9),
    ):
        """Put in how a handle of a node follows the anchors and handles."""
        place = 1 + side
        whole = wp.identity(n=2, dtype=real)
        if not is_smooth[node]:
            put(row, place, first_handle + 2 * side, whole, table)
        else:
            before, after = row_previous[node], row_next[node]
            ahead, behind = as_real(leaving[node]), -as_real(arriving[node])
            here = as_real(anchor[node])
            if is_line[node]:
                ahead = as_real(anchor[after]) - here
            if is_line[before]:
                behind = here - as_real(anchor[before])
            by_ahead, by_behind = one, one
            if is_line[before]:
                by_ahead = zero
            if is_line[node]:
                by_behind = zero
            mean = by_ahead * ahead + by_behind * behind
            length = wp.max(wp.length(mean), wp.static(real(DIRECTION_MIN)))
            ahead = mean / length
            along = wp.outer(ahead, ahead)
            across = (whole - along) / length
            handle = as_real(leaving[node])
            reach = wp.max(wp.dot(handle, ahead), real(least[node][0]))
            if side == 1:
                handle = as_real(arriving[node])
                reach = wp.min(wp.dot(handle, ahead), -real(least[node][1]))
            is_long = zero
            if not is_held[node, side]:
                is_long = one
            turn = reach * across + is_long * wp.outer(ahead, handle * across)
            on_leaving, on_arriving, on_next, on_previous = by_ahead, -by_behind, zero, zero
            if is_line[node]:
                on_leaving, on_next = zero, by_ahead
            if is_line[before]:
                on_arriving, on_previous = zero, by_behind
            put(row, place, first_handle, on_leaving * turn, table)
            put(row, place, first_handle + 2, on_arriving * turn, table)
            put(row, place, first_handle + 2 * side, is_long * along, table)
            put(row, place, first_anchor, -on_previous * turn, table)
            put(row, place, first_anchor + 2, (on_previous - on_next) * turn, table)
            put(row, place, first_anchor + 4, on_next * turn, table)

    @wp.kernel(module=module)
    def follow_points(
        first: int,
        row_count: int,  # R
        row_next: wp.array(dtype=int),  # [R]
        row_previous: wp.array(dtype=int),  # [R]
        row_path: wp.array(dtype=int),  # [R]
        is_line: wp.array(dtype=wp.bool),  # [R]
        is_smooth: wp.array(dtype=wp.bool),  # [R]
        least: wp.array(dtype=wp.vec2f),  # [R] least lengths of the leaving and the arriving handle
        is_held: wp.array2d(dtype=wp.bool),  # [R, 2] handles that keep their length
        anchor: wp.array(dtype=wp.vec2f),  # [R] px
        leaving: wp.array(dtype=wp.vec2f),  # [R] px, from the anchor
        arriving: wp.array(dtype=wp.vec2f),  # [R] px, from the anchor
        first_width: int,  # the value that is the width of the first path, or -1 if there are no strokes
        # outputs
        table: wp.array2d(dtype=vec9),  # [R, COLUMNS_MAX] change of the row's values with each value
        column_value: wp.array2d(dtype=int),  # [R, COLUMNS_MAX] the values
        column_count: wp.array(dtype=int),  # [R] how many there are
    ):
        """Write the columns of all rows that are not zero."""
        whole = wp.identity(n=2, dtype=real)
        for row in range(row_count):
            after = row_next[row]
            for column in range(wp.static(POINT_COLUMNS)):
                table[row, column] = vec9()
            put(row, 0, 2, whole, table)
            put(row, 3, 4, whole, table)
            if is_line[row]:
                put(row, 1, 2, (real(2.0) / real(3.0)) * whole, table)
                put(row, 1, 4, (one / real(3.0)) * whole, table)
                put(row, 2, 2, (one / real(3.0)) * whole, table)
                put(row, 2, 4, (real(2.0) / real(3.0)) * whole, table)
            else:
                put(row, 1, 2, whole, table)
                put(row, 2, 4, whole, table)
                handle_at(
                    row, row, 0, 0, 8, row_next, row_previous, is_line, is_smooth, least, is_held, anchor, leaving,
                    arriving, table,
                )  # fmt: skip
                handle_at(
                    row, after, 1, 2, 12, row_next, row_previous, is_line, is_smooth, least, is_held, anchor, leaving,
                    arriving, table,
                )  # fmt: skip
            count = int(0)
            for column in range(wp.static(POINT_COLUMNS)):
                found = table[row, column]
                if wp.dot(found, found) != zero:
                    part = column // 2
                    node, kind = row, int(0)  # of the anchor of this node
                    if part == 0:
                        node = row_previous[row]
                    if part == 2 or part >= 6:
                        node = after
                    if part == 3:
                        node = row_next[after]
                    if part >= 4:
                        kind = 1 + part % 2
                    table[row, count] = found
                    column_value[row, count] = 2 * (kind * row_count + node) + column % 2
                    count += 1
            if first_width >= 0:
                found = vec9()
                found[8] = one
                table[row, count] = found
                column_value[row, count] = first_width + row_path[row]
                count += 1
            column_count[row] = count

    @wp.kernel(module=module)
    def gather_adjoint(
        first: int,
        row_count: int,  # R
        adj_points: wp.array2d(dtype=wp.vec2f),  # [R, 3] adjoints of the control points
        table: wp.array2d(dtype=vec9),
        column_value: wp.array2d(dtype=int),
        column_count: wp.array(dtype=int),
        # outputs
        adj_values: wp.array(dtype=real),  # [K] adds
    ):
        """Add up the adjoints of the values that curves follow; the end of a curve belongs to the next one."""
        for row in range(row_count):
            adjoint = vec9()
            for k in range(3):
                adjoint[2 * k] = real(adj_points[row, k][0])
                adjoint[2 * k + 1] = real(adj_points[row, k][1])
            for column in range(column_count[row]):
                value = column_value[row, column]
                adj_values[value] = adj_values[value] + wp.dot(table[row, column], adjoint)

    return bundle(follow_points, gather_adjoint)
