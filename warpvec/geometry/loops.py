"""Outlines with different numbers of cubics, and the padded scene that they make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene

MAX_CUBICS = 2**22
"""Maximum number of cubics of a scene, padding included: 100 MB of control points."""

Color = tuple[float, float, float]

WHITE: Color = (1.0, 1.0, 1.0)
BLACK: Color = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Outline:
    """A filled closed loop of k cubics.

    Attributes:
        points: control points [3 k, 2] in pixels (float64), as in a row of a scene.
        color: sRGB-encoded, in [0, 1].
        opacity: in [0, 1].
        generation: level of detail.
    """

    points: NDArray[np.float64]
    color: Color
    opacity: float
    generation: int


def make_scene(outlines: Sequence[Outline], background: Color | None) -> Scene:
    """Return the scene of ``outlines`` over ``background``, or a transparent scene if that is None.

    All paths have as many cubics as the longest outline. Shorter ones are padded with cubics of zero length.

    Raises:
        InputError: the scene would have more than ``MAX_CUBICS``, or a coordinate exceeds float32.
    """
    longest = max((len(outline.points) // 3 for outline in outlines), default=1)
    if longest * len(outlines) > MAX_CUBICS:
        rule = f"must have at most {MAX_CUBICS} curves when every path is padded to the longest one"
        raise InputError(
            "SVG", rule, f"{len(outlines)} paths of {longest} curves", "simplify or split the longest path"
        )
    points = torch.from_numpy(_padded(outlines, 3 * longest)).float()
    if not points.isfinite().all():
        raise InputError("SVG", "must have coordinates below 3e38", "larger ones", "scale it down")
    return Scene.uniform(
        points=points,
        color=torch.tensor([outline.color for outline in outlines], dtype=torch.float64).reshape(-1, 3).float(),
        opacity=torch.tensor([outline.opacity for outline in outlines], dtype=torch.float64).float(),
        background=torch.tensor(background or BLACK, dtype=torch.float64).float(),
        generation=torch.tensor([outline.generation for outline in outlines], dtype=torch.int64),
        transparent=background is None,
    )


def _padded(outlines: Sequence[Outline], count: int) -> NDArray[np.float64]:
    """Return control points [N, count, 2], padded with each outline's first point."""
    points = np.empty((len(outlines), count, 2))
    for row, outline in zip(points, outlines, strict=True):
        row[: len(outline.points)] = outline.points
        row[len(outline.points) :] = outline.points[0]
    return points
