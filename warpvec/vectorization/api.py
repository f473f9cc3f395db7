"""The Python interface: turn an image into a `Result`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.checkpoint import Checkpoint, write_checkpoint
from warpvec.fit.progress import OnProgress
from warpvec.fit.state import Saving, State, digest
from warpvec.flat.classify import Choice, choose_mode
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import is_transparent
from warpvec.image.read import ImageSource, read_image
from warpvec.image.resize import reduce_image
from warpvec.rendering.launch import resolve_device
from warpvec.svg.measure import evaluate
from warpvec.vectorization.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.vectorization.goal import Goal, is_auto, with_curves, with_given_segments
from warpvec.vectorization.photo_fit import PhotoFit
from warpvec.vectorization.result import Result

if TYPE_CHECKING:
    from warpvec.vectorization.flat_art import Outlines

__all__ = ["FileOptions", "Result", "evaluate", "fit_photo", "title_of", "vectorize"]


def vectorize(
    image: ImageSource,
    curves: int | str | None = None,
    *,
    preset: str = "default",
    background: str | None = None,
    max_bytes: int | None = None,
    gzip: bool = False,
    target_psnr: float | None = None,
    metadata: bool = True,
    trim: bool = False,
    size: str | None = None,
    on_progress: OnProgress | None = None,
    **settings: Any,
) -> Result:
    """Turn ``image`` into closed Bezier paths.

    Args:
        image: a path, the bytes of an image file, a PIL image, or an array or torch tensor as
            `warpvec.image.read.read_image` takes it.
        curves: number of paths, by default 512; "auto" for as many as the image rewards. With ``max_bytes`` or
            ``target_psnr``, which decide the number, it is the most that may be used.
        preset: name of one of `warpvec.PRESETS`.
        background: colour behind a transparent image; None keeps it transparent.
        max_bytes: largest size of the SVG text, after gzip if ``gzip`` is true.
        target_psnr: PSNR in dB that the file must reach, drawn by resvg, with as few paths as possible.
        metadata: store the settings in the file.
        trim: cut the paths off at the edges of the canvas.
        size: width of the drawing with its unit, such as "90mm"; also cm, in, pt, px, and % of its pixels.
        on_progress: called after every iteration; it should be quick.
        settings: fields of `warpvec.FitConfig` that replace those of the preset.

    Raises:
        InputError: the image cannot be read, or a setting is wrong.
    """
    goal = Goal(max_bytes=max_bytes, gzip=gzip, target_psnr=target_psnr, auto=is_auto(curves))
    config = make_config(preset, **with_curves(settings, curves, goal))
    goal = with_given_segments(goal, settings, config)
    file_options = FileOptions(metadata=metadata, trim=trim, size=size)
    resolve_device(config.device)  # report an unknown device before reading the image
    return fit_photo(
        read_image(image, background, name="image"),
        config,
        title=title_of(image),
        goal=goal,
        on_progress=on_progress,
        file_options=file_options,
    )


def title_of(image: ImageSource) -> str | None:
    """Return the title of the SVG of ``image``: its file name without suffix, None if it is no path."""
    return Path(image).stem if isinstance(image, str | os.PathLike) else None


def fit_photo(
    photo: NDArray[np.float32],
    config: FitConfig,
    *,
    title: str | None = None,
    goal: Goal | None = None,
    start: Scene | None = None,
    on_progress: OnProgress | None = None,
    checkpoint: str | None = None,
    on_checkpoint_error: Callable[[OSError], None] | None = None,
    every: int = 50,
    resume: Checkpoint | None = None,
    file_options: FileOptions = DEFAULT_FILE_OPTIONS,
    outlines: Outlines | None = None,
) -> Result:
    """Vectorize ``photo`` [h, w, 3 or 4], as `read_image` returns it, reduced to ``config.fit_size``.

    With the mode auto, paths to begin with or a checkpoint mean that it is a photo; else the picture decides.

    Args:
        goal: requirements on the file; ``config.curves`` is then the most that may be used.
        start: paths to begin with, in pixels of the photo.
        checkpoint: file that receives the state of the fit after every ``every``-th iteration.
        on_checkpoint_error: called when that file cannot be written; the fit goes on. By default Python warns.
        resume: such a state, of this photo and with these settings, to continue from.
        file_options: choices about the file alone.
        outlines: of the last picture of flat art, for a caller that fits it again with another detail.

    Raises:
        InputError: ``resume`` is of another photo, a state is saved or resumed in spite of a goal, or as
            `warpvec.fit.loop.fit`.
    """
    _refuse_states(goal, checkpoint, resume)
    target = reduce_image(photo, config.fit_size)
    choice = None
    if config.mode == "auto":
        choice = None if start is not None or checkpoint is not None or resume is not None else _chosen(target, config)
        config = replace(config, mode="photo" if choice is None else choice.mode)
    if config.mode != "photo":
        drawn = _drawn(photo, config, title, goal, on_progress, file_options, choice, outlines)
        if isinstance(drawn, Result):
            return drawn
        choice, config = Choice("photo", drawn), replace(config, mode="photo")
    if config.opacity == "common" and is_transparent(target):  # soft edges need paths of their own opacity
        config = replace(config, opacity="free")
    pixels = torch.from_numpy(target)
    state = None if resume is None else _state_of(resume, pixels)
    saving = None if checkpoint is None else _saving(checkpoint, every, config, pixels, on_checkpoint_error or _warn)
    common = PhotoFit(photo, target, config, goal or Goal(), title, file_options, choice, on_progress, state, saving)
    return common.run(start)


def _refuse_states(goal: Goal | None, checkpoint: str | None, resume: Checkpoint | None) -> None:
    """Raise InputError if the state of a fit that follows a goal is to be saved or resumed: it has none of the goal."""
    for name, given in (("resume", resume), ("checkpoint", checkpoint)):
        if goal and given is not None:
            rule = "must be given without a goal for the file, whose fits have no state"
            raise InputError(name, rule, remedy="leave one of them out")


def _drawn(
    photo: NDArray[np.float32],
    config: FitConfig,
    title: str | None,
    goal: Goal | None,
    on_progress: OnProgress | None,
    file_options: FileOptions,
    choice: Choice | None,
    outlines: Outlines | None,
) -> Result | str:
    """Return the drawing of flat art; if only the picture has chosen the mode, maybe why it is rather a photo."""
    from warpvec.flat.regions.regions import NotFlatArtError  # these load SciPy, which photos do without
    from warpvec.vectorization.flat_art import fit_flat

    may_refuse = choice is not None and not (_has_paints(config) or config.cutout)
    try:
        result = fit_flat(
            photo,
            config,
            title=title,
            goal=goal,
            on_progress=on_progress,
            file_options=file_options,
            choice=choice,
            may_refuse=may_refuse,
            outlines=outlines,
        )
    except NotFlatArtError as error:
        return str(error)
    if choice is None or not _is_too_far(result, goal):
        return result
    return f"as flat art it has only {result.file_psnr:.1f} dB"


FLAT_PSNR_MIN = 26.0
"""If auto takes a picture for flat art and the drawing reaches fewer dB, the picture is fitted as a photo. Drawings of
logos have 40 to 60 dB; screenshots with small text have 27, which is still more than the fit of a photo gives them."""


def _is_too_far(result: Result, goal: Goal | None) -> bool:
    """Return whether a drawing of flat art is too far from its picture, although nothing has bounded it."""
    config = result.config
    is_bounded = goal or result.interrupted or config.time_budget is not None or config.curves < FitConfig.curves
    has_paints = _has_paints(config) or config.gradients == 0.0
    is_free = config.mode == "flat" and not (has_paints or is_bounded or config.cutout)
    return is_free and result.file_psnr < FLAT_PSNR_MIN


def _has_paints(config: FitConfig) -> bool:
    """Return whether the settings say which paints the file may have."""
    return bool(config.colors or config.palette or config.opacity == "opaque")


def _chosen(target: NDArray[np.float32], config: FitConfig) -> Choice:
    """Return the mode that the picture asks for; a drawing that is to have given colours is not black and white art."""
    choice = choose_mode(target)
    has_colors = config.colors > 0 or config.palette is not None
    return choice._replace(mode="flat") if choice.mode == "mono" and has_colors else choice


def _state_of(checkpoint: Checkpoint, target: Tensor) -> State:
    """Return the state to continue from.

    Raises:
        InputError: the checkpoint is of another photo.
    """
    if checkpoint.target_digest != digest(target):
        rule = "must be the photo of the checkpoint, unchanged"
        raise InputError("image", rule, "another one", "give that photo, or start anew without the checkpoint")
    return checkpoint.state


def _saving(path: str, every: int, config: FitConfig, target: Tensor, on_error: Callable[[OSError], None]) -> Saving:
    target_digest = digest(target)

    def save(state: State) -> None:
        try:
            write_checkpoint(path, Checkpoint(config, target_digest, state))
        except OSError as error:  # a fit is worth more than its checkpoint
            on_error(error)

    return Saving(every, save)


def _warn(error: OSError) -> None:
    warnings.warn(f"the checkpoint could not be written ({error}); the fit goes on", RuntimeWarning, stacklevel=2)
