"""The straight or slightly round edges that explain patches of a picture best, by damped least squares.

Each has five unknowns: its angle, its distance from the middle of the patch, its curvature, and the levels on its two
sides. A table has the levels of a step from 0 to 1, by angle up to 45 degrees and by distance from it.
"""

import math
from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import bundle, unit
from warpvec.kernels.making import made_once

real = wp.float64
vec5 = wp.types.vector(5, dtype=wp.float64)
mat55 = wp.types.matrix((5, 5), dtype=wp.float64)

UNKNOWNS = 5


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``fit_edges``."""
    module = unit("edge_fitting")
    zero, half, one = (wp.constant(real(value)) for value in (0.0, 0.5, 1.0))
    least, most = wp.constant(real(0.0)), wp.constant(real(255.0))  # of levels
    quarter = wp.constant(real(4.0 / math.pi))
    change = wp.constant(real(0.01))  # of an unknown, for its slope
    tiny = wp.constant(real(1e-6))  # added to the diagonal, which vanishes where an unknown shows nowhere
    first_damping, damping_down, damping_up = (wp.constant(real(value)) for value in (1e-3, 0.3, 5.0))
    limits = wp.constant(vec5(0.2, 0.5, 0.05, 255.0, 255.0))  # largest moves
    last_column = wp.constant(real(1.001))

    @wp.struct
    class Step:
        """The direction across an edge, and its place among the angles of the table."""

        c: wp.float64
        s: wp.float64
        above: int
        down: wp.float64

    @wp.func
    def step_of(angle: real, angle_count: int):
        step = Step()
        step.c = wp.cos(angle)
        step.s = wp.sin(angle)
        near, far = wp.min(wp.abs(step.c), wp.abs(step.s)), wp.max(wp.abs(step.c), wp.abs(step.s))
        row = wp.atan2(near, far) * quarter * real(angle_count)
        step.above = wp.clamp(int(row), 0, angle_count - 1)
        step.down = row - real(step.above)
        return step

    @wp.func
    def share_at(
        step: Step, offset: real, curvature: real, x: real, y: real, spacing: real, table: wp.array2d(dtype=real)
    ):
        """Return the share of the second side of an edge in the pixel at (x, y)."""
        along, across = step.c * y - step.s * x, step.c * x + step.s * y
        place = (across - offset - half * curvature * along * along) / spacing + half * real(table.shape[1] - 1)
        column = wp.clamp(place, least, real(table.shape[1]) - last_column)
        left = int(column)
        right, above = column - real(left), step.above
        first = (one - right) * table[above, left] + right * table[above, left + 1]
        second = (one - right) * table[above + 1, left] + right * table[above + 1, left + 1]
        return (one - step.down) * first + step.down * second

    @wp.func
    def cost_of(
        patch: int,
        known: vec5,
        side: int,
        spacing: real,
        table: wp.array2d(dtype=real),
        levels: wp.array2d(dtype=real),
    ):
        """Return the sum of squares of what an edge leaves; saved levels are cut off."""
        step = step_of(known[0], table.shape[0] - 1)
        reach = half * real(side - 1)
        total = real(zero)
        for j in range(side):
            for i in range(side):
                share = share_at(step, known[1], known[2], real(i) - reach, real(j) - reach, spacing, table)
                rest = wp.clamp(known[3] + (known[4] - known[3]) * share, least, most) - levels[patch, j * side + i]
                total += rest * rest
        return total

    @wp.func
    def solved(square: mat55, damping: real, slope: vec5):
        """Return the move of damped least squares, by a Cholesky factorization without roots."""
        a = mat55(square)
        x = vec5(slope)
        for i in range(5):
            a[i, i] = a[i, i] * (one + damping) + tiny
        for j in range(5):
            for i in range(j + 1, 5):
                factor = a[i, j] / a[j, j]
                for k in range(j + 1, 5):
                    a[i, k] = a[i, k] - factor * a[j, k]
                x[i] = x[i] - factor * x[j]
        for back in range(5):
            j = 4 - back
            for k in range(j + 1, 5):
                x[j] = x[j] - a[j, k] * x[k]
            x[j] = x[j] / a[j, j]
        for i in range(5):
            x[i] = wp.clamp(-x[i], -limits[i], limits[i])
        return x

    @wp.kernel(module=module)
    def fit_edges(
        first: int,
        rounds: int,
        side: int,  # of a patch in px, odd
        curvature_max: real,
        spacing: real,  # of the places in the table, px; the edge is at the middle one
        table: wp.array2d(dtype=real),  # [angles + 1, places]
        levels: wp.array2d(dtype=real),  # [N, side * side] in [0, 255]
        # in and out
        unknowns: wp.array2d(dtype=real),  # [N, 5]
        # outputs
        costs: wp.array(dtype=real),  # [N] sum of the squares of what is left
    ):
        patch = first + wp.tid()
        known = vec5(unknowns[patch, 0], unknowns[patch, 1], unknowns[patch, 2], unknowns[patch, 3], unknowns[patch, 4])
        damping = real(first_damping)
        cost = cost_of(patch, known, side, spacing, table, levels)
        square = mat55()
        slope = vec5()
        is_new = bool(True)
        reach = half * real(side - 1)
        for _turn in range(rounds):
            if is_new:
                square = mat55()
                slope = vec5()
                here = step_of(known[0], table.shape[0] - 1)
                turned = step_of(known[0] + change, table.shape[0] - 1)
                height = known[4] - known[3]
                scale = height / change
                for k in range(side * side):
                    x, y = real(k % side) - reach, real(k // side) - reach
                    share = share_at(here, known[1], known[2], x, y, spacing, table)
                    drawn = known[3] + height * share
                    level = levels[patch, k]
                    if (drawn > least or level > half) and (drawn < most or level < most - half):
                        by_angle = share_at(turned, known[1], known[2], x, y, spacing, table) - share
                        by_offset = share_at(here, known[1] + change, known[2], x, y, spacing, table) - share
                        by_bend = share_at(here, known[1], known[2] + change, x, y, spacing, table) - share
                        row = vec5(scale * by_angle, scale * by_offset, scale * by_bend, one - share, share)
                        slope += row * (wp.clamp(drawn, least, most) - level)
                        square += wp.outer(row, row)
            tried = known + solved(square, damping, slope)
            tried[2] = wp.clamp(tried[2], -curvature_max, curvature_max)
            # Or shading beside a side of 255 levels looks like the rim of 400.
            tried[3] = wp.clamp(tried[3], least, most)
            tried[4] = wp.clamp(tried[4], least, most)
            new = cost_of(patch, tried, side, spacing, table, levels)
            is_new = new < cost
            if is_new:
                known = vec5(tried)
                cost = real(new)
                damping *= damping_down
            else:
                damping *= damping_up
        for i in range(5):
            unknowns[patch, i] = known[i]
        costs[patch] = cost

    return bundle(fit_edges)
