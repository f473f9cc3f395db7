"""Polish a drawing: the fit that keeps its structure, and the choice between its result and the drawing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.fit.polish import polish
from warpvec.fit.progress import FitResult, OnProgress
from warpvec.geometry.scene import Scene, over_white
from warpvec.image.resize import reduce_image
from warpvec.rendering.launch import resolve_device
from warpvec.vectorization.drawn_rounds import polish_as_drawn
from warpvec.vectorization.file_form import FileForm
from warpvec.vectorization.file_options import FileOptions
from warpvec.vectorization.gradient_rounds import polish_with_gradients
from warpvec.vectorization.result import Result


def polish_photo(
    photo: NDArray[np.float32],
    start: Scene,
    config: FitConfig,
    iterations: int,
    title: str | None,
    on_progress: OnProgress | None,
    file_options: FileOptions,
    form: FileForm | None,
    free: bool,
    locked: torch.Tensor | None = None,
) -> Result:
    """Fit ``start``, in pixels of the ``photo``, and return the file that resvg draws best: the fitted one or its own.

    Without iterations the file keeps its canvas, and the title and the settings that it states, or none. If ``config``
    asks for opaque paths, ``start`` is made opaque before; the file may then be worse than the drawing was. ``locked``
    paths [N] (bool) keep their form and paint.
    """
    if not iterations:
        return _as_read(photo, start, config, title, file_options, form)
    target = reduce_image(photo, config.fit_size)
    size = (target.shape[0], target.shape[1])
    reduced = start.scaled(size[1] / photo.shape[1], size[0] / photo.shape[0])
    pixels = torch.from_numpy(target)
    if pixels.shape[2] == 4:
        reduced = replace(reduced, background=torch.zeros_like(reduced.background), transparent=True)
    else:
        reduced = over_white(reduced)
    given = reduced
    if config.opacity == "opaque":
        reduced = replace(reduced, opacity=torch.ones_like(reduced.opacity))
    if form is not None:
        form = form._replace(title=title, metadata=None)
    if config.gradients:
        fitted = polish_with_gradients(pixels, reduced, config, on_progress, iterations, free, locked)
    else:
        fitted = polish(pixels, reduced, config, on_progress, iterations=iterations, free=free, locked=locked)
    result = Result(photo, size, config, fitted, title, file_options=file_options, form=form, keeps_paths=True)
    result = polish_as_drawn(result, pixels, iterations, free, locked, on_progress)
    first = replace(result, fitted=replace(fitted, scene=reduced))
    before = first.file_psnr
    is_better = result.file_psnr >= before
    if not torch.equal(given.opacity, reduced.opacity):
        before = replace(first, fitted=replace(fitted, scene=given)).file_psnr
    return replace(result if is_better else first, start_psnr=before)


def _as_read(
    photo: NDArray[np.float32],
    start: Scene,
    config: FitConfig,
    title: str | None,
    file_options: FileOptions,
    form: FileForm | None,
) -> Result:
    """Return the file of the drawing as it was read, in opaque paths if ``config`` asks for these."""
    size = (photo.shape[0], photo.shape[1])
    scene = start
    if config.opacity == "opaque":
        scene = replace(start, opacity=torch.ones_like(start.opacity))
    if form is not None and form.metadata is None:
        file_options = replace(file_options, metadata=False)
    fitted = FitResult(scene, [], 0, 0.0, False, resolve_device(config.device))
    result = Result(photo, size, config, fitted, title, file_options=file_options, form=form, keeps_paths=True)
    return replace(result, start_psnr=replace(result, fitted=replace(fitted, scene=start)).file_psnr)
