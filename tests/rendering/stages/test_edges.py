"""Edges against columns: no part of an edge is outside its range, and every quotient is finite."""

import numpy as np
import torch
import warp as wp
from numpy.typing import NDArray
from oracles import precisions
from sweep import sweep

from warpvec.kernels import edges
from warpvec.kernels.constants import COLUMN_GUARD, FLAT_EDGE
from warpvec.kernels.lanes import make_lanes
from warpvec.rendering.launch import start_warp

_KERNELS = {}


def make_probes(dtype: torch.dtype) -> tuple[wp.Kernel, wp.Kernel]:
    """Return kernels that call each scalar function once per edge; a second build would compile the module again."""
    if dtype not in _KERNELS:
        _KERNELS[dtype] = _make_probes(dtype)
    return _KERNELS[dtype]


def _make_probes(dtype: torch.dtype) -> tuple[wp.Kernel, wp.Kernel]:
    start_warp()
    lanes = make_lanes(1, wp.dtype_from_torch(dtype))
    functions = edges.make_functions(lanes)
    inverse, column_range, crossing = functions.inverse, functions.column_range, functions.crossing
    real, vec2 = lanes.dtype, lanes.vec2
    module = wp.get_module(f"test_edges.{lanes.name}")
    module.options.update(enable_backward=False)

    @wp.kernel(module=module)
    def ranges(
        start: wp.array(dtype=vec2), end: wp.array(dtype=vec2), top: real, bottom: real, out: wp.array(dtype=wp.vec2i)
    ):
        i = wp.tid()
        low, high = column_range(start[i][0], start[i][1], end[i][0], end[i][1], top, bottom)
        out[i] = wp.vec2i(low, high)

    @wp.kernel(module=module)
    def quotients(row: wp.array(dtype=int), difference: wp.array(dtype=real), out: wp.array2d(dtype=real)):
        i = wp.tid()
        out[i, 0] = inverse(difference[i])
        out[i, 1] = crossing(row[i], real(0.0), inverse(difference[i]))

    return ranges, quotients


def ranges_of(start: NDArray, end: NDArray, top: float, bottom: float, dtype: torch.dtype, device: str) -> NDArray:
    """Return first and last column of each edge."""
    kernel, _ = make_probes(dtype)
    vec2 = make_lanes(1, wp.dtype_from_torch(dtype)).vec2
    out = wp.zeros(len(start), dtype=wp.vec2i, device=device)
    ends = [wp.array(side, dtype=vec2, device=device) for side in (start, end)]
    wp.launch(kernel, dim=len(start), inputs=[*ends, top, bottom, out], device=device)
    return out.numpy()


def random_edges(count: int = 300, size: float = 100.0) -> tuple[NDArray, NDArray]:
    """Return edges; a third of them are horizontal, vertical, or have their ends on the grid."""
    generator = np.random.default_rng(3)
    start, end = generator.uniform(-0.2 * size, size, (2, count, 2))
    end[::9, 0], end[1::9, 1] = start[::9, 0], start[1::9, 1]
    start[2::9], end[2::9] = start[2::9].round(), end[2::9].round()
    return start, end


@precisions
def test_column_range_holds_the_edge_and_little_more(dtype: torch.dtype, device: str) -> None:
    start, end = random_edges()
    top, bottom = 32.0, 48.0
    got = ranges_of(start, end, top, bottom, dtype, device)
    s = np.linspace(0, 1, 2001)[:, None, None]
    x, y = np.moveaxis(start + s * (end - start), -1, 0)
    inside = (top <= y) & (y <= bottom)
    low, high = np.where(inside, x, np.inf).min(0), np.where(inside, x, -np.inf).max(0)
    crossing = inside.any(0)
    assert crossing.sum() > 30
    step = np.abs(end - start)[:, 0] / 2000
    assert (got[crossing, 0] <= np.floor(low[crossing])).all()
    assert (got[crossing, 1] >= np.floor(high[crossing])).all()
    slack = 2 * COLUMN_GUARD + step[crossing]
    assert (got[crossing, 0] >= np.floor(low[crossing] - slack)).all()
    assert (got[crossing, 1] <= np.floor(high[crossing] + slack)).all()


@precisions
def test_huge_edges_have_columns_that_fit_an_integer(dtype: torch.dtype, device: str) -> None:
    start, end = np.array([[-3e38, 0.0], [3e38, -3e38]]), np.array([[3e38, 16.0], [-3e38, 3e38]])
    got = ranges_of(start, end, 0.0, 16.0, dtype, device)
    assert (got[:, 0] < 0).all() and (got[:, 1] > 1000).all() and (got[:, :2] != np.iinfo(np.int32).min).all()


@precisions
@sweep("difference", [0.0, -0.0, 1e-40, -1e-40, 1e-30, -1e-30, 1e-19, -1e-19, 3.0])
def test_inverse_and_crossing_are_finite(dtype: torch.dtype, difference: float, device: str) -> None:
    _, kernel = make_probes(dtype)
    lanes = make_lanes(1, wp.dtype_from_torch(dtype))
    rows = np.array([0, 1, -1, 10**7, -(10**7)], np.int32)
    out = wp.zeros((len(rows), 2), dtype=lanes.dtype, device=device)
    differences = wp.array(np.full(len(rows), difference), dtype=lanes.dtype, device=device)
    arrays = [wp.array(rows, dtype=int, device=device), differences]
    wp.launch(kernel, dim=len(rows), inputs=[*arrays, out], device=device)
    inverse, crossing = out.numpy().T.astype(np.float64)
    assert np.isfinite(inverse).all() and np.isfinite(crossing).all()
    want = 1 / (difference if abs(difference) > FLAT_EDGE else -FLAT_EDGE if difference < 0 else FLAT_EDGE)
    np.testing.assert_allclose(inverse, want, rtol=1e-6)
    np.testing.assert_allclose(crossing, rows * want, rtol=1e-6)
