"""Flat art: from a picture of a logo, an icon or a drawing to a `Result` of few clean paths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.fit.interrupt import deferred_interrupts
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.progress import FitResult, OnProgress
from warpvec.flat.classify import Choice
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.layering import layered
from warpvec.image.resize import reduce_image
from warpvec.vectorization.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.vectorization.goal import Goal
from warpvec.vectorization.result import Result


def fit_flat(
    photo: NDArray[np.float32],
    config: FitConfig,
    *,
    title: str | None = None,
    goal: Goal | None = None,
    on_progress: OnProgress | None = None,
    file_options: FileOptions = DEFAULT_FILE_OPTIONS,
    choice: Choice | None = None,
) -> Result:
    """Draw the flat art ``photo`` [h, w, 3 or 4], as `read_image` returns it, reduced to ``config.fit_size``.

    Args:
        config: settings of the run, with the mode flat.
        goal: requirements on the file; they decide the detail and, if need be, the paths.
        choice: why the mode is flat, for the summary; None if it was asked for.
    """
    target = reduce_image(photo, config.fit_size)
    size = (target.shape[0], target.shape[1])
    reduced = replace(config, min_area=config.min_area * target.shape[0] * target.shape[1] / photo[..., 0].size)
    with deferred_interrupts() as is_interrupted, single_torch_thread(), torch.no_grad():
        drawing = FlatDrawing(torch.from_numpy(target), reduced, on_progress, is_interrupted)
        outlined = drawing.outlined()
        scene = drawing.simplified(outlined, config.detail)
        return _result(photo, size, config, drawing.result(scene), title, file_options, choice)


def _result(
    photo: NDArray[np.float32],
    size: tuple[int, int],
    config: FitConfig,
    fitted: FitResult,
    title: str | None,
    file_options: FileOptions,
    choice: Choice | None,
) -> Result:
    found = layered(fitted.scene)
    return Result(
        photo, size, config, replace(fitted, scene=found.scene), title, file_options=file_options, keeps_paths=True,
        layer_names=found.names, choice=choice,
    )  # fmt: skip
