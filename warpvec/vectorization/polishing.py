"""Polish a drawing: the fit that keeps its structure, and the choice between its result and the drawing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.fit.polish import polish
from warpvec.fit.progress import OnProgress
from warpvec.geometry.scene import Scene, over_white
from warpvec.image.resize import reduce_image
from warpvec.vectorization.file_form import FileForm
from warpvec.vectorization.file_options import FileOptions
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
) -> Result:
    """Fit ``start``, in pixels of the ``photo``, and return the file that resvg draws best: the fitted one or its own.

    Without iterations the file keeps the title and the settings that it states. If ``config`` asks for opaque paths,
    ``start`` is made opaque before; the file may then be worse than the drawing was.
    """
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
    if form is not None and iterations:
        form = form._replace(title=title, metadata=None)
    fitted = polish(pixels, reduced, config, on_progress, iterations=iterations, free=free)
    result = Result(photo, size, config, fitted, title, file_options=file_options, form=form, keeps_paths=True)
    first = replace(result, fitted=replace(fitted, scene=reduced))
    before = first.file_psnr
    is_better = iterations > 0 and result.file_psnr >= before
    if not torch.equal(given.opacity, reduced.opacity):
        before = replace(first, fitted=replace(fitted, scene=given)).file_psnr
    return replace(result if is_better else first, start_psnr=before)
