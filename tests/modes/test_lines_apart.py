"""Straight thin lines are drawn as strokes, and the rest of the picture without them."""

from __future__ import annotations

import numpy as np
import pytest

import warpvec
from warpvec.svg.measure import draw

SIZE = 'width="96" height="80"'
ROWS = "".join(f'<path d="M6 {10.3 + 6 * k}H90" stroke="#334" stroke-width="0.6"/>' for k in range(10))
DISK = '<circle cx="48" cy="40" r="12" fill="#c33"/>'


def _picture(elements: str) -> np.ndarray:
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {SIZE}><rect {SIZE} fill="#fff"/>{elements}</svg>'
    return (draw(text, 96, 80) / 255.0).astype(np.float32)


def test_lines_are_one_path_below_a_whole_shape() -> None:
    result = warpvec.vectorize(_picture(ROWS + DISK))
    scene = result.scene
    assert scene.strokes is not None
    is_line = scene.strokes.width > 0
    assert int(is_line.sum()) == 1
    assert scene.select(is_line.nonzero().flatten()).structure.loop_count == 10
    assert len(scene) == 2


def test_lines_over_a_shape_lie_above_it_as_strokes_of_their_own_color() -> None:
    scene = warpvec.vectorize(_picture(DISK + ROWS)).scene
    assert scene.strokes is not None
    (line,) = (scene.strokes.width > 0).nonzero().flatten().tolist()
    assert line == len(scene) - 1
    assert np.abs(255.0 * scene.color[line].numpy() - [0x33, 0x33, 0x44]).max() < 8.0


def test_thin_lines_of_a_picture_larger_than_its_copy_are_at_their_places() -> None:
    scene = warpvec.vectorize(_picture(ROWS), fit_size=64).scene
    rows = scene.segments[:, 0, 1].reshape(-1, 2)
    assert sorted(rows.mean(1).tolist()) == pytest.approx([10.3 + 6.0 * k for k in range(10)], abs=0.05)


def test_lines_are_traced_as_before_if_nobody_wants_strokes() -> None:
    result = warpvec.vectorize(_picture(ROWS + DISK), strokes="off")
    assert result.scene.strokes is None or not bool((result.scene.strokes.width > 0).any())


def test_dots_smaller_than_two_pixels_keep_their_tones_in_the_mode_lines() -> None:
    places = [(9.3 + 13.1 * k, 9.6 + 13.2 * j, 0.7 + 0.15 * j) for j in range(5) for k in range(6)]
    dots = "".join(f'<circle cx="{x}" cy="{y}" r="{radius}"/>' for x, y, radius in places)
    line = '<path d="M8 74H88" stroke="#000" stroke-width="2"/>'
    scene = warpvec.vectorize(_picture(dots + line), mode="lines").scene
    assert scene.strokes is not None
    assert len(scene) == 31
    widths = sorted(scene.strokes.width.tolist())
    assert widths[0] < 1.5 < 2.4 < widths[-1]


def test_grey_dots_are_black_in_the_mode_mono() -> None:
    y, x = np.indices((64, 64)) + 0.5
    level = np.full((64, 64), 255.0)
    for row in range(8, 64, 9):
        for column in range(8, 64, 9):
            share = np.clip(2.1 - np.hypot(x - column - 0.3, y - row - 0.2), 0.0, 1.0)
            level = level * (1.0 - share) + 90.0 * share
    picture = np.repeat(np.rint(level)[..., None], 3, 2).astype(np.uint8)

    scene = warpvec.vectorize(picture, mode="mono").scene

    assert len(scene) > 40 and not scene.color.any()
