"""Damped Gauss-Newton steps of few values: the equations as a whole matrix, their factors, and bounds of the moves.

The factors are L D L^T without pivots: damping keeps the diagonal positive. Rows of zeros are passed over, so values
that stand near those that they act with, such as the points of a node and of the next, cost little. Points that a step
would move too far are damped more, and the equations are solved again. One work item does all.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import bundle, unit
from warpvec.kernels.making import made_once

real = wp.float64


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``add_entries``, ``take_limited_step`` and ``expect_decrease``."""
    module = unit("normal_matrix")
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    # Plain loops, which the compiler makes lanes of. Warp's own accesses test for negative indices.
    @wp.func_native(
        "const double* from = (const double*)rows.data + (size_t)row * size;"
        "double* to = (double*)rows.data + (size_t)other * size;"
        "for (int i = other; i < end; ++i) to[i] -= share * from[i];"
    )
    def subtract_row(rows: wp.array(dtype=real), size: int, row: int, other: int, end: int, share: real): ...

    @wp.func
    def factor(rows: wp.array(dtype=real), size: int):
        """Replace a symmetric matrix, of which the upper half counts, by its factors D L^T."""
        for row in range(size):
            at = row * size
            end = size
            while end > row + 1 and rows[at + end - 1] == zero:
                end -= 1
            if rows[at + row] == zero:
                rows[at + row] = wp.static(real(1e-300))
            for other in range(row + 1, end):
                share = rows[at + other] / rows[at + row]
                if share != zero:
                    subtract_row(rows, size, row, other, end, share)

    @wp.func
    def solve(rows: wp.array(dtype=real), size: int, found: wp.array(dtype=real)):
        """Replace the right side ``found`` by the solution of the equations with factors ``rows``."""
        for row in range(size):
            share = found[row] / rows[row * size + row]
            for other in range(row + 1, size):
                found[other] = found[other] - share * rows[row * size + other]
        for turn in range(size):
            row = size - 1 - turn
            total = found[row]
            for other in range(row + 1, size):
                total = total - rows[row * size + other] * found[other]
            found[row] = total / rows[row * size + row]

    @wp.func
    def excess_of(point: int, step: wp.array(dtype=real), limit: wp.array(dtype=real)):
        """Return how far a step moves a point, in times of its limit."""
        return wp.length(wp.vec2d(step[2 * point], step[2 * point + 1])) / limit[point]

    @wp.kernel(module=module)
    def add_entries(
        first: int,
        count: int,
        entry_row: wp.array(dtype=int),  # [count] values
        entry_column: wp.array(dtype=int),
        entry_value: wp.array(dtype=real),
        place: wp.array(dtype=int),  # [K] of each value in the equations; -1 if it is fixed
        size: int,  # number of equations F
        # in and out
        rows: wp.array(dtype=real),  # [F F]
        diagonal: wp.array(dtype=real),  # [K]
    ):
        """Add entries of the matrix to the upper half of the equations; those of its lower half are the same."""
        for index in range(count):
            value, other = entry_row[index], entry_column[index]
            if value == other:
                diagonal[value] = diagonal[value] + entry_value[index]
            one_place, other_place = place[value], place[other]
            if one_place >= 0 and one_place <= other_place:
                at = one_place * size + other_place
                rows[at] = rows[at] + entry_value[index]

    @wp.kernel(module=module)
    def take_limited_step(
        first: int,
        size: int,  # F
        order: wp.array(dtype=int),  # [F] the value of each equation
        rows: wp.array(dtype=real),  # [F F]
        scale: wp.array(dtype=real),  # [F] diagonal that damping multiplies
        slope: wp.array(dtype=real),  # [F]
        damping: real,
        point_count: int,  # P, the points are the first values, two each
        limit: wp.array(dtype=real),  # [P] px that a point may move
        rounds: int,
        most: real,  # moves of so many times the limit are cut at once
        grows: real,  # factor of the damping of a point that moves as far as it may
        # in and out
        extra: wp.array(dtype=real),  # [P] factor of the damping of each point
        # scratch
        work: wp.array(dtype=real),  # [F F]
        found: wp.array(dtype=real),  # [F]
        # outputs
        step: wp.array(dtype=real),  # [K] zero where values are fixed
    ):
        """Solve the equations with more damping of the points that move too far, and cut what still does."""
        for _turn in range(rounds):
            for row in range(size):
                for other in range(row, size):
                    work[row * size + other] = rows[row * size + other]
                more = damping * scale[row]
                if order[row] < 2 * point_count:
                    more = more * extra[order[row] // 2]
                work[row * size + row] = work[row * size + row] + more
                found[row] = -slope[row]
            factor(work, size)
            solve(work, size, found)
            for row in range(size):
                step[order[row]] = found[row]
            worst = real(0.0)
            for point in range(point_count):
                worst = wp.max(worst, excess_of(point, step, limit))
            if worst < most:
                break
            for point in range(point_count):
                excess = excess_of(point, step, limit)
                if excess > one:
                    extra[point] = extra[point] * grows * excess * wp.sqrt(excess)
        for point in range(point_count):
            excess = wp.max(excess_of(point, step, limit), one)
            for k in range(2):
                step[2 * point + k] = step[2 * point + k] / excess

    @wp.kernel(module=module)
    def expect_decrease(
        first: int,
        size: int,
        order: wp.array(dtype=int),
        rows: wp.array(dtype=real),
        slope: wp.array(dtype=real),
        step: wp.array(dtype=real),  # [K]
        # outputs
        decrease: wp.array(dtype=real),  # [1]
    ):
        """Write by how much the loss should fall with a step."""
        total = real(0.0)
        for row in range(size):
            own = step[order[row]]
            across = real(0.0)
            if own != zero:
                for other in range(row + 1, size):
                    across = across + rows[row * size + other] * step[order[other]]
            half = wp.static(real(0.5)) * rows[row * size + row] * own
            total = total - own * (slope[row] + half + across)
        decrease[0] = total

    return bundle(add_entries, take_limited_step, expect_decrease)
