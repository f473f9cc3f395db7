"""Round dots of a few pixels: each is found once, at its place, and other marks are not."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.arrays import Floats
from warpvec.flat.thin_lines.dots import without_dots
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw

SIDE = 120
WHITE, INK = np.full(3, 255.0), np.array([30.0, 60.0, 200.0])


def _picture(elements: str) -> Floats:
    size = f'width="{SIDE}" height="{SIDE}"'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><rect {size} fill="#fff"/>{elements}</svg>'
    return draw(text, SIDE, SIDE).astype(np.float64)


def _without(elements: str, count_max: int = 512) -> tuple[Floats, Scene]:
    return without_dots(_picture(f'<g fill="rgb(30,60,200)">{elements}</g>'), WHITE[None], INK[None], count_max)


def _dots(width: float) -> tuple[Floats, str]:
    """Return the centres [100, 2] of dots of a ``width``, each at another place in its pixel, and their elements."""
    places = np.random.default_rng(5).uniform(0.0, 1.0, (100, 2))
    centers = 10.0 + 11.0 * np.indices((10, 10)).reshape(2, -1).T + places
    return centers, "".join(f'<circle cx="{x:.3f}" cy="{y:.3f}" r="{width / 2}"/>' for x, y in centers)


@pytest.mark.parametrize("width", [1.2, 1.5, 2.0, 3.0])
def test_no_dot_is_lost_and_each_has_its_place_width_and_colour(width: float) -> None:
    centers, elements = _dots(width)
    rest, found = _without(elements)
    assert found.forms is not None
    assert len(found) == len(centers)
    x_y_radius = found.forms.parameters[:, :3].double().numpy()
    away = np.linalg.norm(x_y_radius[:, None, :2] - centers, axis=2).min(1)
    assert away.max() < 0.15
    assert 2.0 * x_y_radius[:, 2] == pytest.approx(np.full(len(centers), width), abs=0.16)
    assert np.unique((255.0 * found.color.double().numpy()).round(), axis=0).tolist() == [INK.tolist()]
    assert np.abs(rest - WHITE).max() < 5.0


def test_wide_dots_are_left_to_their_outlines_unless_they_are_too_many() -> None:
    assert len(_without(_dots(7.0)[1])[1]) == 0
    assert len(_without(_dots(7.0)[1], count_max=99)[1]) == 100


@pytest.mark.parametrize(
    "mark",
    [
        '<rect x="{0}" y="{0}" width="3" height="3"/>',
        '<rect x="{0}.3" y="{0}.4" width="4.5" height="2"/>',
        '<path d="M{0} {0}l4 4" stroke="rgb(30,60,200)" stroke-width="1.5"/>',
        '<circle cx="{0}" cy="{0}" r="2.5" fill="none" stroke="rgb(30,60,200)"/>',
    ],
)
def test_squares_lines_and_rings_are_no_dots(mark: str) -> None:
    assert len(_without("".join(mark.format(10 + 12 * k) for k in range(9)))[1]) == 0
