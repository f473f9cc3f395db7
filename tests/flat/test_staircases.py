"""Tests of warpvec.flat.staircases: pictures of two levels."""

from __future__ import annotations

import numpy as np

from warpvec.flat.curves.contours import signed_area
from warpvec.flat.staircases import square_corners, staircase_outlines

STEM = np.zeros((20, 20), bool)
STEM[4:16, 6:8] = True

SLOPE = np.add.outer(np.arange(40), np.arange(40) // 6) < 20
"""Ink above an edge that falls by a pixel every six."""


def test_outline_of_a_stem_of_two_pixels_has_its_corners() -> None:
    (outline,) = staircase_outlines(STEM.astype(np.float64))
    points = {tuple(point) for point in outline.tolist()}
    assert points >= {(6.0, 4.0), (8.0, 4.0), (8.0, 16.0), (6.0, 16.0)}


def test_oblique_line_of_one_pixel_stays_one_line() -> None:
    column = np.arange(2, 38)
    row = np.concatenate([2 + np.arange(12) // 3, 6 + np.arange(24)])  # runs of three pixels, then single ones
    line = np.zeros((40, 40))
    line[row, column] = 1.0
    for picture in (line, 1.0 - line):  # black on white, and white on black
        areas = sorted(abs(signed_area(outline)) for outline in staircase_outlines(picture))
        assert len(areas) == (1 if picture is line else 2)
        assert len(column) < areas[0] < 1.4 * len(column)


def test_steps_of_a_slanted_edge_are_no_corners() -> None:
    assert square_corners(STEM).sum() == 4
    rows, columns = np.nonzero(square_corners(SLOPE))
    assert all(row in (0, 40) or column in (0, 40) for row, column in zip(rows, columns, strict=True))
