"""Pictures of strokes, and their drawings."""

from __future__ import annotations

import numpy as np
import torch

from warpvec.arrays import Floats32
from warpvec.config.fit_config import FitConfig
from warpvec.flat.drawing import FlatDrawing
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw

CONFIG = FitConfig(threads=1, device="cpu")
SIDE, SAMPLES = 128, 4


def picture_of(shapes: str) -> Floats32:
    """Return the picture of ``shapes`` of SVG on 128 x 128 pixels [h, w, 3]."""
    side = SIDE * SAMPLES
    text = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIDE} {SIDE}" width="{side}" height="{side}">'
    mean = draw(f"{text}{shapes}</svg>", side, side).reshape(SIDE, SAMPLES, SIDE, SAMPLES, 3).mean((1, 3))
    return (np.round(mean) / 255).astype(np.float32)


def drawn(shapes: str, config: FitConfig = CONFIG) -> Scene:
    """Return the drawing of `picture_of` these ``shapes``."""
    with torch.no_grad():
        return FlatDrawing(torch.from_numpy(picture_of(shapes)), config).draw(config.detail)[0]


def stroke(data: str, width: float, look: str = 'stroke-linecap="round" stroke-linejoin="round"') -> str:
    return f'<path d="{data}" fill="none" stroke="#123" stroke-width="{width}" {look}/>'


def lines_of(scene: Scene) -> int:
    """Return the number of lines of all strokes."""
    assert scene.strokes is not None and scene.strokes.is_stroked.all()
    return scene.structure.loop_count
