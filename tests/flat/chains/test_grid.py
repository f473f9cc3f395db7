"""The grid of a drawing is found by its numbers, and only those that are surely meant to be there are put on it."""

from __future__ import annotations

import numpy as np
import pytest
from chain_pictures import line, quarter

from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.grid import Grid, grid_of, hold_grid
from warpvec.flat.chains.parts import ARC, bulge_of, radius_of
from warpvec.flat.chains.sketch import parted, sketch_of

UNIT = 512 / 24
NATS = 8.5


def rough(units: list[float], spread: float = 0.05) -> np.ndarray:
    noise = np.random.default_rng(0).normal(0.0, spread, len(units))
    return UNIT * np.array(units) + noise


@pytest.mark.parametrize("more", [[], [3.37, 8.81]], ids=["all", "but two"])
def test_a_dozen_rough_numbers_tell_the_grid_of_24(more: list[float]):
    values = rough([2, 3, 4.5, 7, 10, 12, 14.5, 16, 20, 21.5, 22, *more])
    found = grid_of(values, (512, 512), 0.1)

    assert found is not None and found.side == 24
    held = found.held(values) / UNIT
    assert np.allclose(held[:11], [2, 3, 4.5, 7, 10, 12, 14.5, 16, 20, 21.5, 22])
    assert np.isnan(held[11:]).all()


def test_numbers_at_random_have_none():
    count = sum(grid_of(np.random.default_rng(k).uniform(10, 500, 24), (512, 512), 0.1) is not None for k in range(100))
    assert count <= 1


@pytest.mark.parametrize("side", [240, 400, 512])
def test_whole_pixels_are_no_grid(side: int):
    for seed in range(20):
        values = np.random.default_rng(seed).integers(8, side - 8, 20).astype(float)
        assert grid_of(values, (side, side), 0.05) is None


def test_a_number_that_is_said_often_is_one_proof():
    assert grid_of(np.repeat(rough([7]), 12), (512, 512), 0.1) is None


def test_a_few_exact_numbers_among_many_tell_the_grid_and_the_others_stay():
    some = UNIT * np.array([3.0, 12.0, 21.0, 6.0, 18.0, 9.0, 15.0, 4.0, 7.0, 20.0])
    rest = np.random.default_rng(2).uniform(10, 500, 25)
    found = grid_of(np.concatenate([some, rest]), (512, 512), 0.02)
    assert found is not None and found.side == 24
    assert np.isfinite(found.held(some)).all() and np.isnan(found.held(rest)).mean() > 0.8


def test_a_grid_that_is_given_needs_no_proof_and_off_has_none():
    values = rough([2, 3.3])
    given = grid_of(values, (512, 512), 0.1, "24")
    assert given is not None and given.side == 24
    assert grid_of(rough([*range(2, 20)]), (512, 512), 0.1, "off") is None


def test_a_node_between_a_line_and_an_arc_follows_from_the_radius():
    """Along the line it is off by more than what is taken for a multiple by itself."""
    corner = UNIT * np.array([4.0, 20.0])
    curves = np.concatenate(
        [
            line((UNIT * 4, UNIT * 3), (UNIT * 4, UNIT * 18 - 0.6)),
            quarter((UNIT * 4, UNIT * 18 - 0.6), tuple(corner), (UNIT * 6 + 0.6, UNIT * 20)),
            line((UNIT * 6 + 0.6, UNIT * 20), (UNIT * 21, UNIT * 20)),
        ]
    )
    sketch = sketch_of([parted(Chain.of(curves, is_closed=False), 0.1, NATS)], 0.1)
    shares = np.array([0.6, 0.1, 0.1, 0.05, 0.15])
    hold_grid(sketch, Grid(UNIT, 24, shares, 0.25, 50.0))

    (arc,) = sketch.rows_of_kind(ARC)
    numbers = sketch.of(int(arc))
    # Files in units have four decimals.
    assert abs(abs(float(radius_of(numbers[None])[0])) / UNIT - 2.0) < 1e-9
    assert np.allclose(numbers[:4] / UNIT, [4, 18, 6, 20], atol=1e-9)


@pytest.mark.parametrize("bulge", [0.1, -0.5, 1.6])
def test_the_bulge_of_a_radius_is_that_of_the_arc_with_it(bulge: float):
    numbers = np.array([1.0, 2.0, 7.0, 10.0, bulge])
    radius = abs(float(radius_of(numbers[None])[0]))
    assert abs(bulge_of(numbers, radius) - bulge) < 1e-9
    assert abs(bulge_of(numbers, 4.9)) == 1.0  # the chord is 10
    assert bulge_of(np.array([1.0, 2.0, 1.0, 2.0, bulge]), 3.0) == bulge


def test_a_part_in_a_freed_box_leaves_the_grid_and_the_others_stay():
    corners = UNIT * np.array([[2.0, 2.0], [20.0, 2.0], [20.0, 9.0], [2.0, 9.0]]) + 0.04
    curves = np.concatenate([line(a, b) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    top = np.array([[corners[0] - 1.0, corners[1] + 1.0]])
    places = []
    for chain in (Chain.of(curves, True), Chain.of(curves, True).freed_in(top)):
        sketch = sketch_of([parted(chain, 0.05, NATS)], 0.05)
        hold_grid(sketch, Grid(UNIT, 24, np.array([0.9, 0.05, 0.02, 0.02, 0.01]), 0.1, 100.0))
        places.append(np.sort(sketch.numbers.reshape(-1, 2)[:, 1]) / UNIT)
    on_grid, freed = places
    assert np.allclose(on_grid, [2, 2, 9, 9], atol=1e-6)
    assert np.allclose(freed[2:], 9, atol=1e-6) and (freed[:2] > 2.001).all()
