"""Fit an edited drawing again: locked paths stay as they are, and what was deleted is filled in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.app.erasing import hole_of
from warpvec.app.messages import Job
from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.fit.placement import colors_at
from warpvec.fit.progress import OnProgress
from warpvec.geometry.circles import circle_points
from warpvec.geometry.joints import with_lines
from warpvec.geometry.scene import Scene, over_white
from warpvec.image.alpha import is_transparent
from warpvec.svg.measure import file_facts
from warpvec.vectorization.file_options import DEFAULT_FILE_OPTIONS
from warpvec.vectorization.polishing import polish_photo
from warpvec.vectorization.refine import form_of, place_on_photo, read_drawing
from warpvec.vectorization.result import Result

ITERATIONS = 300
"""Most iterations. A drawing whose edits are small ends earlier."""

FILLED_MAX = 64
"""Most paths that are added where others were deleted: what is filled in is smooth."""

SEGMENTS = 4
"""Cubics of such a path, those of the fit of a photo."""

OVERLAP = 1.3
"""Radius of the added circles, in those of circles that would have the area of the hole together."""

CANDIDATES_MAX = 4000
"""Most pixels of the hole that are looked at for centres of circles."""


def fit_again(job: Job, photo: NDArray[np.float32], mode: str, config: FitConfig, on_progress: OnProgress) -> Result:
    """Fit the paths of the job's drawing to ``photo`` [h, w, 3 or 4].

    Args:
        job: its ``start`` is the drawing.
        photo: the picture, without what was deleted from the drawing.
        mode: kind of the picture. In photos as many paths as were deleted are added; areas of flat art need none.
        config: settings of a fit of a photo.
        on_progress: called after every iteration.

    Raises:
        InputError: the drawing cannot be read, or the locked paths cannot be found in it.
    """
    assert job.start is not None
    data = job.start.encode()
    drawing = read_drawing(data)
    scene = with_lines(place_on_photo(drawing, photo))
    locked = _locked(job, len(scene))
    if not is_transparent(photo):
        scene = over_white(scene)
    if job.filled is not None and mode == "photo":
        scene = scene.joined(_filling(hole_of(photo, job.filled), photo, file_facts(job.filled)["paths"], scene))
        locked = torch.cat([locked, torch.zeros(len(scene) - len(locked), dtype=torch.bool)])
    precision = config.precision if drawing.precision is None else drawing.precision
    config = replace(config, curves=max(1, len(scene)), precision=precision)
    form = form_of(drawing, data, config, photo)
    return polish_photo(
        photo, scene, config, ITERATIONS, job.name, on_progress, DEFAULT_FILE_OPTIONS, form, False,
        locked if bool(locked.any()) else None,
    )  # fmt: skip


def _locked(job: Job, count: int) -> Tensor:
    """Return the mask [N] of the locked ones of ``count`` paths."""
    mask = torch.zeros(count, dtype=torch.bool)
    if not job.locked:
        return mask
    assert job.start is not None
    if job.locked[-1] >= count or job.start.count("<path") != count:
        remedy = "fit again without locked paths"
        raise InputError("drawing", "must have only filled paths to lock some", "strokes or others", remedy)
    mask[list(job.locked)] = True
    return mask


def _filling(hole: NDArray[np.bool_], photo: NDArray[np.float32], count: int, scene: Scene) -> Scene:
    """Return ``count`` circles that cover the ``hole`` [h, w] together, in the colours of ``photo`` there."""
    center = torch.from_numpy(_spread(hole, min(count, FILLED_MAX)))
    radius = OVERLAP * float(np.sqrt(hole.sum() / (np.pi * len(center))))
    color = colors_at(torch.from_numpy(np.ascontiguousarray(photo[..., :3])), center)
    generation = torch.full((len(center),), int(scene.generation.max()) + 1)
    circles = circle_points(center, torch.full((len(center),), radius), SEGMENTS)
    return Scene.uniform(circles, color, torch.ones(len(center)), scene.background, generation)


def _spread(hole: NDArray[np.bool_], count: int) -> NDArray[np.float32]:
    """Return ``count`` centres [K, 2] of pixels in the ``hole`` [h, w], each as far from those before as can be."""
    rows, columns = np.nonzero(hole if hole.any() else np.ones_like(hole))
    step = max(1, len(rows) // CANDIDATES_MAX)
    points = np.stack([columns[::step], rows[::step]], 1).astype(np.float32) + 0.5
    chosen = [int(((points - points.mean(0)) ** 2).sum(1).argmin())]
    distance = ((points - points[chosen[0]]) ** 2).sum(1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, ((points - points[chosen[-1]]) ** 2).sum(1))
    return points[chosen]
