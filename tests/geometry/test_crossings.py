"""Counting where an outline crosses itself."""

from typing import Any

import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode

from warpvec.geometry.crossings import self_crossings
from warpvec.svg.read import read_svg

SQUARE = "M10 10 H50 V50 H10z"


@pytest.mark.parametrize(
    ("data", "count"),
    [
        (SQUARE, 0),
        ("M10 10 L50 50 H10 L50 11z", 1),
        ("M10 10 C80 50 -20 50 50 10 V0 H10z", 1),
        (SQUARE + " M40 21 H70 V31 H40z", 2),
        (SQUARE + " M20 20 H30 V30 H20z", 0),
        ("M10 10 H50 V50.3 L49.7 50 H50.3 V50 H10z", 0),
    ],
    ids=["square", "bow tie", "curve", "two loops", "hole", "too small to see"],
)
def test_crossings_of_an_outline_are_counted(data: str, count: int) -> None:
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="80" height="60"><path d="{SQUARE}"/><path d="{data}"/></svg>'
    )
    assert self_crossings(read_svg(text).scene).tolist() == [0, count]


class _Largest(TorchDispatchMode):
    """Records the number of entries of the largest tensor that an operation returns."""

    entries = 0

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        result = func(*args, **(kwargs or {}))
        for part in result if isinstance(result, tuple | list) else (result,):
            if isinstance(part, torch.Tensor):
                self.entries = max(self.entries, part.numel())
        return result


def test_a_scribble_with_thousands_of_crossings_takes_little_memory() -> None:
    generator = torch.Generator().manual_seed(0)
    curves = "".join(
        "C" + " ".join(f"{v:.2f}" for v in points) for points in torch.rand(120, 6, generator=generator) * 60
    )
    scene = read_svg(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64"><path d="M1 1{curves}z"/></svg>'
    ).scene
    with _Largest() as largest:
        (count,) = self_crossings(scene).tolist()
    assert count > 5000
    assert largest.entries < 1e7
