"""Make one black shape of a drawing, for fonts: what is dark is ink, and what is light takes ink away."""

from __future__ import annotations

import numpy as np
import torch

from warpvec.geometry.loops import make_scene
from warpvec.geometry.scene import Scene, over_white
from warpvec.image.luma import LUMA
from warpvec.purposes.loops import loops_of, outline_of, polygon
from warpvec.svg.foreign.shapes import Loop
from warpvec.svg.foreign.skia import Combiner

_SEEN = 0.5
"""Opacity below which a path is as good as not there."""


def one_shape(scene: Scene, width: float, height: float) -> Scene:
    """Return a transparent scene of one black path, of ``scene`` of filled paths of one colour each.

    The canvas of ``width`` x ``height`` is white if it is transparent. The limit between dark and light is half way
    between the darkest and the lightest colour that is there, so that a yellow drawing on white is ink too.
    """
    scene, combiner, ink = over_white(scene), Combiner(), list[Loop]()
    colors = torch.cat([scene.background[None], scene.color])
    light = (colors * torch.tensor(LUMA)).sum(1)
    is_dark = (light < (light.min() + light.max()) / 2.0).tolist()
    if is_dark[0]:
        ink = [polygon(np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]))]
    for path in (scene.opacity >= _SEEN).nonzero().flatten().tolist():
        loops = loops_of(scene.select(torch.tensor([path])))
        if not ink:
            ink = loops if is_dark[path + 1] else []
        elif is_dark[path + 1]:
            ink = combiner.together(ink, loops) or [*ink, *loops]
        else:
            left = combiner.without(ink, loops)
            ink = ink if left is None else left
    return make_scene([outline_of(ink, (0.0, 0.0, 0.0), 1.0, 0)] if ink else [], None)
