"""Find the paints that are shades of one colour. They share a layer."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.drawing import DRAWING
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.image.oklab import to_oklab


def shade_groups(scene: Scene) -> Integers:
    """Return the group of shades of each path [N], from 0 on; those of one group differ little from each other.

    A gradient is compared by its two ends, the lighter one with the lighter one. A flat paint has two equal ends.
    """
    places, kind = np.unique(_places(scene), axis=0, return_inverse=True)
    if len(places) < 2:
        return np.zeros(len(scene), np.int64)
    from scipy.cluster.hierarchy import fcluster, linkage  # a fifth of a second, which pictures of one colour need not

    groups = fcluster(linkage(places, "complete"), DRAWING.shades_apart, "distance")
    return groups[kind.reshape(-1)] - 1


def _places(scene: Scene) -> Floats:
    """Return the paint of each path as a point [N, 7], whose distances say how different two paints look."""
    first = last = scene.color
    if scene.gradients is not None:
        last = scene.gradients.end_color.where(scene.gradients.kind[:, None] != FLAT, scene.color)
    ends = np.stack([to_oklab(_as_written(end.double().numpy())) for end in (first, last)], 1)
    is_darker_first = ends[:, 0, 0] < ends[:, 1, 0]
    ends[is_darker_first] = ends[is_darker_first, ::-1]
    ends[..., 0] *= DRAWING.shade_lightness
    opacity = np.rint(100.0 * scene.opacity.double().numpy()) / 100.0
    return np.concatenate([ends.reshape(-1, 6) / np.sqrt(2.0), opacity[:, None]], 1)


def _as_written(color: Floats) -> Floats:
    """Return colours rounded as in the file. Colours that look equal there become equal numbers."""
    return np.rint(255.0 * color.clip(0.0, 1.0)) / 255.0
