"""The regions of a picture: areas of one paint, and how the pixels between them are mixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Regions:
    """K regions of a picture of h x w pixels. A pixel between two regions is a mix of both.

    Attributes:
        label: region with the largest share of each pixel [h, w] (int32).
        other: region that has the rest of each pixel [h, w] (int32); equal to ``label`` in pure pixels.
        share: share of ``label`` in each pixel [h, w] (float32), in [0.5, 1].
        color: sRGB-encoded fill [K, 3] (float32) in [0, 1]; of a gradient, that of the first stop.
        opacity: opacity [K] (float32) in [0, 1]; 0 for regions where the picture is transparent.
        kind: `warpvec.geometry.gradients.FLAT`, ``LINEAR`` or ``RADIAL`` [K] (int32).
        geometry: ends x1, y1, x2, y2 of a linear gradient, or cx, cy, r, 0 of a radial one, in pixels [K, 4] (float32).
        end_color: fill of the last stop [K, 3] (float32).
        canvas: region that fills the canvas behind all others; None if the picture has no such region.
    """

    label: NDArray[np.int32]
    other: NDArray[np.int32]
    share: NDArray[np.float32]
    color: NDArray[np.float32]
    opacity: NDArray[np.float32]
    kind: NDArray[np.int32]
    geometry: NDArray[np.float32]
    end_color: NDArray[np.float32]
    canvas: int | None = None

    def __len__(self) -> int:
        return len(self.color)
