"""Round equal lines that nearly are the dashes of one line, so that a file can state that dashed line."""

from __future__ import annotations

from dataclasses import replace

import torch

from warpvec.geometry.scene import Scene, straightened
from warpvec.svg.dashes import dash_ends, near_dashes, paths_of_lines

MISS_MAX = 0.1
"""Largest distance in pixels by which the end of a dash may move, as an outline may that nobody asked about."""


def with_dashes(scene: Scene, precision: int, units: float) -> Scene:
    """Return ``scene`` with the dashes of straight lines in places that `warpvec.svg.dashes` can state.

    Args:
        scene: the drawing, in units of its file.
        precision: decimals of the coordinates.
        units: units per pixel of the picture.
    """
    per_unit, segments = 10**precision, scene.segments
    for rows in paths_of_lines(scene).values():
        lines = scene.segments[rows, 0].double().cpu().numpy().reshape(-1, 2, 2) * per_unit
        miss_max = MISS_MAX * units * per_unit
        found = near_dashes(lines, miss_max) or near_dashes(lines[::-1, ::-1], miss_max)
        if found is not None:
            ends = torch.from_numpy(dash_ends(found).reshape(-1, 1, 2) / per_unit).to(segments)
            segments = segments.clone() if segments is scene.segments else segments
            segments[rows] = ends
    return scene if segments is scene.segments else replace(scene, segments=straightened(segments, scene.structure))
