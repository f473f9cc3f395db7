"""Pictures of lines."""

from __future__ import annotations

import numpy as np

from warpvec.svg.measure import draw

SIDE, SAMPLES = 128, 4


def picture(shapes: str) -> np.ndarray:
    """Return a picture [128, 128, 3] of ``shapes`` of SVG, lines with round ends."""
    side = SIDE * SAMPLES
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIDE} {SIDE}" width="{side}" height="{side}">'
    look = '<g fill="none" stroke="#000" stroke-linecap="round" stroke-linejoin="round">'
    mean = draw(f"{head}{look}{shapes}</g></svg>", side, side).reshape(SIDE, SAMPLES, SIDE, SAMPLES, 3).mean((1, 3))
    return (np.round(mean) / 255).astype(np.float32)
