"""The state that an element of an SVG inherits from its parents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.svg.foreign.style import Properties


@dataclass(frozen=True)
class State:
    """What an element inherits.

    Attributes:
        matrix: from user space to pixels [2, 3].
        properties: its properties.
        opacity: product of the opacities of the element and its parents.
        generation: level of detail.
        viewport: width and height that percentages refer to.
        depth: number of elements around it.
        softness: standard deviation in pixels of the blurs of the element and its parents.
    """

    matrix: NDArray[np.float64]
    properties: Properties
    opacity: float
    generation: int
    viewport: tuple[float, float]
    depth: int = 0
    softness: float = 0.0
