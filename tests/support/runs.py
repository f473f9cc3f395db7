"""Runs of a given picture with given settings, without a command and without reading files."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.fit.checkpoint import saving_to
from warpvec.goals.goal import NO_GOAL, Goal
from warpvec.modes.choice import draw_picture
from warpvec.modes.photo import Photo
from warpvec.modes.request import Request
from warpvec.result import Result
from warpvec.watch.watch import Watch


def drawn(
    pixels: NDArray[np.float32],
    config: FitConfig,
    goal: Goal = NO_GOAL,
    *,
    on_progress: Any = None,
    checkpoint: object = None,
    every: int = 1,
    on_error: Any = None,
    **photo: Any,
) -> Result:
    """Return the result of a run.

    Args:
        checkpoint: file for the state of the fit after every ``every``-th iteration; None for no file.
        on_error: called with errors of writing it.
        photo: attributes of `warpvec.modes.photo.Photo`.
    """
    watch = Watch(on_progress, config.time_budget)
    request = Request.of(pixels, config, goal, watch=watch)
    if checkpoint is not None:
        photo["saving"] = saving_to(str(checkpoint), every, config, request.picture.reduced, on_error)
    return Result(draw_picture(request, Photo(**photo)), watch.facts())
