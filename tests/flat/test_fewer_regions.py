"""Pictures of thousands of regions: the work on them is bounded, and what shows most stays."""

from dataclasses import replace

import numpy as np
import pytest
from damage import as_jpeg, drawn, levels_of

import warpvec.flat.regions.regions as regions_module
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.mode_choice import MODE_CHOICE
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.fewer_regions import with_fewer_regions
from warpvec.flat.regions.paint_fitting import flat_paints
from warpvec.flat.regions.regions import (
    NotFlatArtError,
    Regions,
    find_regions,
    require_explained,
    require_explained_parts,
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


def test_regions_explain_a_drawing_as_jpeg_but_no_texture() -> None:
    flat = (levels_of(as_jpeg(drawn(400), 60)) / 255.0).astype(np.float32)
    require_explained(find_regions(flat), flat, MODE_CHOICE.unexplained_max)
    waves = np.sin(np.indices((120, 120)).sum(0) / 3.0) * np.sin(np.indices((120, 120))[0] / 5.0)
    texture = np.repeat(0.5 + 0.25 * waves[..., None], 3, 2).astype(np.float32)
    with pytest.raises(NotFlatArtError, match="plain areas miss it by"):
        require_explained(find_regions(texture), texture, MODE_CHOICE.unexplained_max)
    require_explained_parts(flat, MODE_CHOICE.unexplained_max)
    with pytest.raises(NotFlatArtError, match="plain areas miss it by"):
        require_explained_parts(np.tile(texture, (3, 4, 1)), MODE_CHOICE.unexplained_max)


def test_few_regions_may_leave_more_than_many() -> None:
    row, column = np.indices((64, 64))
    ripple = (np.where((row + column) % 2, 6.0, -6.0) / 255.0).astype(np.float32)[..., None]

    def check(side: int, is_jpeg: bool = False) -> None:
        label = (row // side * (64 // side) + column // side).astype(np.int32)
        values = np.random.default_rng(0).uniform(0.2, 0.8, (label.max() + 1, 4)).astype(np.float32)
        values[:, 3] = 1.0
        found = Regions(label, label, np.ones((64, 64), np.float32), flat_paints(values))
        require_explained(found, found.mixed()[..., :3] + ripple, MODE_CHOICE.unexplained_max, is_jpeg)

    check(32)
    check(12, is_jpeg=True)
    with pytest.raises(NotFlatArtError, match="miss it by 6 levels"):
        check(12)
    with pytest.raises(NotFlatArtError, match="miss it by 6 levels"):
        check(8, is_jpeg=True)
