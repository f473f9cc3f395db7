"""Discs of a drawing of strokes are dots or circles of its pen; others stay discs."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from stroke_pictures import SIDE, drawn, lines_of, picture_of, stroke

from warpvec.flat.strokes.pen_dots import with_pen_dots
from warpvec.geometry.forms.registry import CIRCLE
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg

LINE = stroke("M20 100H108", 10)


def disc(radius: float, fill: str = "#123") -> str:
    return f'<circle cx="64" cy="40" r="{radius}" fill="{fill}"/>'


def error(scene: Scene, shapes: str) -> float:
    """Return the difference of the file of ``scene`` from a picture, as a root mean square in levels."""
    shown = draw(write_svg(scene, SIDE, SIDE, precision=3), SIDE, SIDE)
    return float(np.sqrt(np.square(shown.astype(float) - 255 * picture_of(shapes)).mean()))


def test_a_disc_as_wide_as_the_pen_is_a_dot_of_it() -> None:
    scene = drawn(LINE + disc(5))
    assert len(scene) == 1 and lines_of(scene) == 2
    assert error(scene, LINE + disc(5)) < 2.0


def test_a_disc_twice_as_wide_is_a_circle_of_it() -> None:
    scene = drawn(LINE + disc(10))
    assert len(scene) == 2 and scene.strokes is not None and scene.strokes.is_stroked.all()
    assert scene.forms is not None and sorted(scene.forms.kind.tolist())[-1] == CIRCLE
    assert error(scene, LINE + disc(10)) < 2.0


@pytest.mark.parametrize("shape", [disc(8), disc(5, "#e21")], ids=["another width", "another colour"])
def test_other_discs_stay(shape: str) -> None:
    scene = drawn(LINE + shape)
    assert scene.strokes is not None and sorted(scene.strokes.is_stroked.tolist()) == [False, True]
    again = with_pen_dots(scene)
    assert torch.equal(again.segments, scene.segments)


def test_a_dot_on_another_shape_stays_above_it() -> None:
    """The line lies below that shape, so the dot may not go into its path."""
    shapes = stroke("M20 40H108", 10) + '<rect x="44" y="20" width="40" height="40" fill="#7cf"/>' + disc(5)
    scene = drawn(shapes)
    assert error(scene, shapes) < 2.0
    assert scene.strokes is not None and int(scene.strokes.is_stroked.sum()) == 2 and not scene.strokes.is_stroked[1]
