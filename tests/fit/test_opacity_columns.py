"""Three opacities of a path are put side by side and apart without a change."""

from __future__ import annotations

import pytest
import torch

from warpvec.fit.opacity_columns import OpacityColumns
from warpvec.geometry.side_opacity import SideOpacity


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_opacities_come_apart_as_they_were_joined(dtype: torch.dtype) -> None:
    columns = OpacityColumns("cpu")
    for count in (3, 5):
        middle, sides = torch.rand(count, dtype=dtype), torch.rand(count, 2, dtype=dtype)
        joined = columns.joined(middle, sides)
        assert torch.equal(joined, torch.cat([middle[:, None], sides], 1))
        own, apart = torch.zeros_like(middle), SideOpacity(torch.zeros_like(sides))
        columns.part(joined, own, apart)
        assert torch.equal(own, middle) and torch.equal(apart.value, sides)


def test_memory_that_a_graph_may_write_to_stays_while_fewer_paths_are_joined() -> None:
    columns = OpacityColumns("cpu")
    first = columns.joined(torch.rand(7), torch.rand(7, 2)).data_ptr()

    assert columns.joined(torch.rand(3), torch.rand(3, 2)).data_ptr() == first
    assert columns.joined(torch.rand(7), torch.rand(7, 2)).data_ptr() == first
