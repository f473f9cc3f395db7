"""Update a row of a parameter by Adan (Xie et al. 2024, Algorithm 1) with bias correction.

A row is a path (or a palette entry) and has its own age. The loop over a row's values is written in C++, because the
CPU's compiler turns it into vector instructions. It cannot do that with Warp's loop over an array's second axis.
``warpvec/fit/adan.py`` describes the state.
"""

import math
from types import SimpleNamespace

import numpy as np
import warp as wp

from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

BETAS = (0.98, 0.92, 0.99)
"""Default shares of the old averages that are kept."""

EPS = 1e-8
"""Default number that is added to the root of the second moment."""

PLAIN, SCALED, CLAMPED, SIGMOID = range(4)
"""Forms of a parameter p. The gradient is that of the output: p itself; ``scale`` times p; p clamped to [0, 1]; the
sigmoid of p."""

# Numbers in the comments at the right are lines of Algorithm 1.
_UPDATE_ROW = """
typedef {c_type} real;
const int width = row_count * param.shape[1];
const long long start = (long long)row * param.shape[1];
const real* __restrict__ g = (const real*)((const char*)grad.data + (long long)row * grad.strides[0]);
real* __restrict__ p = param.data + start;
real* __restrict__ pm = exp_avg.data + start;
real* __restrict__ pv = exp_avg_diff.data + start;
real* __restrict__ pn = exp_avg_sq.data + start;
real* __restrict__ pg = previous_grad.data + start;
real* __restrict__ s = output.data + start;
int unusable = 0;
for (int i = 0; i < width; ++i) {{
    const real x = scale * g[i];
    unusable |= !((x < real({largest})) & (x > real(-{largest})));
}}
const real root_n = corrections[2];
const real factor_m = lr * root_n / corrections[0], factor_v = lr * betas[1] * root_n / corrections[1];
const real floor = eps * root_n;
for (int i = part; i < width; i += parts) {{
    real gradient = form == {SIGMOID} ? g[i] * s[i] * (real(1) - s[i]) : scale * g[i];
    gradient = unusable ? real(0) : gradient;
    const real difference = first_step ? real(0) : gradient - pg[i];  // as g_0 = g_1
    const real m = pm[i] + (real(1) - betas[0]) * (gradient - pm[i]);  // 3
    const real v = pv[i] + (real(1) - betas[1]) * (difference - pv[i]);  // 4
    const real ahead = gradient + betas[1] * difference;
    const real n = betas[2] * pn[i] + (real(1) - betas[2]) * ahead * ahead;  // 5
    real value = p[i] - (factor_m * m + factor_v * v) / (wp::sqrt(n) + floor);  // 6, 7
    if (form == {CLAMPED}) value = value < real(0) ? real(0) : value > real(1) ? real(1) : value;
    p[i] = value;
    pm[i] = m;
    pv[i] = v;
    pn[i] = n;
    pg[i] = gradient;
    if (form != {PLAIN}) s[i] = form == {SIGMOID} ? real(1) / (real(1) + wp::exp(-value)) : scale * value;
}}
"""


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Make ``corrections`` and ``update_row`` for the precision of ``lanes``."""
    dtype, vec3 = lanes.dtype, lanes.vec3
    one = wp.constant(dtype(1.0))
    # |g + b2 (g - g')| is at most 3 max(|g|, |g'|), and line 5 squares it.
    largest = math.sqrt(float(np.finfo(wp.dtype_to_numpy(dtype)).max)) / 4
    c_type = "float" if dtype is wp.float32 else "double"
    forms = {"PLAIN": PLAIN, "CLAMPED": CLAMPED, "SIGMOID": SIGMOID}

    @wp.func
    def corrections(age: wp.int64, log_betas: vec3):
        """Return 1 - b1^k, 1 - b2^k and the root of 1 - b3^k at the age k."""
        steps = dtype(age)
        root_n = wp.sqrt(one - wp.exp(steps * log_betas[2]))
        return vec3(one - wp.exp(steps * log_betas[0]), one - wp.exp(steps * log_betas[1]), root_n)

    @wp.func_native(_UPDATE_ROW.format(c_type=c_type, largest=repr(largest), **forms))
    def update_row(
        row: int,
        row_count: int,  # rows to update, from this one on; their gradients must be dense if there are several
        part: int,  # update every parts-th value of these rows, from this one on
        parts: int,
        form: int,
        scale: dtype,  # output over parameter; 1 unless SCALED
        first_step: bool,
        lr: dtype,
        betas: vec3,
        corrections: vec3,
        eps: dtype,
        grad: wp.array2d(dtype=dtype),  # [rows, width], rows any stride apart; of the output
        # in and out
        param: wp.array2d(dtype=dtype),  # [rows, width], as all that follow
        exp_avg: wp.array2d(dtype=dtype),  # m
        exp_avg_diff: wp.array2d(dtype=dtype),  # v
        exp_avg_sq: wp.array2d(dtype=dtype),  # n
        previous_grad: wp.array2d(dtype=dtype),
        output: wp.array2d(dtype=dtype),  # not touched if PLAIN
    ): ...

    return bundle(corrections, update_row)


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Make ``update_rows``."""
    dtype, vec3 = lanes.dtype, lanes.vec3
    one = wp.constant(dtype(1.0))
    optimizer = make_functions(lanes)
    module = stage_module("adan", lanes)

    @wp.kernel(module=module)
    def update_rows(
        first: int,
        grad: wp.array2d(dtype=dtype),  # [rows, width]
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
        """Take one step of one row."""
        row = first + wp.tid()
        age = row_age[row] + wp.int64(1)
        row_age[row] = age
        optimizer.update_row(
            row, 1, 0, 1, wp.static(PLAIN), one, age == wp.int64(1), lr, betas, optimizer.corrections(age, log_betas),
            eps, grad, param, exp_avg, exp_avg_diff, exp_avg_sq, previous_grad, param,
        )  # fmt: skip

    return bundle(update_rows)
