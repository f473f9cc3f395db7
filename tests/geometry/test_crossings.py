"""Counting where an outline crosses itself."""

import tracemalloc

import pytest
import torch

from warpvec.geometry.crossings import overlapping_pairs, self_crossings
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


def test_a_sliver_that_nobody_sees_does_not_count() -> None:
    def count(height: float) -> int:
        low, high = 10 + height, 10 - height
        data = f"M2 {high} L60 {low} V{high} L12 {low} V40 H0 V{high}z"
        text = f'<svg xmlns="http://www.w3.org/2000/svg" width="80" height="60"><path d="{data}"/></svg>'
        return int(self_crossings(read_svg(text).scene))

    assert [count(height) for height in (0.02, 2.0)] == [0, 1]


def test_a_scribble_with_thousands_of_crossings_takes_little_memory() -> None:
    generator = torch.Generator().manual_seed(0)
    curves = "".join(
        "C" + " ".join(f"{v:.2f}" for v in points) for points in torch.rand(120, 6, generator=generator) * 60
    )
    scene = read_svg(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64"><path d="M1 1{curves}z"/></svg>'
    ).scene
    tracemalloc.start()
    (count,) = self_crossings(scene).tolist()
    largest = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count > 5000
    assert largest < 3e8


def test_many_segments_side_by_side_are_few_pairs() -> None:
    angle = torch.linspace(0, 6.2832, 1001)[:-1]
    points = 100 + 90 * torch.stack([angle.cos(), angle.sin()], 1)
    data = "M" + " ".join(f"{x:.2f},{y:.2f}" for x, y in points.tolist()) + "z"
    scene = read_svg(f'<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200"><path d="{data}"/></svg>').scene
    assert int(self_crossings(scene)) == 0
    assert int(overlapping_pairs(scene)) < 30 * 1000
