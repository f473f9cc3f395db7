"""Do a job of the page: read its picture, fit it, and describe the result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.app.again import fit_again
from warpvec.app.erasing import erase, hole_of
from warpvec.app.messages import Job
from warpvec.app.settings import FitSettings
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.fit.progress import OnProgress
from warpvec.flat.classify import choose_mode
from warpvec.image.read import read_image
from warpvec.image.resize import reduce_image
from warpvec.svg.measure import file_facts
from warpvec.vectorization.api import fit_photo
from warpvec.vectorization.flat_art import Outlines
from warpvec.vectorization.goal import CORRECTION_RATE
from warpvec.vectorization.refine import ITERATIONS, place_on_photo, read_drawing, with_drawing_settings
from warpvec.vectorization.result import Result

LATE_SHARE = 0.5
"""Share of a whole fit from which on its drawing is close to its end, so that going on takes small steps."""


def run_job(
    job: Job,
    report: Callable[[str, dict[str, Any]], None],
    on_progress: OnProgress,
    threads: int | None,
    outlines: Outlines | None = None,
) -> Result:
    """Return the drawing that ``job`` asks for.

    Args:
        job: what to do.
        report: called with "mode" and facts when the kind of picture is known.
        on_progress: called after every iteration.
        threads: CPU threads; None for all cores.
        outlines: of the picture of the last job, for one that changes its detail; it becomes that of this job.

    Raises:
        InputError: the picture or the drawing to go on from cannot be read, or the settings do not fit together.
    """
    photo = read_image(job.data, name="picture")
    mode, reason = job.settings.mode, None
    if mode == "auto":
        mode, reason = choose_mode(reduce_image(photo, FitConfig.fit_size))
    height, width = photo.shape[:2]
    report("mode", {"mode": mode, "reason": reason, "width": width, "height": height})
    if job.erased is not None:
        photo = erase(photo, hole_of(photo, job.erased))
    if job.start is not None and job.keeps_paths:
        settings = FitSettings(mode="photo", opaque=job.settings.opaque)
        config = replace(settings.config("photo"), threads=threads, recycle_gap=0)
        return fit_again(job, photo, mode, config, on_progress)
    if mode == "photo":
        return _photo(job, photo, threads, on_progress)
    config = replace(job.settings.config(mode), threads=threads)
    if job.settings.mode == "auto":  # the drawing may show that it is rather a photo
        config = replace(config, mode="auto")
    goal = job.settings.goal
    return fit_photo(photo, config, title=job.name, goal=goal, on_progress=on_progress, outlines=outlines)


def result_facts(result: Result) -> dict[str, Any]:
    """Return the SVG text and the figures of its file that the page shows."""
    text = result.svg()
    facts = file_facts(text)
    psnr = result.file_psnr
    return {
        "svg": text,
        "paths": facts["paths"],
        "segments": facts["segments"],
        "bytes": facts["bytes"],
        "gzip_bytes": facts["gzip_bytes"],
        "psnr": psnr if math.isfinite(psnr) else None,
        "seconds": result.fitted.seconds,
        "stopped": result.interrupted,
        "mode": result.config.mode,
        "history": [entry for entry in result.history if math.isfinite(entry["psnr"])],
    }


def _photo(job: Job, photo: NDArray[np.float32], threads: int | None, on_progress: OnProgress) -> Result:
    """Fit a photo, from nothing or from the drawing of the job."""
    values, goal, start = job.settings.values("photo"), job.settings.goal, None
    if job.start is not None:
        drawing = read_drawing(job.start.encode())
        start = place_on_photo(drawing, photo)
        is_late = job.done_share >= LATE_SHARE
        kept = {"minify": bool(goal)} if is_late else {"minify": bool(goal), "recycle_gap": FitConfig.recycle_gap}
        values = with_drawing_settings({**kept, **values}, drawing)
    config = replace(make_config(**values), threads=threads)
    if start is not None and not goal:
        left = max(ITERATIONS, round((1.0 - job.done_share) * config.iterations))
        rate = CORRECTION_RATE if is_late else 1.0
        config = replace(config, iterations=left, lr_scale=rate * config.lr_scale)
    return fit_photo(photo, config, title=job.name, goal=goal, start=start, on_progress=on_progress)
