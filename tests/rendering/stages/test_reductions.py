"""Sums over groups of neighbouring lanes: one entry per group, whatever its value was before."""

import numpy as np
import torch
import warp as wp
from sweep import sweep

from warpvec.kernels.constants import REDUCED_LANES
from warpvec.kernels.reductions import group_reduction
from warpvec.rendering.launch import start_warp


def make_kernel(dtype):
    """Return a kernel in which each lane adds its value to the entry of its group, in column ``term``."""
    start_warp()
    reduce_group = group_reduction(dtype)
    module = wp.get_module(f"warpvec.tests.reductions.{dtype.__name__}")
    module.options.update(enable_backward=False)

    @wp.kernel(module=module)
    def sum_groups(values: wp.array(dtype=dtype), term: int, sums: wp.array2d(dtype=dtype)):
        lane = wp.tid()
        reduce_group(sums, lane // wp.static(REDUCED_LANES), term, values[lane], lane)

    return sum_groups


@sweep("dtype", [wp.float32, wp.float64])
@sweep("group_count", [1, 2, 9])
def test_each_entry_is_the_sum_of_its_group(device: str, dtype: type, group_count: int) -> None:
    start_warp()
    values = torch.randn(group_count * REDUCED_LANES, dtype=wp.dtype_to_torch(dtype), device=device)
    sums = torch.full((group_count, 3), torch.nan, dtype=values.dtype, device=device)
    inputs = [wp.from_torch(values), 1, wp.from_torch(sums)]
    wp.launch(make_kernel(dtype), dim=len(values), inputs=inputs, device=device)
    want = values.double().reshape(group_count, REDUCED_LANES).sum(1)
    torch.testing.assert_close(sums[:, 1].double(), want, rtol=1e-6, atol=1e-6)
    assert np.isnan(sums[:, [0, 2]].cpu().numpy()).all()
