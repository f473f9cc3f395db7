"""Gradients of known direction and stops, and bands of what no gradient shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flat_pictures import opaque

from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.banding import band_numbers, split_into_bands
from warpvec.flat.regions.noise import measure_tolerances
from warpvec.flat.regions.paint_fitting import fit_areas, fit_paints
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.ramp_directions import binned, block_slopes, directions_of, refined
from warpvec.flat.regions.ramp_fitting import fit_ramp, ramp_along
from warpvec.flat.regions.ramp_refitting import refitted
from warpvec.geometry.paints.registry import ELLIPTIC, FLAT, LINEAR, RADIAL

SIDE = 40
EVERY = slice(None)


def _points() -> np.ndarray:
    """Return the centres x, y of a square of pixels, row by row."""
    y, x = np.indices((SIDE, SIDE)).reshape(2, -1) + 0.5
    return np.stack([x, y], 1)


def _blend(part: np.ndarray, *stops: tuple[float, float, float]) -> np.ndarray:
    """Return the colours [N, 3] at places ``part`` [N] between even stops in [0, 1]."""
    places, colors = np.linspace(0, 1, len(stops)), np.array(stops)
    return np.stack([np.interp(part, places, column) for column in colors.T], 1)


DARK, LIGHT = (0.1, 0.2, 0.4), (0.9, 0.6, 0.5)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 90.0, 135.0])
def test_the_direction_of_a_linear_ramp_is_found(degrees: float) -> None:
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    points = _points()
    colors = _blend((points - points.mean(0)) @ along / 60 + 0.5, DARK, LIGHT)
    found = refined(directions_of(points, colors)[0], points, colors)
    assert found.kind == LINEAR
    assert abs(float(found.along @ along)) == pytest.approx(1.0, abs=1e-6)


def test_the_centre_of_a_radial_ramp_is_found() -> None:
    points = _points()
    colors = _blend(np.hypot(points[:, 0] - 15.0, points[:, 1] - 22.0) / 40, LIGHT, DARK)
    linear, radial, elliptic = directions_of(points, colors)
    assert (linear.kind, radial.kind, elliptic.kind) == (LINEAR, RADIAL, ELLIPTIC)
    off = replace(radial, origin=radial.origin + np.array([1.5, -1.0]))
    np.testing.assert_allclose(refined(off, points, colors).origin, [15.0, 22.0], atol=0.05)


@pytest.mark.parametrize(("degrees", "ratio"), [(0.0, 2.0), (35.0, 1.5), (80.0, 4.0), (120.0, 0.3)])
def test_the_ellipse_of_a_ramp_is_found(degrees: float, ratio: float) -> None:
    points, center = _points(), np.array([17.0, 24.0])
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    across = np.array([-along[1], along[0]])
    want = np.hypot((points - center) @ along / 20, (points - center) @ across / 20 * ratio)
    colors = _blend(want, LIGHT, DARK, LIGHT)
    ramp = fit_ramp(points, colors, 0.8 / 255, EVERY)
    assert ramp is not None and ramp.direction.kind == ELLIPTIC
    paint = ramp.paint(1.0)
    np.testing.assert_allclose(paint.geometry[0, :2], center, atol=0.1)
    radii = sorted([float(np.hypot(*paint.geometry[0, 2:4])), float(paint.geometry[0, 4])])
    assert max(radii) / min(radii) == pytest.approx(max(ratio, 1 / ratio), rel=0.02)
    x, y = points.astype(np.float32).T
    assert np.abs(paint.at(np.zeros(len(x), np.int32), x, y)[:, :3] - colors).mean() < 1 / 255


def test_slopes_of_blocks_are_those_of_a_plane() -> None:
    points = _points()
    centers, slopes = block_slopes(points, (0.01 * points[:, :1] - 0.02 * points[:, 1:]))
    assert len(centers) > 50
    np.testing.assert_allclose(slopes, np.broadcast_to([0.01, -0.02], slopes.shape), atol=1e-9)


def test_bins_have_means_and_counts() -> None:
    places, means, counts = binned(np.array([0.0, 1.0, 9.0, 10.0]), np.array([[1.0], [3.0], [5.0], [7.0]]), 5)
    assert places.tolist() == [0.5, 9.5] and means[:, 0].tolist() == [2.0, 6.0] and counts.tolist() == [2.0, 2.0]


def test_a_ramp_of_two_stops_has_their_colours() -> None:
    points = _points()
    ramp = fit_ramp(points, _blend(points[:, 0] / SIDE, DARK, LIGHT), 0.8 / 255, EVERY)
    assert ramp is not None and len(ramp.knots) == 2
    paints = ramp.paint(1.0)
    assert paints.kind.tolist() == [LINEAR]
    ends = paints.at(np.zeros(2, np.int32), np.array([0.0, SIDE], np.float32), np.zeros(2, np.float32))[:, :3]
    np.testing.assert_allclose(ends, [DARK, LIGHT], atol=0.02)


def test_a_ramp_of_three_stops_has_the_middle_one() -> None:
    points = _points()
    ramp = fit_ramp(points, _blend(points[:, 1] / SIDE, DARK, LIGHT, DARK), 0.8 / 255, EVERY)
    assert ramp is not None and len(ramp.knots) == 3
    place = ramp.direction.origin + ramp.knots[1] * ramp.direction.along
    assert place[1] == pytest.approx(SIDE / 2, abs=0.3)
    paint = ramp.paint(1.0)
    assert paint.count.tolist() == [3] and paint.offset[0, 1] == pytest.approx(0.5, abs=0.02)
    np.testing.assert_allclose(paint.inner_color[0, 0], LIGHT, atol=0.02)


def test_only_as_many_stops_are_taken_as_the_colours_need() -> None:
    points = _points()
    part = np.hypot(*(points - 20.0).T) / 30
    many = [(0.1, 0.9, 0.2), (0.8, 0.1, 0.3), (0.2, 0.3, 0.9), (0.9, 0.8, 0.1), (0.1, 0.1, 0.1)]
    for stops in (many[:2], many[:3], many):
        ramp = fit_ramp(points, _blend(part, *stops), 0.8 / 255, EVERY)
        assert ramp is not None and ramp.direction.kind == RADIAL
        assert ramp.paint(1.0).count[0] == len(stops)


def test_a_bend_that_hardly_shows_is_a_stop_of_a_large_area_only() -> None:
    points = _points()
    colors = _blend(points[:, 0] / SIDE, (0.2, 0.2, 0.2), (0.3, 0.3, 0.3), (0.4 - 2 / 255, 0.4, 0.4))
    direction = directions_of(points, colors)[0]
    counts = [len(ramp_along(direction, points, colors, 1 / 255, size).knots) for size in (100, 100_000)]
    assert counts == [2, 3]


@pytest.mark.parametrize("degrees", [0.0, 40.0])
def test_the_levels_and_places_of_stops_are_found_in_rounded_pixels(degrees: float) -> None:
    points = _points()
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    levels = np.array([[40, 90, 200], [90, 120, 170], [100, 200, 60]])
    places, stops = points @ along, np.array([8.3, 17.7, 30.2])
    shown = np.stack([np.interp(places, stops, channel) for channel in levels.T], 1)
    rough = fit_ramp(points, np.round(shown) / 255, 0.8 / 255, EVERY)
    assert rough is not None
    ramp = refitted(rough, points, np.round(shown) / 255)
    assert ramp.error < rough.error
    np.testing.assert_array_equal(np.round(255 * ramp.colors, 6), levels if ramp.colors[0, 0] < 0.2 else levels[::-1])
    found = (ramp.direction.origin + ramp.knots[:, None] * ramp.direction.along) @ along
    np.testing.assert_allclose(np.sort(found), stops, atol=0.1)


def test_a_radial_ramp_beats_a_linear_one_only_where_it_is_radial() -> None:
    points = _points()
    radial = fit_ramp(points, _blend(np.hypot(*(points - 20.0).T) / 30, LIGHT, DARK), 0.8 / 255, EVERY)
    linear = fit_ramp(points, _blend(points[:, 0] / SIDE, LIGHT, DARK), 0.8 / 255, EVERY)
    assert radial is not None and radial.direction.kind == RADIAL
    assert linear is not None and linear.direction.kind == LINEAR


def test_noise_is_no_ramp() -> None:
    points = _points()[:400]
    assert fit_ramp(points, 0.5 + 0.05 * np.random.default_rng(0).standard_normal((400, 3)), 0.8 / 255, EVERY) is None


def test_areas_get_their_flat_colour_or_their_ramp() -> None:
    points = _points()
    colors = np.where(points[:, :1] < 20, np.array([[0.2, 0.8, 0.4]]), _blend(points[:, 1] / SIDE, DARK, LIGHT))
    image = opaque(colors.reshape(SIDE, SIDE, 3))
    areas = [np.flatnonzero(points[:, 0] < 20), np.flatnonzero(points[:, 0] > 20)]
    fits = fit_areas(areas, image.reshape(-1, 4), SIDE, measure_tolerances(image))
    np.testing.assert_allclose(fits.values[0], [0.2, 0.8, 0.4, 1.0], atol=1e-6)
    assert list(fits.ramps) == [1]
    assert max(fits.errors) < 1 / 255


@pytest.mark.parametrize(("columns", "kind"), [(8, LINEAR), (2, LINEAR), (1, FLAT)])
def test_a_small_area_has_a_ramp_if_enough_pixels_agree_on_it(columns: int, kind: int) -> None:
    """A liquid in an icon of 32 px shows five rows of a steep ramp."""
    image = np.repeat(np.round(np.linspace(0.3, 0.45, 5) * 255)[:, None] / 255, columns, 1)
    whole = opaque(image)
    fits = fit_areas([np.arange(image.size)], whole.reshape(-1, 4), columns, measure_tolerances(whole))
    assert len(fits.ramps) == (kind == LINEAR)


def test_an_area_of_three_stops_is_one_region_with_one_paint() -> None:
    image = opaque(_blend(_points()[:, 0] / SIDE, DARK, LIGHT, DARK).reshape(SIDE, SIDE, 3))
    paints, labels = fit_paints(image, np.zeros((SIDE, SIDE), np.int32), measure_tolerances(image))
    assert paints.kind.tolist() == [LINEAR] and paints.count.tolist() == [3] and not labels.any()
    x, y = (_points()[:, axis].reshape(SIDE, SIDE).astype(np.float32) for axis in (0, 1))
    assert np.abs(paints.at(labels, x, y) - image).max() < 2 / 255


def test_paints_are_evaluated_between_and_beyond_their_stops() -> None:
    geometry = np.array([[0, 0, 0, 0], [10, 0, 20, 0], [10, 10, 5, 0]], np.float32)
    black, white = np.zeros((3, 3), np.float32), np.ones((3, 3), np.float32)
    paints = Paints(
        black, np.array([1, 1, 0.5], np.float32), np.array([FLAT, LINEAR, RADIAL], np.int32), geometry, white
    )
    index = np.array([0, 1, 1, 1, 2, 2], np.int32)
    x, y = np.array([[3, 15, 0, 30, 10, 12], [3, 7, 0, 0, 10, 11.5]], np.float32)
    values = paints.at(index, x, y)
    np.testing.assert_allclose(values[:, 0], [0, 0.5, 0, 1, 0, 0.25], atol=1e-6)
    assert values[:, 3].tolist() == [1, 1, 1, 1, 0.5, 0.5]


def test_stops_between_the_ends_and_jumps_are_evaluated() -> None:
    values = np.array([[0.0] * 3], np.float32)
    offset, inner = np.ones((1, 8), np.float32), np.zeros((1, 6, 3), np.float32)
    offset[0, :5], inner[0, :3] = [0.2, 0.5, 0.5, 0.75, 1.0], [[0.3] * 3, [0.6] * 3, [0.9] * 3]
    geometry = np.array([[0, 0, 100, 0, 0]], np.float32)
    one = np.array([1], np.float32)
    paints = Paints(values, one, np.array([LINEAR]), geometry, values + 1, np.array([5], np.int32), offset, inner)
    x = np.array([0, 20, 35, 49.99, 50, 62.5, 75, 100, 130], np.float32)
    found = paints.at(np.zeros(len(x), np.int32), x, np.zeros_like(x))[:, 0]
    np.testing.assert_allclose(found, [0, 0, 0.15, 0.3, 0.6, 0.75, 0.9, 1, 1], atol=1e-3)


@pytest.mark.parametrize(("extent", "count"), [(12, 1), (35, 3), (255, 8)])
def test_bands_divide_the_range_of_greys_evenly(extent: int, count: int) -> None:
    """A grey that changes by a level moves by the root of 3 in colour space; a band is at most 24 levels wide there."""
    colors = opaque(np.linspace(0, extent / 255, 400)[None])[0]
    numbers = band_numbers(colors)
    assert numbers.max() + 1 == count
    sizes = np.bincount(numbers)
    assert sizes.max() - sizes.min() <= 2
    assert (np.diff(numbers) >= 0).all() or (np.diff(numbers) <= 0).all()


def test_only_areas_that_no_paint_explains_are_divided() -> None:
    colors = opaque(np.linspace(0, 0.2, 200)[None])[0]
    areas, noise = [np.arange(100), np.arange(100, 200)], 0.01
    limit = REGIONS.band_error_min + noise
    divided = split_into_bands(areas, colors, [0.9 * limit, 1.1 * limit], noise)
    assert divided[0] is areas[0]
    assert len(divided) == 3  # the second area is 44 levels wide
    assert sorted(np.concatenate(divided[1:]).tolist()) == areas[1].tolist()
