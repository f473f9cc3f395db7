"""Stroked circles have the radius that they were drawn with, whether a picture has exact areas or resvg's chords."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from warpvec.api import vectorize
from warpvec.svg.measure import draw

SIDE, RADIUS, WIDTH = 400, 150.0, 24.0

RING = (
    f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}"><rect width="100%" height="100%" '
    f'fill="#fff"/><circle cx="200" cy="200" r="{RADIUS}" fill="none" stroke="#000" stroke-width="{WIDTH}"/></svg>'
)


def ring_of_areas() -> NDArray[np.uint8]:
    """Return the ring with the share of each pixel that it covers, row by row of 64 in a pixel."""
    y = (np.arange(64 * SIDE) + 0.5) / 64.0 - 200.0
    x = np.arange(SIDE)

    def disc(radius: float) -> NDArray[np.float64]:
        half = np.sqrt(np.maximum(radius**2 - y**2, 0.0))[:, None]
        share = np.clip(np.minimum(200.0 + half, x + 1.0) - np.maximum(200.0 - half, x), 0.0, 1.0)
        return np.asarray(share.reshape(SIDE, 64, SIDE).mean(1))

    ring = disc(RADIUS + WIDTH / 2.0) - disc(RADIUS - WIDTH / 2.0)
    return np.repeat(np.rint(255.0 * (1.0 - ring)).astype(np.uint8)[..., None], 3, 2)


@pytest.mark.slow
@pytest.mark.parametrize("make", [lambda: draw(RING, SIDE, SIDE)[..., :3], ring_of_areas], ids=["resvg", "areas"])
def test_a_ring_has_the_radius_and_the_width_that_it_was_drawn_with(make) -> None:
    scene = vectorize(make(), strokes="auto").scene
    assert scene.forms is not None and scene.strokes is not None
    radius, width = float(scene.forms.parameters[0, 2]), float(scene.strokes.width[0])
    assert abs(radius - RADIUS) <= 0.03 and abs(width - WIDTH) <= 0.03  # the file states hundredths


def test_a_ring_that_is_fitted_in_a_smaller_copy_is_drawn() -> None:
    assert vectorize(draw(RING, SIDE, SIDE)[..., :3], mode="flat", fit_size=200, grid="off").scene.forms is not None
