"""Parts of squares of pixels are outlined exactly, and nothing else is taken for one."""

from __future__ import annotations

import numpy as np
import pytest
from flat_regions import Floats, Mask, Shape, box, disc, regions_of

from warpvec.flat.layers.outlines import Outline, outlines
from warpvec.flat.layers.stacking import StackedLayer, stack
from warpvec.flat.regions.regions import Regions

BLACK, WHITE, RED = (0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 1.0)
MODULE = 4


def code(rows: int = 12) -> Shape:
    """Return a shape of random squares of `MODULE` px, with its corner at (8, 8)."""
    is_dark = np.random.default_rng(3).random((rows, rows)) < 0.5

    def contains(x: Floats, y: Floats) -> Mask:
        column, row = (np.floor((place - 8) / MODULE).astype(int) for place in (x, y))
        is_inside = (row >= 0) & (row < rows) & (column >= 0) & (column < rows)
        return is_inside & is_dark[row.clip(0, rows - 1), column.clip(0, rows - 1)]

    return contains


def outlines_of(regions: Regions, index: int) -> list[Outline]:
    found = [outlines(regions, layer) for layer in stack(regions) if index in layer.members]
    return [outline for each in found for outline in each]


def test_each_side_of_a_code_lies_between_pixels() -> None:
    found = outlines_of(regions_of([(disc(40, 40, 38), WHITE), (code(), BLACK)]), 2)
    assert all(outline.is_exact for outline in found)
    points = np.concatenate([outline.points for outline in found])
    assert (points % MODULE == 0).all()
    sides = np.concatenate([np.roll(outline.points, -1, 0) - outline.points for outline in found])
    assert (np.abs(sides).min(1) == 0).all()


@pytest.mark.parametrize("shape", [disc(40, 40, 20), box(10.5, 10, 60, 40)])
def test_what_has_mixed_pixels_is_no_code(shape: Shape) -> None:
    assert not any(outline.is_exact for outline in outlines_of(regions_of([(shape, BLACK)]), 1))


def test_a_rectangle_goes_on_beneath_what_lies_above_its_side() -> None:
    regions = regions_of([(box(10, 10, 80, 60), RED), (box(70, 20, 90, 50), BLACK)])
    layer = StackedLayer(((1,),), frozenset({2}))
    (found,) = outlines(regions, layer)
    assert not found.is_exact
    assert found.points[:, 0].max() == pytest.approx(80.0, abs=0.5)
