"""Outlines that cross themselves or each other, made simple, against what shapely fills and refuses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import torch

pytest.importorskip("shapely")

import shapely
from PIL import Image, ImageDraw

import warpvec
from warpvec.flat.cutting.simple_outlines import with_simple_outlines
from warpvec.geometry.bezier import bernstein, whole_curves
from warpvec.geometry.loops import Outline, make_scene
from warpvec.geometry.meetings import meeting_rows
from warpvec.geometry.scene import Scene
from warpvec.svg.read import read_svg

TICK = 0.01
SQUARE = [(0, 0), (20, 0), (20, 20), (0, 20)]


def _polygons(*loops: list[tuple[float, float]]) -> Scene:
    """Return a scene of one path of polygons."""
    points = np.concatenate([np.repeat(np.array(loop, np.float64), 3, 0) for loop in loops])
    counts = tuple(map(len, loops))
    return make_scene([Outline(points, (0.0, 0.0, 0.0), 1.0, 0, counts, np.ones(sum(counts), bool))], None)


def _curved(*rows: tuple[float, ...]) -> Scene:
    """Return a scene of one loop. Each row of a cubic has its anchor and both handles."""
    return make_scene([Outline(np.array(rows, np.float64).reshape(-1, 2), (0.0, 0.0, 0.0), 1.0, 0)], None)


def _loops(scene: Scene, steps: int = 24) -> list[list[shapely.LinearRing]]:
    """Return the flattened loops of each path."""
    weights = bernstein(3, torch.arange(steps, dtype=torch.float64) / steps)
    points = (weights @ whole_curves(scene).double()).numpy()
    points[scene.structure.lines.numpy(), 1:] = points[scene.structure.lines.numpy(), :1]
    first = scene.structure.loop_first_segment.tolist()
    rings = [shapely.LinearRing(shapely.remove_repeated_points(shapely.LineString(points[a:b].reshape(-1, 2))).coords)
             for a, b in pairwise(first)]  # fmt: skip
    return [rings[a:b] for a, b in pairwise(scene.structure.path_first_loop.tolist())]


def _filled(loops: list[shapely.LinearRing]) -> shapely.Geometry:
    """Return what ``loops`` fill by the non-zero rule."""
    faces = list(shapely.polygonize([shapely.union_all(loops)]).geoms)
    return shapely.union_all([face for face in faces if _winding(loops, face.representative_point()) != 0])


def _winding(loops: list[shapely.LinearRing], place: shapely.Point) -> int:
    total = 0.0
    for loop in loops:
        away = shapely.get_coordinates(loop) @ np.array([1, 1j]) - complex(place.x, place.y)
        total += np.angle(away[1:] / away[:-1]).sum()
    return round(total / (2 * np.pi))


def _without_strokes(scene: Scene) -> Scene:
    """Return the filled paths of a scene: lines are open, and have no area."""
    return scene if scene.strokes is None else scene.select(~scene.strokes.is_stroked)


def _assert_simple(scene: Scene) -> None:
    for loops in _loops(scene):
        areas = [shapely.Polygon(loop) for loop in loops]
        assert all(area.is_valid for area in areas)
        assert not any(one.overlaps(two) for k, one in enumerate(areas) for two in areas[:k])


HARD = {
    "eight": _polygons([(0, 0), (10, 10), (10, 0), (0, 10)]),
    "star": _polygons([(10, 0), (16, 18), (0, 7), (20, 7), (4, 18)]),
    "holes that cross": _polygons(SQUARE, [(4, 4), (4, 12), (12, 12), (12, 4)], [(8, 8), (8, 16), (16, 16), (16, 8)]),
    "hole in what is wound twice": _polygons(
        SQUARE, [(10, 5), (30, 5), (30, 15), (10, 15)], [(12, 8), (12, 12), (16, 12), (16, 8)]
    ),
    "touches itself at a node": _polygons([(0, 0), (10, 10), (20, 0), (20, 20), (10, 10), (0, 20)]),
    "touches itself at a side": _polygons([(0, 0), (20, 0), (20, 20), (10, 0), (0, 20)]),
    "hair": _polygons([(0, 0), (10, 0), (25, 0), (10, 0), (10, 10), (0, 10)]),
    "loops along each other": _polygons(SQUARE, [(20, 5), (30, 5), (30, 15), (20, 15)]),
    "curve that passes its own end": _curved((0, 0, 20, 0, 20, 10), (10, -2, 5, 25, 0, 25)),
    "curve with a loop": _curved((0, 0, 30, 20, -10, 20), (20, 0, 20, -10, 0, -10)),
    "curves that turn back along each other": _curved(
        (0, 0, 5, 5, 10, 9), (20, 20, 10, 9.01, 5, 5.01), (0.5, 0.5, -5, 3, -5, -3)
    ),
}


@pytest.mark.parametrize("name", HARD)
def test_a_simple_path_fills_the_same(name: str) -> None:
    scene = HARD[name]
    assert meeting_rows(scene).any()
    simple = with_simple_outlines(scene, (TICK, TICK))
    assert not meeting_rows(simple).any()
    _assert_simple(simple)
    before, after = _filled(_loops(scene, 200)[0]), _filled(_loops(simple, 200)[0])
    assert before.symmetric_difference(after).area < TICK * before.length
    ticks = simple.segments[:, 0] / TICK
    torch.testing.assert_close(ticks, ticks.round(), atol=0.01, rtol=0.0)


def test_curves_that_nothing_crosses_stay_to_the_last_bit() -> None:
    bow = [(0, 0, 5, -5, 15, -5), (20, 0, 10, 10, 5, 15), (20, 20, 15, 25, 5, 25), (0, 20, 5, 15, 10, 10)]
    ring = [(50, 0, 60, 0, 60, 10), (50, 10, 40, 10, 40, 0)]
    both = np.array([*bow, *ring], np.float64).reshape(-1, 2)
    scene = make_scene([Outline(both, (0.0, 0.0, 0.0), 1.0, 0, (4, 2))], None)
    simple = with_simple_outlines(scene, (TICK, TICK))
    kept = {tuple(row) for row in whole_curves(simple).reshape(-1, 8).tolist()}
    stays = whole_curves(scene)[[0, 2, 4, 5]]
    assert all(tuple(row) in kept or tuple(row[::-1]) in kept for row in stays.reshape(-1, 8).tolist())


@pytest.mark.parametrize("seed", range(6))
def test_scribbles_become_simple(seed: int) -> None:
    points = np.random.default_rng(seed).integers(0, 3000, (45, 2)) * TICK
    scene = make_scene([Outline(points, (0.0, 0.0, 0.0), 1.0, 0, (9, 6))], None)
    simple = with_simple_outlines(scene, (TICK, TICK))
    assert not meeting_rows(simple).any()
    _assert_simple(simple)
    before, after = _filled(_loops(scene, 200)[0]), _filled(_loops(simple, 200)[0])
    assert before.symmetric_difference(after).area < 0.01 * before.area  # crumbs


def test_a_star_of_thin_points_has_nothing_that_meets() -> None:
    angles = np.linspace(0, 2 * np.pi, 25)[:-1]
    radii = np.where(np.arange(24) % 2, 1.0, 40.0)
    star = np.stack([50 + radii * np.cos(angles), 50 + radii * np.sin(angles)], 1)
    assert not meeting_rows(_polygons([(x, y) for x, y in star.tolist()])).any()


@pytest.mark.parametrize("options", [{}, {"cutout": True, "minify": True}, {"mode": "mono"}])
def test_drawings_are_simple(options: dict[str, object]) -> None:
    picture = Image.new("RGB", (160, 120), "white")
    draw = ImageDraw.Draw(picture)
    for k in range(9):  # thin wedges and rings that nearly touch
        draw.line([(5, 5 + 6 * k), (150, 60 + k)], "black", 1 + k % 2)
        draw.ellipse([10 + 14 * k, 70, 24 + 14 * k, 84], outline="black", width=1)
        draw.polygon([(10 + 15 * k, 115), (17 + 15 * k, 95), (24 + 15 * k, 115)], "#205080")
    given = {"mode": "flat", **options}
    drawn = warpvec.vectorize(picture.resize((120, 90), Image.Resampling.BICUBIC), **given)
    filled = _without_strokes(read_svg(drawn.svg()).scene)
    assert len(filled)
    _assert_simple(filled)
