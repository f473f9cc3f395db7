"""Dashed lines in files: what is written is read back, and nothing else is taken for one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
import torch

from warpvec.drawing.dash_rounding import with_dashes
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.strokes import Strokes
from warpvec.geometry.structure import Structure
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.sanitize import sanitize
from warpvec.svg.write import write_svg


def _dashed(start: tuple[float, float], angle: float, lengths: Sequence[float], whole: float) -> Scene:
    """Return a scene of one stroke with a loop for each dash of a line of a ``whole`` length."""
    way, at, found = np.array([math.cos(angle), math.sin(angle)]), 0.0, []
    for k in range(1000):
        length = lengths[k % len(lengths)]
        if at < whole and k % 2 == 0:
            found.append([at, min(at + length, whole)])
        at += length
    ends = torch.from_numpy(start + np.array(found)[..., None] * way)
    rows = ends.reshape(-1, 1, 2).repeat(1, 3, 1)
    structure = Structure.of_loops(
        [[2] * len(found)], torch.ones(len(rows), dtype=torch.bool), torch.ones(len(found), dtype=torch.bool)
    )
    color, one = torch.tensor([[0.2, 0.4, 0.6]]), torch.ones(1)
    strokes = Strokes.none(color)
    strokes = Strokes(one * 2.0, strokes.cap, strokes.join, strokes.miter_limit)
    return Scene(
        straightened(rows.float(), structure), structure, color=color, opacity=one, background=torch.ones(3),
        generation=torch.zeros(1, dtype=torch.int64), strokes=strokes,
    )  # fmt: skip


@pytest.mark.parametrize("lengths", [(4.0, 3.0), (7.37, 2.918), (9.0, 3.0, 2.0, 3.0), (0.5, 3.25)])
@pytest.mark.parametrize("angle", [0.0, math.pi / 2.0, 0.4, 2.2, 4.0])
@pytest.mark.parametrize("whole", [100.0, 88.3])
def test_a_dashed_line_is_one_line_in_the_file_and_reads_back(
    lengths: Sequence[float], angle: float, whole: float
) -> None:
    scene = with_dashes(_dashed((130.25, 120.5), angle, lengths, whole), 2, 1.0)
    text, plain = write_svg(scene, 260, 260, has_dashes=True), write_svg(scene, 260, 260)
    assert text.count("stroke-dasharray") == 1
    assert len(text) < len(plain)
    assert np.abs(draw(text, 260, 260).astype(int) - draw(plain, 260, 260).astype(int)).max() <= 24
    loaded = read_svg(text)
    assert loaded.precision == 2
    again = loaded.scene
    assert write_svg(again, 260, 260) == plain
    assert write_svg(again, 260, 260, has_dashes=True) == text
    data = plain.partition(' d="')[2].partition('"')[0]
    assert f'stroke-dasharray="none" d="{data}"' in sanitize(text)[1]


def test_lines_that_are_not_even_stay_lines() -> None:
    scene = _dashed((10.0, 20.0), 0.3, (4.0, 3.0, 4.0, 5.5, 4.0, 2.0), 100.0)
    moved = with_dashes(scene, 2, 1.0)
    assert torch.equal(moved.segments, scene.segments)
    assert "stroke-dasharray" not in write_svg(moved, 120, 120, has_dashes=True)
