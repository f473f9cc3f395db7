"""Tests of warpvec.flat.curves.straight_runs: runs of outlines between pixels that are straight on purpose."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.curves.outline_nodes import sample_loops
from warpvec.flat.curves.straight_runs import straight_counts, straight_samples
from warpvec.flat.staircases import staircase_outlines

LENGTH_MIN = np.array([16.0])


def _outline(ink: Floats) -> Floats:
    (outline,) = staircase_outlines(ink)
    return outline


def test_long_sides_of_a_bar_are_straight_and_its_ends_are_not() -> None:
    ink = np.zeros((60, 20))
    ink[5:55, 6:14] = 1.0
    samples = sample_loops([_outline(ink)])
    chosen = samples.xy[straight_samples(samples, LENGTH_MIN)]
    assert set(np.rint(chosen[:, 0]).tolist()) == {6.0, 14.0}
    assert len(chosen) * samples.step[0] > 90.0


def test_top_of_a_large_circle_is_no_straight_run() -> None:
    y, x = np.mgrid[:300, :300] + 0.5
    samples = sample_loops([_outline((np.hypot(x - 150.0, y - 150.0) < 140.0).astype(np.float64))])
    assert not straight_samples(samples, LENGTH_MIN).any()


def test_straight_samples_are_counted_around_a_loop() -> None:
    samples = sample_loops([np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])])
    mask = np.arange(len(samples.xy)) < 5
    loop, start, reach = np.array([0, 0]), np.array([2, len(mask) - 4]), np.array([10, 6])
    assert straight_counts(mask, samples, loop, start, reach).tolist() == [3, 2]


def test_steps_of_a_slanting_bar_are_no_straight_runs() -> None:
    y, x = np.mgrid[:40, :200] + 0.5
    bar = (np.abs(y - 20.0 - (x - 100.0) / 60.0) < 3.0) & (np.abs(x - 100.0) < 90.0)
    samples = sample_loops([_outline(bar.astype(np.float64))])
    assert not straight_samples(samples, LENGTH_MIN).any()
