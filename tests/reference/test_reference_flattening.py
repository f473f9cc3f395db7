"""The reference's polygons against closed forms: positions of the vertices, and the area of the curve."""

from __future__ import annotations

import pytest
import torch
from reference_cases import EXACT, polygon_of, shoelace
from scenes import random_scene
from torch import Tensor

from reference.flattening import flatten


def test_flatten_meets_the_anchors_and_the_middle_of_each_segment() -> None:
    path = random_scene(0, 1, 20, 30).points[0]
    polygon = flatten(path[None], torch.tensor([[2, 1, 4, 2]]))[0]
    assert polygon.shape == (9, 2)
    torch.testing.assert_close(polygon[[0, 2, 3, 7]], path[::3])
    # B(1/2) - B''(1/2) / 24, with B''(1/2) = 3 (P0 - P1 - P2 + P3).
    torch.testing.assert_close(polygon[1], (path[0] + 3 * path[1] + 3 * path[2] + path[3]) / 8 - bow(path[:4]) / 8)
    torch.testing.assert_close(
        polygon[8], (path[9] + 3 * path[10] + 3 * path[11] + path[0]) / 8 - bow(path[[9, 10, 11, 0]]) / 8
    )


def bow(control: Tensor) -> Tensor:
    return control[0] - control[1] - control[2] + control[3]


def test_flatten_agrees_with_de_casteljau() -> None:
    path = random_scene(1, 1, 20, 30, segment_count=3).points[0]
    polygon = polygon_of(path, 5)
    control = path[[6, 7, 8, 0]]
    while len(control) > 3:
        control = torch.lerp(control[:-1], control[1:], 3 / 5)
    bend = 6 * torch.lerp(path[6] - 2 * path[7] + path[8], path[7] - 2 * path[8] + path[0], 3 / 5)
    while len(control) > 1:
        control = torch.lerp(control[:-1], control[1:], 3 / 5)
    torch.testing.assert_close(polygon[13], control[0] - bend / (12 * 20), rtol=0, atol=EXACT)


@pytest.mark.parametrize("chord_count", [8, 16, 32])
def test_flatten_keeps_the_area_of_the_curve(chord_count: int) -> None:
    # Chords between points of the curve have an area error of O(1 / n^2): ten times the bound at 16 chords.
    path = torch.tensor([[2.0, 3.0], [9.0, -4.0], [21.0, 2.0], [18.0, 9.0], [14.0, 17.0], [3.0, 15.0]]).double()
    area = sum(cubic_area(path[[3 * s, 3 * s + 1, 3 * s + 2, (3 * s + 3) % 6]]) for s in (0, 1))
    assert abs(shoelace(polygon_of(path, chord_count)) - area) <= 120 / chord_count**3


def cubic_area(control: Tensor) -> Tensor:
    """Return the signed area between a cubic and the origin, integrated exactly by five Gauss points."""
    t = 0.5 + 0.5 * torch.tensor([-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683, 0.906179845938664])
    weight = 0.5 * torch.tensor(
        [0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366, 0.236926885056189]
    )
    t, weight = t.double()[:, None], weight.double()
    u = 1 - t
    point = u**3 * control[0] + 3 * u**2 * t * control[1] + 3 * u * t**2 * control[2] + t**3 * control[3]
    a, b, c = control.diff(dim=0)
    slope = 3 * (u**2 * a + 2 * u * t * b + t**2 * c)
    return 0.5 * (weight * (point[:, 0] * slope[:, 1] - point[:, 1] * slope[:, 0])).sum()
