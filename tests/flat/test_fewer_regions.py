"""Pictures of thousands of regions: the work on them is bounded, and what shows most stays."""

from dataclasses import replace

import numpy as np
import pytest

import warpvec.flat.regions.regions as regions_module
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.fewer_regions import with_fewer_regions
from warpvec.flat.regions.regions import (
    NotFlatArtError,
    Regions,
    find_regions,
    require_few_edges,
)
from warpvec.flat.scene_building import scene_of
from warpvec.flat.simplification.circles import ellipse_of
from warpvec.watch.watch import Watch

OVER = Watch(time_budget=1e-9)
"""A watch whose time is up."""


def squares(may_refuse: bool = False) -> Regions:
    """Return the regions of a white picture with 64 squares of 4 pixels, each darker than the one before it."""
    image = np.ones((DRAWING.small_side, DRAWING.small_side, 3), np.float32)
    for k in range(64):
        y, x = 4 + 15 * (k // 8), 4 + 15 * (k % 8)
        image[y : y + 4, x : x + 4] = 0.7 - 0.01 * k
    return find_regions(image, may_refuse=may_refuse)


def test_the_regions_that_show_most_stay() -> None:
    regions = squares()
    fewer = with_fewer_regions(regions, 9)
    assert len(regions) == 65 and len(fewer) == 9
    assert sorted(np.unique(fewer.label)) == list(range(9)) and fewer.canvas is not None
    assert np.allclose(fewer.paints.color[fewer.canvas], 1.0)
    assert np.delete(fewer.paints.color[:, 0], fewer.canvas).max() < 0.15
    removed, kept = fewer.mixed()[5, 5], fewer.mixed()[110, 110]
    assert np.allclose(removed, 1.0) and kept[0] < 0.1


def test_few_regions_stay_as_they_are() -> None:
    regions = squares()
    assert with_fewer_regions(regions, 65) is regions


def test_tracing_ends_once_the_time_is_over() -> None:
    regions = squares()
    assert len(scene_of(regions)) == 64
    assert len(scene_of(regions, watch=OVER)) == DRAWING.layers_min


def test_a_picture_without_pure_areas_or_with_too_many_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    noise = np.random.default_rng(1).random((64, 64, 3), np.float32)
    with pytest.raises(NotFlatArtError, match="no areas of one colour"):
        find_regions(noise, may_refuse=True)
    assert len(find_regions(noise)) > 0
    monkeypatch.setattr(regions_module, "REGIONS", replace(REGIONS, seeds_max=60))
    with pytest.raises(NotFlatArtError, match="65 separate areas"):
        squares(may_refuse=True)


@pytest.mark.parametrize(("most", "share"), [(4000, 0.2), (2000, 0.4)])
def test_a_picture_with_edges_everywhere_is_refused_if_they_are_very_many(
    monkeypatch: pytest.MonkeyPatch, most: int, share: float
) -> None:
    stripes = find_regions(np.repeat((np.indices((100, 100))[0] // 4 % 2)[..., None], 3, 2).astype(np.float32))
    monkeypatch.setattr(regions_module, "REGIONS", replace(REGIONS, edges_max=most, edges_share_max=share))
    require_few_edges(stripes)
    monkeypatch.setattr(regions_module, "REGIONS", replace(REGIONS, edges_max=2000))
    with pytest.raises(NotFlatArtError, match="2,400 pixels of edges"):
        require_few_edges(stripes)


def test_late_regions_lack_thin_parts() -> None:
    image = np.ones((64, 64, 3), np.float32)
    image[10:50, 30] = 0.0
    late = find_regions(image, watch=OVER)
    assert len(find_regions(image)) == 2
    assert len(late) == 1 and not late.label.any()


def test_late_regions_have_flat_paints() -> None:
    image = np.ones((64, 64, 3), np.float32)
    image[8:56, 8:56] = np.round(np.linspace(40, 200, 48))[:, None] / 255
    assert find_regions(image).paints.kind.any()
    assert not find_regions(image, watch=OVER).paints.kind.any()


def test_an_outline_that_shows_at_one_point_is_no_ellipse() -> None:
    points = np.random.default_rng(1).random((20, 2))
    assert ellipse_of(points, np.eye(20)[3]) is None
