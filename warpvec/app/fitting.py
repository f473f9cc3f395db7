"""Do a job of the page: read its picture, draw it, and describe the result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.app.frames import Best, FrameWriter
from warpvec.app.messages import FitJob
from warpvec.app.settings import FitSettings
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.given import encoding_like, place_on_picture, read_drawing
from warpvec.drawing.not_kept import not_kept
from warpvec.edit import cut_out
from warpvec.goals.search import within_limit
from warpvec.image.picture import reduce_image
from warpvec.image.read import read_picture
from warpvec.modes.choice import chosen_mode, draw_picture
from warpvec.modes.flat import KnownOutlines
from warpvec.modes.path_count import CORRECTION_RATE
from warpvec.modes.photo import Photo
from warpvec.modes.refine import ITERATIONS, with_drawing_settings
from warpvec.modes.request import Request
from warpvec.modes.restored import Restoration
from warpvec.polish.edited import BY_HAND, Edited, fit_again
from warpvec.polish.erasing import erase, hole_of, wanted_picture
from warpvec.polish.recoloured import in_colors_of
from warpvec.result import Result
from warpvec.svg.measure import file_facts, file_quality
from warpvec.svg.write import runs_of
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Watch

LATE_SHARE = 0.5
"""Share of a whole fit from which on its drawing is close to its end, so that going on takes small steps."""

SHORT_UNITS = 2
"""Units per pixel from which on a drawing has the short form that a goal in bytes asks for. That form has whole numbers
for coordinates, mostly in several units per pixel. Other drawings have one unit per pixel: 2 is the least that tells
them apart. *Fit again* keeps the units of a short drawing, as decimals would double the file."""

LOST_BY_CUTTING = ("translucency", "softness")
"""What a drawing may lose when it is cut; see `warpvec.drawing.not_kept`."""


def run_job(
    job: FitJob,
    report: Callable[[str, dict[str, Any]], None],
    watch: Watch,
    threads: int | None,
    outlines: KnownOutlines | None = None,
) -> dict[str, Any]:
    """Return the facts of the drawing that ``job`` asks for; see `result_facts`.

    Args:
        job: what to do.
        report: called with "mode" and facts when the kind of picture is known, and again if it proves to be another;
            and with "frame" and the present drawing, if the watch has a function to be called after iterations.
        watch: progress and stop of the job.
        threads: CPU threads; None for all cores.
        outlines: of the picture of the last job, for a job that changes its detail; they become those of this job.

    Raises:
        InputError: the picture or the drawing to go on from cannot be read, or the settings do not fit together.
    """
    pixels, unread, _ = read_picture(job.data, name="picture")
    given = pixels
    mode, reason, known, best = job.settings.mode, None, None, None
    if mode == "auto":
        known = Restoration.of(_request(job, pixels, job.settings.config("flat"), watch))
        palette = None if known.condition is None else known.condition.palette
        if job.start is None and job.erased is None and palette is not None and palette.has_two_levels:
            best = _rough(job, pixels, "flat", report, watch, threads)  # choosing between its kinds takes seconds
        mode, reason, _ = chosen_mode(known.request.picture.sharp_copy, known.given.settings, known.condition)
    height, width = pixels.shape[:2]
    report("mode", {"mode": mode, "reason": reason, "width": width, "height": height})
    hole = None if job.erased is None else hole_of(pixels, job.erased)
    if hole is not None:
        pixels = erase(pixels, hole)
    if mode == "photo":
        best = None
    elif best is None and not (job.start is not None and (job.cuts or job.keeps_paths)):
        best = _rough(job, pixels, mode, report, watch, threads)
    _show_frames(watch, FrameWriter(width, height, partial(report, "frame"), best))
    if job.start is not None and job.cuts:
        return _cut_facts(job, given, watch)
    if job.start is not None and job.keeps_paths:
        if job.before is not None:
            before = job.before if mode == "photo" else in_colors_of(pixels, job.before)
            pixels = wanted_picture(pixels, before, job.start, hole)
        drawing = _fit_again(job, pixels, mode, threads, watch)
    elif mode == "photo":
        drawing = _photo(job, pixels, threads, watch)
    else:
        config = replace(job.settings.config(mode), threads=threads)
        if job.settings.mode == "auto":  # the drawing may show that it is rather a photo
            config = replace(config, mode="auto")
        drawing = draw_picture(_request(job, pixels, config, watch), outlines=outlines, known=known)
    result = Result(drawing, watch.facts())
    is_fitted_again = job.start is not None and job.keeps_paths
    if not is_fitted_again and result.config.mode != mode:  # its drawing has shown that the picture is of another kind
        kind = {"mode": result.config.mode, "reason": drawing.mode_reason}
        report("mode", {**kind, "width": width, "height": height})
    facts = result_facts(result, None if pixels is given else given, is_fitted_again=is_fitted_again)
    if unread and facts["not_kept"] is not None:
        facts["not_kept"].insert(0, unread)
    return facts


def _rough(
    job: FitJob,
    pixels: NDArray[np.float32],
    mode: str,
    report: Callable[[str, dict[str, Any]], None],
    watch: Watch,
    threads: int | None,
) -> Best:
    """Return the rough drawing of ``pixels``, and report it as a frame if the job begins with no drawing."""
    best = Best.rough(pixels, reduce_image(pixels, job.settings.config(mode).fit_size), threads)
    if job.start is None and watch.on_progress is not None:
        report("frame", {**best.facts(), "iteration": 0, "iterations": 0, "seconds": watch.seconds(), "left": None})
    return best


def _show_frames(watch: Watch, writer: FrameWriter) -> None:
    """Let ``writer`` see each iteration, after the function that is called already; without one nobody looks."""
    before = watch.on_progress
    if before is None:
        return

    def show(progress: Progress) -> None:
        before(progress)
        writer(progress)

    watch.on_progress = show


def _cut_facts(job: FitJob, pixels: NDArray[np.float32], watch: Watch) -> dict[str, Any]:
    """Return the facts of the drawing of the job without overlaps. What was lost before is not said again."""
    assert job.start is not None
    data = job.start.encode()
    given, request = read_drawing(data), _request(job, pixels, job.settings.config("flat"), watch)
    encoding = encoding_like(given, data, request.encoding.of_drawing())
    encoding = replace(encoding, title=request.picture.title, metadata=encoding.metadata or BY_HAND)
    start = place_on_picture(given, request.picture).scaled(*request.picture.reduction)
    drawing = cut_out(Drawing.of(start, encoding, "cpu"), watch)
    lost = [words for name, words in not_kept(drawing).items() if name in LOST_BY_CUTTING]
    return {**result_facts(Result(drawing, watch.facts())), "not_kept": lost}


def _request(job: FitJob, pixels: NDArray[np.float32], config: FitConfig, watch: Watch) -> Request:
    return Request.of(pixels, config, job.settings.goal, title=job.name, watch=watch)


def _fit_again(job: FitJob, pixels: NDArray[np.float32], mode: str, threads: int | None, watch: Watch) -> Drawing:
    """Fit the edited drawing of the job. Deleted parts are filled in photos only; areas of flat art need none.

    What was filled in and moved nodes make a file longer: the paths of a photo that are seen least go until it keeps to
    the goal. Each shape of flat art is wanted.
    """
    assert job.start is not None
    settings = FitSettings({"mode": "photo", "opacity": job.settings.values["opacity"]})
    config = replace(settings.config("photo"), threads=threads, recycle_gap=0)
    if job.settings.goal and read_drawing(job.start.encode()).width >= SHORT_UNITS * pixels.shape[1]:
        config = replace(config, minify=True, units=1)
    edited = Edited(job.start, job.locked, job.filled if mode == "photo" else None, mode == "photo")
    drawing, locked = fit_again(edited, _request(job, pixels, config, watch).encoding, watch)
    return within_limit(drawing, job.settings.goal, locked) if mode == "photo" else drawing


def result_facts(
    result: Result, given: NDArray[np.float32] | None = None, *, is_fitted_again: bool = False
) -> dict[str, Any]:
    """Return the SVG text and the figures of its file that the page shows.

    Args:
        result: the drawing.
        given: the picture [h, w, 3 or 4] to measure the file against; None for that of the drawing, which differs if
            the user has edited what is to be drawn.
        is_fitted_again: whether an edited drawing was fitted, which has lost no more than the one before.
    """
    text = result.svg()
    psnr = result.file_psnr if given is None else file_quality(text.encode(), given)["psnr"]
    return {
        "svg": text,
        **file_facts(text),
        "psnr": psnr if math.isfinite(psnr) else None,
        "seconds": result.run.seconds,
        "stopped": result.interrupted,
        "mode": result.config.mode,
        "history": [entry for entry in result.history if math.isfinite(entry["psnr"])],
        "layers": _layers(result),
        "not_kept": None if is_fitted_again else list(not_kept(result.drawing).values()),
    }


def _layers(result: Result) -> list[dict[str, Any]] | None:
    """Return name and number of paths of each layer of a file that is too short to state them; None if it does."""
    encoding, generation = result.encoding, result.scene.generation.numpy()
    if not encoding.is_minified or not len(generation):
        return None
    names = encoding.layer_names or {}
    runs = [(int(generation[start]), stop - start) for start, stop in runs_of(generation)]
    return [{"name": names.get(level, f"Pass {level + 1}"), "count": count} for level, count in runs]


def _photo(job: FitJob, pixels: NDArray[np.float32], threads: int | None, watch: Watch) -> Drawing:
    """Fit a photo, from nothing or from the drawing of the job."""
    values, goal = job.settings.given("photo"), job.settings.goal
    if job.start is None:
        config = replace(make_config(**values), threads=threads)
        return draw_picture(_request(job, pixels, config, watch))
    drawing = read_drawing(job.start.encode())
    is_late = job.done_share >= LATE_SHARE
    kept = {"minify": bool(goal)} if is_late else {"minify": bool(goal), "recycle_gap": FitConfig.recycle_gap}
    values = with_drawing_settings({**kept, **values}, drawing)
    config = replace(make_config(**values), threads=threads)
    if not goal:
        left = max(ITERATIONS, round((1.0 - job.done_share) * config.iterations))
        rate = CORRECTION_RATE if is_late else 1.0
        config = replace(config, iterations=left, lr_scale=rate * config.lr_scale)
    request = _request(job, pixels, config, watch)
    return draw_picture(request, Photo(start=place_on_picture(drawing, request.picture).outlined()))
