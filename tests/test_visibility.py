"""Paths of which nothing is to be seen: which go, and how many drawings it takes to know."""

from __future__ import annotations

import pytest
import torch

from warpvec.scene import Scene, circle_points
from warpvec.visibility import DRAWINGS_MAX, shown_areas, without_invisible


def circles(count: int) -> Scene:
    center = torch.full((count, 2), 16.0)
    points = circle_points(center, torch.full((count,), 5.0), 4)
    color, opacity, generation = torch.rand(count, 3), torch.ones(count), torch.zeros(count).long()
    return Scene(points, color, opacity, torch.ones(3), generation)


def test_shown_area_is_what_is_not_hidden() -> None:
    """Of two equal discs the upper one shows all of its area, the lower one what shines through along the edge."""
    shown = shown_areas(circles(2), 32, 32)
    assert abs(float(shown[1]) - 25 * torch.pi) < 0.1
    assert 0.0 < float(shown[0]) < 0.1 * 25 * torch.pi


def test_what_changes_no_pixel_goes() -> None:
    """The judge sees the paths above row 3 alone."""
    scene = circles(16)
    shown = torch.arange(16) * 0.05
    kept = without_invisible(scene, shown, lambda some: bytes(str(some.color.tolist()[-12:]), "ascii"))
    assert torch.equal(kept.color, scene.color[4:])


def test_the_search_ends() -> None:
    """Where every candidate changes a pixel, none goes, and not each is drawn."""
    scene, drawings = circles(1000), []

    def draw(some: Scene) -> bytes:
        drawings.append(len(some))
        return len(some).to_bytes(4, "big")

    assert len(without_invisible(scene, torch.linspace(0.0, 2.0, 1000), draw)) == 1000
    assert drawings[:2] == [1000, 500]
    assert len(drawings) == 1 + DRAWINGS_MAX


@pytest.mark.parametrize(("byte_count", "count"), [(36_000_000, 2), (192_000_000, 1)])
def test_large_photos_are_drawn_less_often(byte_count: int, count: int) -> None:
    """A photo of 12 megapixels twice, one of 64 once, as a whole."""
    drawings = []

    def draw(some: Scene) -> bytes:
        drawings.append(len(some))
        return bytes(byte_count)

    without_invisible(circles(9), torch.zeros(9), draw)
    assert len(drawings) == count


def test_what_shows_is_not_tried() -> None:
    scene = circles(3)
    assert without_invisible(scene, torch.tensor([5.0, 1.0, 2.0]), lambda _: b"never drawn") is scene
