"""Paths of scenes as loops that Skia combines, and loops as paths."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from warpvec.arrays import Floats
from warpvec.geometry.loops import Color, Outline
from warpvec.geometry.scene import Scene
from warpvec.svg.foreign.shapes import Loop


def loops_of(one: Scene) -> list[Loop]:
    """Return the loops of a scene of one filled path."""
    rows, is_line = one.segments.double().cpu().numpy(), one.structure.lines.cpu().numpy()
    first = one.structure.loop_first_segment.tolist()
    return [Loop(rows[a:b].reshape(-1, 2), is_line[a:b]) for a, b in pairwise(first)]


def outline_of(loops: list[Loop], color: Color, opacity: float, generation: int) -> Outline:
    """Return the path of ``loops``."""
    points, is_line = (np.concatenate(parts) for parts in zip(*loops, strict=True))
    return Outline(points, color, opacity, generation, tuple(len(loop.is_line) for loop in loops), is_line)


def short_numbers(points: Floats, tolerance: float) -> Floats:
    """Return ``points`` rounded to as few decimals as keep each number within ``tolerance`` of its own.

    Bands and rings are many, and a file is read in bytes.
    """
    return np.round(points, max(0, math.ceil(-math.log10(2.0 * tolerance))))


def polygon(corners: Floats) -> Loop:
    """Return the loop of lines between ``corners`` [K, 2]."""
    following = np.roll(corners, -1, axis=0)
    rows = np.stack([corners, (2 * corners + following) / 3, (corners + 2 * following) / 3], 1)
    return Loop(rows.reshape(-1, 2), np.ones(len(corners), np.bool_))
