"""Strokes as filled outlines look the same, in the same order and paint."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from strokes import stroked_scene

from warpvec.rendering.draw import draw_exactly
from warpvec.svg.stroke_outlines import without_strokes

pytest.importorskip("pathops")


def test_outlines_of_strokes_look_like_them() -> None:
    scene = stroked_scene(2, 7, 90, 120, (4.0, 9.0), filled=2)
    scene = scene._mapped(lambda tensor: tensor.float() if tensor.is_floating_point() else tensor)
    filled = without_strokes(scene)
    assert filled.strokes is None and len(filled) == len(scene)
    assert torch.equal(filled.color, scene.color) and torch.equal(filled.opacity, scene.opacity)
    difference = np.abs(draw_exactly(filled, 90, 120, 1) - draw_exactly(scene, 90, 120, 1))
    assert difference.mean() < 2e-3


def test_a_scene_without_strokes_stays() -> None:
    scene = stroked_scene(2, 0, 90, 120, filled=3)
    assert without_strokes(scene) is scene
