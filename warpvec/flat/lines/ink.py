"""The ink of a picture: how much of each pixel it covers, and its outlines."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats, Integers
from warpvec.flat.mono import MonoTracing, mono_tracing
from warpvec.flat.simplification.outline_samples import control_points, segment_loops
from warpvec.flat.simplification.path_removal import loop_areas
from warpvec.watch.watch import Watch


class Ink(NamedTuple):
    """The outlines of ink.

    Attributes:
        control: cubics along them [R, 4, 2] in pixels.
        loop: the loop of each cubic [R].
        areas: signed area of each loop [L]; that of a hole has the other sign.
        speck_count: number of specks that were left out.
        faint_count: number of lines that were left out, because they cover no pixel by half.
        paper: share of each pixel that is paper [h, w]: the picture as a clean scan would have it.
    """

    control: Floats
    loop: Integers
    areas: Floats
    speck_count: int
    faint_count: int
    paper: Floats


def find_ink(image: NDArray[Any], tolerance: float | None, min_area: float, watch: Watch) -> Ink:
    """Return the ink of ``image`` [h, w, 3 or 4] as floats in [0, 1]; the other arguments as in `mono_tracing`."""
    tracing: MonoTracing = mono_tracing(image, tolerance=tolerance, min_area=min_area, watch=watch)
    scene = tracing.scene
    control, loop = control_points(scene), segment_loops(scene)
    areas = loop_areas(control, loop, scene.structure.loop_count) if len(control) else np.zeros(0)
    return Ink(control, loop, areas, tracing.speck_count, tracing.faint_count, 1.0 - tracing.coverage)
