"""Flat art: from a picture of a logo, an icon, a drawing or a scan to a `Result` of few clean paths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.interrupt import deferred_interrupts
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.progress import OnProgress
from warpvec.flat.classify import Choice
from warpvec.flat.cutting.cutout import Cutout, cut_out
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.layering import layered
from warpvec.flat.mono_drawing import MonoDrawing
from warpvec.geometry.scene import Scene
from warpvec.image.resize import reduce_image
from warpvec.vectorization.detail_search import DetailSearch
from warpvec.vectorization.file_form import FileForm
from warpvec.vectorization.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.vectorization.goal import Goal
from warpvec.vectorization.minified_form import finer_form, flat_units
from warpvec.vectorization.result import Result


@dataclass
class Outlines:
    """The outlines of the last picture of flat art, to go on from when only the detail, cutout or goal is another."""

    may_refuse: bool = False
    """Whether drawings that begin may refuse a picture that is plainly no flat art."""
    _drawing: FlatDrawing | None = None

    def begin(
        self,
        image: Tensor,
        config: FitConfig,
        on_progress: OnProgress | None,
        is_interrupted: Callable[[], bool],
    ) -> FlatDrawing:
        """Return the work on ``image`` with ``config``: with the known outlines if they are right for it."""
        known = self._drawing
        same: dict[str, Any] = {"detail": config.detail, "cutout": config.cutout, "minify": config.minify}
        if known is not None and replace(known.config, **same) == config and torch.equal(known.image, image):
            drawing = known.again(on_progress, is_interrupted)
        else:
            drawing = FlatDrawing(image, config, on_progress, is_interrupted)
        drawing.may_refuse = self.may_refuse
        return drawing

    def keep(self, drawing: FlatDrawing) -> None:
        """Keep the outlines of a whole ``drawing``; one that was interrupted may have poor ones."""
        if not drawing.is_over():
            self._drawing = drawing


def fit_flat(
    photo: NDArray[np.float32],
    config: FitConfig,
    *,
    title: str | None = None,
    goal: Goal | None = None,
    on_progress: OnProgress | None = None,
    file_options: FileOptions = DEFAULT_FILE_OPTIONS,
    choice: Choice | None = None,
    may_refuse: bool = False,
    outlines: Outlines | None = None,
) -> Result:
    """Draw the flat art ``photo`` [h, w, 3 or 4], as `read_image` returns it, reduced to ``config.fit_size``.

    Args:
        config: settings of the run, with the mode flat or mono.
        goal: requirements on the file; they decide the detail and, if need be, the number of paths.
        on_progress: called after every iteration of the fits.
        file_options: choices about the file alone.
        choice: why the mode is that one, for the summary; None if it was asked for.
        may_refuse: whether to refuse a picture that is plainly no flat art.
        outlines: of the last picture, which becomes this one; None to keep none.

    Raises:
        NotFlatArtError: the picture is plainly no flat art, and ``may_refuse``.
    """
    target = reduce_image(photo, config.fit_size)
    size = (target.shape[0], target.shape[1])
    reduced = replace(config, min_area=config.min_area * target[..., 0].size / photo[..., 0].size)
    form = _form(photo, config, title)
    kept = Outlines() if outlines is None else outlines
    kept.may_refuse = may_refuse
    with deferred_interrupts() as is_interrupted, single_torch_thread(), torch.no_grad():
        begin = kept.begin if config.mode == "flat" else MonoDrawing
        drawing = begin(torch.from_numpy(target), reduced, on_progress, is_interrupted)

        def draw(detail: float) -> Result:
            fitted = drawing.draw(detail)
            if isinstance(drawing, FlatDrawing):
                kept.keep(drawing)
            scene, left_out = _without_overlaps(fitted.scene, size, form, config.cutout)
            found = layered(scene)
            return Result(
                photo, size, replace(config, detail=detail), replace(fitted, scene=found.scene), title,
                file_options=file_options, form=form, keeps_paths=True, layer_names=found.names, choice=choice,
                left_out={**drawing.left_out, **left_out},
            )  # fmt: skip

        if not goal:
            return draw(config.detail)
        return DetailSearch(goal, draw, drawing.is_over, can_lose_paths=not config.cutout).run(config.detail)


def _form(photo: NDArray[np.float32], config: FitConfig, title: str | None) -> FileForm:
    """Return the form of the file, in which smooth nodes stay smooth."""
    form = FileForm((photo.shape[0], photo.shape[1]), config.precision, title)
    return finer_form(form, flat_units(config)) if config.minify else form


def _without_overlaps(
    scene: Scene, size: tuple[int, int], form: FileForm, is_cut: bool
) -> tuple[Scene, dict[str, int]]:
    """Return ``scene``, cut out if ``is_cut``, and how many of its parts that has left out."""
    if not is_cut:
        return scene, {}
    cut = _cut(scene, size, form)
    more = {"hidden path": cut.hidden_count, "sliver": cut.sliver_count, "translucent fill": cut.blended_count}
    return cut.scene, more


def _cut(scene: Scene, size: tuple[int, int], form: FileForm) -> Cutout:
    """Return ``scene``, of a fitted image of this ``size``, without overlaps, with points where the file has ticks."""
    ticks = [side / whole / 10**form.precision for side, whole in zip(size, form.size, strict=True)]
    return cut_out(scene, size[1], size[0], (ticks[1], ticks[0]))
