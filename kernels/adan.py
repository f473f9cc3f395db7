"""The optimizer's update of a parameter, row by row: Adan (Xie et al. 2024, Algorithm 1) with bias correction.

A row is a path, and has its own age. One thread a row; ``warpvec/adan.py`` says what the state is.
"""

import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import warp as wp

from warpvec.kernels.lanes import Lanes, stage_module


@cache
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """``update_rows``."""
    dtype, vec3 = lanes.dtype, lanes.vec3
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    # |g + b2 (g - g')| is at most 3 max(|g|, |g'|), and line 5 squares it.
    largest = math.sqrt(float(np.finfo(wp.dtype_to_numpy(dtype)).max)) / 4
    inverse_largest = wp.constant(dtype(1.0 / largest))
    module = stage_module("adan", lanes)

    @wp.func
    def is_usable(grad: wp.array2d(dtype=dtype), row: int, width: int):
        """Whether a row of the gradient can be squared; not so if it holds a NaN or an infinity."""
        squared = dtype(0.0)
        for i in range(width):
            g = grad[row, i] * inverse_largest
            squared += g * g
        return squared < one

    @wp.kernel(module=module)
    def update_rows(
        first: int,
        grad: wp.array2d(dtype=dtype),  # [rows, width]
        width: int,
        lr: dtype,
        betas: vec3,
        log_betas: vec3,
        eps: dtype,
        # in and out
        row_age: wp.array(dtype=wp.int64),  # [rows] steps taken
        exp_avg: wp.array2d(dtype=dtype),  # [rows, width] m
        exp_avg_diff: wp.array2d(dtype=dtype),  # [rows, width] v
        exp_avg_sq: wp.array2d(dtype=dtype),  # [rows, width] n
        previous_grad: wp.array2d(dtype=dtype),  # [rows, width]
        param: wp.array2d(dtype=dtype),  # [rows, width]
    ):
        """One step of one row; numbers at the right are lines of Algorithm 1."""
        row = first + wp.tid()
        age = row_age[row] + wp.int64(1)
        row_age[row] = age
        steps = dtype(age)
        usable = is_usable(grad, row, width)
        correction_m = one - wp.exp(steps * log_betas[0])
        correction_v = one - wp.exp(steps * log_betas[1])
        root_n = wp.sqrt(one - wp.exp(steps * log_betas[2]))
        factor_m, factor_v = lr * root_n / correction_m, lr * betas[1] * root_n / correction_v
        floor = eps * root_n
        for i in range(width):
            g = wp.where(usable, grad[row, i], zero)
            difference = wp.where(age > wp.int64(1), g - previous_grad[row, i], zero)  # as g_0 = g_1
            m = exp_avg[row, i] + (one - betas[0]) * (g - exp_avg[row, i])  # 3
            v = exp_avg_diff[row, i] + (one - betas[1]) * (difference - exp_avg_diff[row, i])  # 4
            ahead = g + betas[1] * difference
            n = betas[2] * exp_avg_sq[row, i] + (one - betas[2]) * ahead * ahead  # 5
            param[row, i] = param[row, i] - (factor_m * m + factor_v * v) / (wp.sqrt(n) + floor)  # 6, 7
            exp_avg[row, i] = m
            exp_avg_diff[row, i] = v
            exp_avg_sq[row, i] = n
            previous_grad[row, i] = g

    return SimpleNamespace(update_rows=update_rows)
