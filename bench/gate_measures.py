"""Measures of the icon gate: colour difference, parameters, elements and turning of an SVG.

The protocol is that of a rival's gate, so that figures can be laid beside its printed ones.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from flat_corners import scene_of
from flat_originals import Pixels
from numpy.typing import NDArray
from skimage.color import deltaE_ciede2000, rgb2lab

from warpvec.geometry.scene import Scene
from warpvec.svg.document import local_name
from warpvec.svg.parameters import shape_parameters

_CHORDS = 16
"""Chords of a cubic whose turns are added."""


class Words(NamedTuple):
    """What a file says: the numbers that shape its outlines, and its shapes."""

    parameters: int
    elements: int


def count_words(svg: str) -> Words:
    """Count the parameters and the shapes of ``svg``, those in definitions included, for somebody drew them."""
    elements = ElementTree.fromstring(svg).iter()
    found = (shape_parameters(local_name(element.tag), element.attrib) for element in elements)
    counts = [count for count in found if count is not None]
    return Words(sum(counts), len(counts))


def color_difference(drawn: Pixels, truth: Pixels) -> float:
    """Return the mean CIEDE2000 between two pictures [h, w, 3] in sRGB."""
    differs = (drawn != truth).any(2)  # the others are 0, and most of the time of the formula
    if not differs.any():
        return 0.0
    distances = deltaE_ciede2000(rgb2lab(drawn[differs]), rgb2lab(truth[differs]))
    return float(distances.sum() / differs.size)


def turning(svg: str, width: int, height: int) -> float:
    """Return the absolute turning of all outlines of ``svg`` over their length, in radians a px of that drawing.

    Those of strokes are their centre lines.
    """
    scene = scene_of(svg, width, height)
    structure, turned, length = scene.structure, 0.0, 0.0
    is_open = [False] * structure.loop_count if structure.is_open is None else structure.is_open.tolist()
    for (start, stop), opened in zip(pairwise(structure.loop_first_segment.tolist()), is_open, strict=True):
        steps = _steps(scene, start, stop, opened)
        following = np.roll(steps, -1, axis=0)
        cross = steps[:, 0] * following[:, 1] - steps[:, 1] * following[:, 0]
        turns = np.abs(np.arctan2(cross, (steps * following).sum(1)))
        turned += float(turns[: -1 if opened else None].sum())
        length += float(np.hypot(*steps.T).sum())
    return turned / length if length else 0.0


def _steps(scene: Scene, start: int, stop: int, is_open: bool) -> NDArray[np.float64]:
    """Return the chords [n, 2] of a loop, without those of no length and the row after the end of an open line."""
    rows = scene.segments[start:stop].double().numpy()
    cubics = np.concatenate([rows, np.roll(rows[:, :1], -1, axis=0)], 1)
    t = (np.arange(_CHORDS) / _CHORDS)[:, None]
    a, b, c, d = np.moveaxis(cubics, 1, 0)[:, :, None]
    points = ((1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d).reshape(-1, 2)
    steps = (np.roll(points, -1, axis=0) - points)[: -_CHORDS if is_open else None]
    return steps[np.hypot(*steps.T) > 1e-9]
