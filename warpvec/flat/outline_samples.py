"""Points along every segment of a scene, with how well the picture shows the outline there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates  # type: ignore[import-untyped]

from warpvec.geometry.scene import Scene

Floats = NDArray[np.float64]

SAMPLES = 8
"""Points of each segment. A wave in the outline has at least two nodes, so it cannot pass between the points."""

SIDES = (0.75, 1.5)
"""Distances in pixels from the outline at which the colours of its two sides are read. The first one still sees a line
of two pixels, the second one is outside of the pixels that the edge itself mixes."""

CONTRAST_HALF = 0.1
"""Contrast, of 1 between black and white, at which an outline counts half. An edge of a few levels of 255 hardly says
where it is, and one of a hundred levels says it as well as one of two hundred."""


@dataclass(frozen=True, eq=False)
class OutlineSamples:
    """``SAMPLES`` points in the middle of equal parts of the parameter of each of R segments.

    Attributes:
        control: control points [R, 4, 2] of the segments in pixels.
        points: the points [R, S, 2].
        lengths: length of the outline that each stands for [R, S], in pixels.
        contrast: squared difference of the colours of both sides there [R, S], summed over the channels.
        visibility: how well the picture shows the outline there [R, S], from 0 (hidden) to 1.
    """

    control: Floats
    points: Floats
    lengths: Floats
    contrast: Floats
    visibility: Floats


def sample_outlines(scene: Scene, image: NDArray[np.float32]) -> OutlineSamples:
    """Return the samples of the cubic ``scene``, drawn over or fitted to ``image`` [h, w, 3 or 4] in [0, 1]."""
    control = control_points(scene)
    t = (np.arange(SAMPLES) + 0.5) / SAMPLES
    points, slopes = cubic_points(control, t), cubic_slopes(control, t)
    speed = np.linalg.norm(slopes, axis=-1)
    normal = np.stack([-slopes[..., 1], slopes[..., 0]], -1) / np.maximum(speed, 1e-9)[..., None]
    colors = image if image.shape[2] == 3 else np.concatenate([image[..., :3] * image[..., 3:], image[..., 3:]], 2)
    contrast = np.max([_contrast(colors, points, side * normal) for side in SIDES], 0)
    visibility = contrast / (contrast + 3.0 * CONTRAST_HALF**2)
    return OutlineSamples(control, points, speed / SAMPLES, contrast, visibility)


def control_points(scene: Scene) -> Floats:
    """Return the four control points [R, 4, 2] of each segment."""
    segments, following = scene.segments, scene.structure.segment_next.long()
    control: Floats = torch.cat([segments, segments[following, :1]], 1).double().numpy()
    return control


def cubic_points(control: Floats, t: Floats) -> Floats:
    """Return the points [..., S, 2] of cubics [..., 4, 2] at the parameters ``t`` [S] or [..., S]."""
    return cubic_weights(t) @ control


def cubic_slopes(control: Floats, t: Floats) -> Floats:
    """Return the derivatives [..., S, 2] of cubics [..., 4, 2] at the parameters ``t`` [S] or [..., S]."""
    s = 1.0 - t
    return np.stack([s * s, 2.0 * s * t, t * t], -1) @ (3.0 * np.diff(control, axis=-2))


def cubic_weights(t: Floats) -> Floats:
    """Return the weights [..., 4] of a cubic's control points at ``t`` [...]."""
    s = 1.0 - t
    return np.stack([s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t], -1)


def _contrast(image: NDArray[np.float32], points: Floats, offset: Floats) -> Floats:
    """Return the squared difference of the colours at both sides of ``points`` [R, S, 2], summed over the channels."""
    sides = [points + offset, points - offset]
    difference: Floats = np.zeros(points.shape[:-1])
    for channel in range(image.shape[2]):
        values = [_read(image[..., channel], side) for side in sides]
        difference += np.square(values[0] - values[1])
    return difference


def _read(plane: NDArray[np.float32], points: Floats) -> Floats:
    """Return the values [...] of ``plane`` [h, w] at ``points`` [..., 2], whose nearest pixels continue outside."""
    found: Floats = map_coordinates(plane, [points[..., 1] - 0.5, points[..., 0] - 0.5], order=1, mode="nearest")
    return found.astype(np.float64)
