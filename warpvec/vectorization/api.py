"""The Python interface: an image in, a `Result` out."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.checkpoint import Checkpoint, write_checkpoint
from warpvec.fit.loop import fit
from warpvec.fit.progress import Progress
from warpvec.fit.state import Saving, State, digest
from warpvec.geometry.scene import Scene
from warpvec.image.read import ImageSource, read_image
from warpvec.image.resize import reduce_image
from warpvec.rendering.launch import resolve_device
from warpvec.svg.measure import evaluate
from warpvec.vectorization.goal import Goal, with_curves
from warpvec.vectorization.result import Result
from warpvec.vectorization.search import Search

__all__ = ["OnProgress", "Result", "evaluate", "fit_photo", "vectorize"]

OnProgress = Callable[[Progress], None]


def vectorize(
    image: ImageSource,
    curves: int | str | None = None,
    *,
    preset: str = "default",
    background: str | None = None,
    max_bytes: int | None = None,
    gzip: bool = False,
    target_psnr: float | None = None,
    on_progress: OnProgress | None = None,
    **settings: Any,
) -> Result:
    """Turns ``image`` into closed Bezier paths.

    Args:
        image: a path, the bytes of an image file, a PIL image, or an array as `warpvec.image.read.read_image` takes.
        curves: number of paths, by default 512; "auto" for as many as the image rewards; beside ``max_bytes`` or
            ``target_psnr``, which decide it, the most that may be taken.
        preset: one of `warpvec.PRESETS`: "draft", "default", "best", "paper" or "bezier-splatting".
        background: colour behind a transparent image; None keeps it transparent.
        max_bytes: the text of the SVG has at most these bytes, after gzip if ``gzip`` says so.
        target_psnr: decibels that the file, drawn by resvg, is to reach; it is met within 0.25 dB where it can be.
        on_progress: called after every iteration; keep it cheap.
        settings: fields of `warpvec.FitConfig` that replace those of the preset.

    Raises:
        InputError: the image cannot be read, or a setting is wrong.
    """
    goal = Goal(max_bytes=max_bytes, gzip=gzip, target_psnr=target_psnr, auto=curves == "auto")
    config = make_config(preset, **with_curves(settings, curves, goal))
    resolve_device(config.device)  # an unknown one is found before the photo is read
    photo = read_image(image, background, name="image")
    title = Path(image).stem if isinstance(image, str | os.PathLike) else None
    return fit_photo(photo, config, title=title, goal=goal, on_progress=on_progress)


def fit_photo(
    photo: NDArray[np.float32],
    config: FitConfig,
    *,
    title: str | None = None,
    goal: Goal | None = None,
    start: Scene | None = None,
    on_progress: OnProgress | None = None,
    checkpoint: str | None = None,
    every: int = 50,
    resume: Checkpoint | None = None,
) -> Result:
    """Fits ``photo`` [h, w, 3 or 4], reduced to ``config.fit_size``, as `read_image` gives it.

    Args:
        goal: what the file must be; ``config.curves`` is then the most that it may take.
        start: paths to begin with, in pixels of the photo.
        checkpoint: file that holds the state of the fit after every ``every``-th iteration.
        resume: such a state, of this photo and with these settings, to go on from.

    Raises:
        InputError: ``resume`` is of another photo, or as `warpvec.fit.loop.fit`.
    """
    target = reduce_image(photo, config.fit_size)
    pixels = torch.from_numpy(target)
    state = None if resume is None else _state_of(resume, pixels, config)
    saving = None if checkpoint is None else _saving(checkpoint, every, config, pixels)
    size = (target.shape[0], target.shape[1])
    factors = size[1] / photo.shape[1], size[0] / photo.shape[0]

    def fit_once(settings: FitConfig, scene: Scene | None) -> Result:
        reduced = replace(settings, min_area=settings.min_area * factors[0] * factors[1])
        fitted = fit(pixels, reduced, on_progress, start=scene, resume=state, saving=saving)
        return Result(photo, size, settings, fitted, title)

    first = None if start is None else start.scaled(*factors)
    if not goal:
        return fit_once(config, first)
    return Search(goal, config, fit_once, first).run()


def _state_of(checkpoint: Checkpoint, target: Tensor, config: FitConfig) -> State:
    """The state to go on from, on the threads that ``config`` says now."""
    if checkpoint.target_digest != digest(target):
        raise InputError("IN must be the photo of the checkpoint, as it was, got another one; give that or start anew")
    settings = {**checkpoint.state["config"], "threads": config.threads, "device": config.device}
    return {**checkpoint.state, "config": settings}


def _saving(path: str, every: int, config: FitConfig, target: Tensor) -> Saving:
    target_digest = digest(target)
    return Saving(every, lambda state: write_checkpoint(path, Checkpoint(config, target_digest, state)))
