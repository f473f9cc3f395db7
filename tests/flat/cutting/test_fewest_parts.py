"""Test that outlines of cut drawings have few parts: one for what one curve or line follows, and corners stay."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.arrays import Floats
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.cut_edges import between, line_cubics
from warpvec.flat.cutting.fewest_parts import CurvePart, fewest_parts
from warpvec.watch.watch import Watch

CURVE = np.array([[2.0, 3.0], [20.0, 1.0], [31.0, 12.0], [28.0, 30.0]])


def _lines(*places: tuple[float, float]) -> list[CurvePart]:
    return [CurvePart(cubic, True) for cubic in line_cubics(np.array(places[:-1]), np.array(places[1:]))]


def test_parts_of_one_curve_become_it() -> None:
    shares = np.array([(0.0, 0.4), (0.4, 0.41), (0.41, 1.0)])
    cubics = between(np.repeat(CURVE[None], len(shares), 0), *shares.T)
    parts = [CurvePart(cubic, False) for cubic in cubics]
    ((found,),) = fewest_parts([parts])
    assert not found.is_line
    assert np.abs(found.cubic - CURVE).max() < 0.1
    middle = np.array([1.0, 3.0, 3.0, 1.0]) / 8.0
    assert np.abs(middle @ found.cubic - middle @ CURVE).max() < 0.01


def test_a_step_within_the_tolerance_goes_and_a_corner_stays() -> None:
    step = CUTTING.joined_error / 2
    flat, corner = _lines((0, 0), (9, 0), (9, step), (20, step)), _lines((0, 0), (9, 0), (9, 9))
    found = fewest_parts([flat, corner, flat[:1]])
    assert [len(chain) for chain in found] == [1, 2, 1]
    assert found[0][0].is_line and found[0][0].cubic[[0, 3]].tolist() == [[0.0, 0.0], [20.0, step]]


def test_lines_never_become_a_curve() -> None:
    angle = np.linspace(0.0, 1.0, 20)
    round_corner: Floats = 10.0 * np.stack([np.cos(angle), np.sin(angle)], 1)
    assert all(part.is_line for part in fewest_parts([_lines(*map(tuple, round_corner))])[0])


@pytest.mark.parametrize("count", [0, 1])
def test_chains_of_no_part_or_one_stay(count: int) -> None:
    chains = [_lines((0, 0), (1, 0))[:count]]
    assert fewest_parts(chains) == chains


def test_nothing_is_joined_once_the_time_is_over() -> None:
    chains = [_lines((0, 0), (9, 0), (20, 0))]
    assert fewest_parts(chains, Watch(time_budget=1e-9)) == chains
