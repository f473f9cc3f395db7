"""Arcs in path data: they stand for cubics at ticks, as other programs draw them, and are found again."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from warpvec.drawing.arc_rounding import with_arcs
from warpvec.geometry.circles import circle_points
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.svg.arcs import Arc, arc_of, arc_rows, nearest_arc
from warpvec.svg.measure import draw
from warpvec.svg.path_data import is_own_data, read_loops
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg


def random_arcs(count: int) -> list[tuple[NDArray[np.int64], Arc]]:
    """Return arcs to random places; a fifth are exact halves."""
    random = np.random.default_rng(0)
    found = []
    for number in range(count):
        step = random.integers(300, 5000, 2) * random.choice([-1, 1], 2)
        half = math.hypot(*step.tolist()) / 2
        radius = int(half * (1.0 if number % 5 == 0 else random.uniform(1.01, 1.6)))
        found.append((step, Arc(radius, bool(random.integers(2)) and radius > half, bool(random.integers(2)))))
    return found


def test_cubics_of_an_arc_are_those_that_svgelements_draws() -> None:
    svgelements = pytest.importorskip("svgelements")
    for step, arc in random_arcs(100):
        flags = f"{int(arc.is_large)} {int(arc.is_clockwise)}"
        path = svgelements.Path(f"M0,0A{arc.radius} {arc.radius} 0 {flags} {step[0]} {step[1]}")
        curves = path[1].as_cubic_curves(len(arc_rows(step, arc)))
        ends = np.array([[curve.start.x, curve.start.y] for curve in curves])
        np.testing.assert_allclose(arc_rows(step, arc)[:, 0], ends, atol=1.0)


def test_an_arc_is_found_from_its_cubics_and_another_curve_is_none() -> None:
    for step, arc in random_arcs(300):
        rows = arc_rows(step, arc)
        found = arc_of(rows, step)
        if len(rows) > 1:
            assert found is not None and (arc_rows(step, found) == rows).all()
            rows[1, 1] += 3
            assert arc_of(rows, step) is None


def ring_and_notch() -> Scene:
    """A square with a round hole, a half circle on one side, and a bar of lines."""
    hole = circle_points(torch.tensor([[30.0, 30.0]]), torch.tensor([9.37]), 4)[0].flip(0).roll(1, 0).reshape(4, 3, 2)
    half = circle_points(torch.tensor([[54.0, 30.0]]), torch.tensor([12.0]), 4)[0].reshape(4, 3, 2)[[3, 0]]
    corners = torch.tensor([[54.0, 42.0], [6.0, 42.0], [6.0, 18.0]])
    ends = torch.cat([corners[1:], half[:1, 0]])
    lines = torch.stack([corners, (2 * corners + ends) / 3, (corners + 2 * ends) / 3], 1)
    is_line = torch.tensor([False, False, True, True, True, False, False, False, False])
    structure = Structure.of_loops([[5, 4]], is_line)
    values = (torch.zeros(1, 3), torch.ones(1), torch.zeros(3), torch.zeros(1, dtype=torch.int64), True)
    return Scene(torch.cat([half, lines, hole]), structure, *values)


@pytest.mark.parametrize(("precision", "units"), [(2, 1.0), (3, 1.0), (0, 20.0)])
def test_a_hole_and_a_half_circle_become_arcs_and_are_read_exactly(precision: int, units: float) -> None:
    exact = ring_and_notch().scaled(units)
    scene = with_arcs(round_nodes(exact, precision), precision, units)
    side = round(70 * units)
    text = write_svg(scene, side, side, precision=precision)
    assert text.count(" 0 0 ") == 3  # three half circles
    loaded = read_svg(text)
    assert loaded.precision == precision and torch.equal(loaded.scene.segments, scene.segments)
    assert write_svg(loaded.scene, side, side, precision=precision) == text
    plain = write_svg(exact, side, side, precision=precision)
    difference = draw(text, 560, 560, transparent=True).astype(int) - draw(plain, 560, 560, transparent=True)
    assert np.abs(difference).mean() < 0.1


def test_a_curve_that_misses_a_circle_stays_a_curve() -> None:
    scene = ring_and_notch()
    scene.segments[5:, :, 0] = 30.0 + (scene.segments[5:, :, 0] - 30.0) * 1.01
    scene.segments[:2, 1, 0] += 0.4
    assert " 0 0 " not in write_svg(with_arcs(round_nodes(scene, 2), 2, 1.0), 70, 70)


@pytest.mark.parametrize("data", ["M1 1a0 0 0 0 1 4 4z", "M1 1a5 5 0 1 0 0 0z", "M1 1a.01 3 0 0 1 9 9h1z"])
def test_odd_arcs_are_read_without_a_failure(data: str) -> None:
    assert is_own_data(data)
    (loop,) = read_loops(data, 2)
    assert len(loop.ticks) >= 1


@pytest.mark.parametrize("radius", [20000, 25000, 8530])
def test_of_radii_that_draw_the_same_the_shortest_is_stated(radius: int) -> None:
    """In units of a grid ticks are so fine that rounded cubics may be those of several radii."""
    step = np.array([radius, radius])
    for off in (-1, 0, 1):
        rows = arc_rows(step, Arc(radius + off, False, True))
        arc = nearest_arc(rows.astype(float), step, 9.0)
        assert arc is not None and arc.radius == radius
