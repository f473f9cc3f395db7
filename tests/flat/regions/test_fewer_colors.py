"""Regions in fewer colours: which colour stays, and which regions become one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from flat_regions import box, regions_of

from warpvec.flat.regions.fewer_colors import flat_colors, with_colors, with_flat_paints, with_palette
from warpvec.geometry.paints.registry import LINEAR

BLUE, NAVY, RED = (0.0, 0.0, 0.9, 1.0), (0.0, 0.0, 0.7, 1.0), (0.9, 0.1, 0.1, 1.0)
WHITE = (1.0, 1.0, 1.0, 1.0)


def _regions():
    shapes = [(box(4, 4, 20, 20), BLUE), (box(20, 4, 28, 20), NAVY), (box(4, 24, 12, 30), RED)]
    return regions_of(shapes, 32, 32, WHITE)


def test_the_two_colours_whose_difference_shows_least_become_that_of_the_larger_area() -> None:
    three = with_colors(_regions(), 3)
    assert len(three) == 3  # the blue and the navy square touch
    colors = {tuple(round(value, 2) for value in color) for color in three.paints.color.tolist()}
    assert colors == {WHITE[:3], BLUE[:3], RED[:3]}
    assert len(np.unique(three.label[5:19, 5:27])) == 1


def test_a_palette_gives_each_region_its_nearest_colour() -> None:
    found = with_palette(_regions(), np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 0.0]]))
    label = found.label
    assert [found.paints.color[label[place]].tolist() for place in ((0, 0), (10, 10), (10, 24), (27, 8))] == [
        [1, 1, 1], [0, 0, 0], [0, 0, 0], [1, 0, 0],
    ]  # fmt: skip


def test_a_ramp_becomes_its_mean_colour() -> None:
    regions = _regions()
    kind, geometry, end_color = (
        regions.paints.kind.copy(),
        regions.paints.geometry.copy(),
        regions.paints.end_color.copy(),
    )
    kind[1], geometry[1], end_color[1] = LINEAR, (4, 0, 20, 0, 0), (0.0, 0.0, 0.1)
    paints = replace(regions.paints, kind=kind, geometry=geometry, end_color=end_color)
    ramp = replace(regions, paints=paints)
    color, area = flat_colors(ramp)
    np.testing.assert_allclose(color[1], [0, 0, 0.5], atol=1e-3)
    assert area[1] == 16 * 16
    flat = with_flat_paints(ramp)
    assert not flat.paints.kind.any() and with_flat_paints(regions) is regions
