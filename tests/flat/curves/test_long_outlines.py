"""Outlines of very many samples are looked at in parts, and more roughly once the time is over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flat_regions import box, coverage

from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves import contours, outline_nodes
from warpvec.flat.curves.contours import contours_of
from warpvec.flat.curves.outline_nodes import find_nodes, roughness, sample_loops


def test_parts_of_an_outline_are_looked_at_as_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    def found() -> list[np.ndarray]:
        loops = contours_of(coverage(box(9.3, 12.7, 71.2, 80.4), 96, 96))
        samples = sample_loops(loops)
        return [*loops, roughness(samples), *vars(find_nodes(samples)).values()]

    whole = found()
    for module in (contours, outline_nodes):
        monkeypatch.setattr(module, "CURVES", replace(CURVES, samples_at_once=50))
    for one, other in zip(whole, found(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_late_corners_are_those_of_a_whole_look_and_a_circle_is_hardly_looked_at(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    samples = sample_loops(contours_of(coverage(box(9.3, 12.7, 71.2, 80.4), 96, 96)))
    corners = [nodes.point[nodes.is_corner] for nodes in (find_nodes(samples), find_nodes(samples, is_late=True))]
    np.testing.assert_array_equal(*corners)
    angle = np.linspace(0.0, 2.0 * np.pi, 600, endpoint=False)
    counts = list[int]()
    side = outline_nodes._side_of

    def counted(xy: np.ndarray, sign: int, gap: int, places: np.ndarray) -> outline_nodes.Side:
        counts.append(len(places))
        return side(xy, sign, gap, places)

    monkeypatch.setattr(outline_nodes, "_side_of", counted)
    find_nodes(sample_loops([100.0 * np.stack([np.cos(angle), np.sin(angle)], 1)]), is_late=True)
    assert sum(counts) == 0
