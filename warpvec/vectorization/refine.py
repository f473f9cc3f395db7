"""Fit an SVG that exists already to its photo, and give it more detail."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import MINIFIED, make_config
from warpvec.config.rules import require_scaffolding
from warpvec.errors import InputError
from warpvec.fit.progress import OnProgress
from warpvec.geometry.joints import with_lines, without_kinds
from warpvec.geometry.scene import Scene, over_white
from warpvec.image.alpha import is_transparent
from warpvec.image.metrics import psnr
from warpvec.image.read import ImageSource, read_image
from warpvec.inputs import read_file
from warpvec.rendering.launch import resolve_device
from warpvec.svg.document import MAX_SVG_BYTES, read_text
from warpvec.svg.measure import draw_like
from warpvec.svg.read import LoadedSvg, read_svg
from warpvec.vectorization.api import fit_photo, title_of
from warpvec.vectorization.file_form import FileForm, description_of
from warpvec.vectorization.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.vectorization.goal import CORRECTION_RATE, Goal, is_auto, with_curves
from warpvec.vectorization.minified_form import finer_form, flat_units
from warpvec.vectorization.polishing import polish_photo
from warpvec.vectorization.result import Result

ITERATIONS = 500
"""Default number of iterations, that of a correction with the default preset."""


def refine(
    image: ImageSource,
    svg: str | os.PathLike[str] | bytes,
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
    free: bool = False,
    on_progress: OnProgress | None = None,
    **settings: Any,
) -> Result:
    """Fit the paths of ``svg`` to ``image``.

    Unless paths are added or removed, the drawing keeps its size and structure, and gets no worse: see
    `warpvec.fit.polish.polish`. If the given file, as resvg draws it, is at least as good as all that the fit found,
    its text is the result, unchanged.

    Args:
        image: the photo, as `warpvec.vectorize` takes it.
        svg: a path, or the text or the bytes of a file of filled paths. Other content is left out.
        curves: number of paths, by default as many as there are. New ones are added where the picture is worst; those
            with the lowest removal cost are removed. "auto" and goals as in `warpvec.vectorize`.
        free: let smooth nodes become corners, lines curves, opaque paths translucent, and paths cross themselves.
        preset, background, max_bytes, gzip, target_psnr, metadata, trim, size, on_progress: as in `warpvec.vectorize`.
        settings: fields of `warpvec.FitConfig` that replace those of the preset. ``recycle_gap`` is 0 by default,
            ``precision`` that of the file, and ``iterations`` at most 500 without a goal; 0 writes the drawing as it
            was read. ``opacity="opaque"`` first makes every path opaque, which may make the drawing worse.

    Raises:
        InputError: the photo or the SVG cannot be read, they do not match, or a setting is wrong.
    """
    data = _svg_data(svg)
    goal = Goal(max_bytes=max_bytes, gzip=gzip, target_psnr=target_psnr, auto=is_auto(curves))
    drawing, config, count = _prepared(data, preset, settings, curves, goal)
    resolve_device(config.device)
    photo = read_image(image, background, name="image")
    start, form = place_on_photo(drawing, photo), form_of(drawing, data, config, photo)
    kept: dict[str, Any] = {"title": title_of(image), "form": form, "iterations": count, "free": free, "given": data}
    kept["file_options"] = FileOptions(metadata=metadata, trim=trim, size=size)
    return refine_photo(photo, start, config, goal, on_progress=on_progress, **kept)


def _prepared(
    data: bytes, preset: str, settings: dict[str, Any], curves: int | str | None, goal: Goal
) -> tuple[LoadedSvg, FitConfig, int | None]:
    """Return the drawing, the settings of its fit, and 0 if there is no fit, else None."""
    drawing = read_drawing(data)
    given = settings if curves is None else {**settings, "curves": curves}
    settings, is_fitted = (settings, True) if goal else without_zero_iterations(settings)
    config = make_config(preset, **with_curves(with_drawing_settings(settings, drawing), curves, goal))
    return drawing, refine_config(config, given, goal, drawing), None if is_fitted else 0


def without_zero_iterations(given: dict[str, Any]) -> tuple[dict[str, Any], bool]:
    """Return the ``given`` settings without ``iterations`` of 0, which no fit has, and whether there is a fit."""
    if given.get("iterations") != 0:
        return given, True
    return {name: value for name, value in given.items() if name != "iterations"}, False


def form_of(drawing: LoadedSvg, data: bytes, config: FitConfig, photo: NDArray[np.float32]) -> FileForm:
    """Return what the file keeps of a drawing given as ``data``: size, units, title, metadata, names of layers.

    A drawing whose sides are not whole numbers gets those of the photo. Units larger than a pixel get more decimals.
    """
    is_whole = drawing.width.is_integer() and drawing.height.is_integer()
    size = (int(drawing.height), int(drawing.width)) if is_whole else (photo.shape[0], photo.shape[1])
    more = max(0, math.ceil(math.log10(photo.shape[1] / size[1]) - 1e-9)) if drawing.precision is None else 0
    title, metadata = description_of(data)
    form = FileForm(size, config.precision + more, title, metadata, drawing.sides, drawing.layer_names)
    if not config.minify:
        return form
    is_exact = drawing.precision is not None and not config.grid
    form = finer_form(form, 10**form.precision if is_exact else flat_units(config))
    generation = drawing.scene.generation
    return form._replace(keeps_layers=drawing.minified and int(generation.max()) > int(generation.min()))


def read_drawing(data: bytes, name: str = "svg") -> LoadedSvg:
    """Read the SVG to begin with; messages call it ``name``.

    Raises:
        InputError: it is not an SVG, or it has no filled paths.
    """
    try:
        drawing = read_svg(data)
    except InputError as error:
        raise error.renamed({"SVG": name}) from error
    if not len(drawing.scene):
        raise InputError(name, "must contain filled paths", "an SVG without any", "vectorize the image from scratch")
    return drawing


def with_drawing_settings(given: dict[str, Any], drawing: LoadedSvg) -> dict[str, Any]:
    """Return the ``given`` settings with the defaults that depend on the drawing.

    Raises:
        InputError: the number of segments is not that of the drawing, or the mode is not that of photos.
    """
    mode = given.get("mode", "photo")
    if mode not in ("auto", "photo"):
        remedy = "leave it out, or vectorize the image from scratch"
        raise InputError("mode", "must be photo to refine a drawing", repr(mode), remedy)
    given = {**given, "mode": "photo"}
    decided: dict[str, Any] = {"recycle_gap": 0, "minify": drawing.minified}
    if given.get("minify", drawing.minified):  # the drawing has its paths already
        decided |= {name: getattr(FitConfig(), name) for name in MINIFIED}
        decided["opacity"] = "common" if _has_common_opacity(drawing.scene) else "free"
    if drawing.scene.is_uniform:
        segments = drawing.scene.piece_count
        if given.get("segments", segments) != segments:
            raise InputError("segments", f"must be {segments}, as in the SVG", str(given["segments"]), "leave it out")
        decided["segments"] = segments
    if drawing.precision is not None:
        decided["precision"] = drawing.precision
    return {**decided, **given}


def _has_common_opacity(scene: Scene) -> bool:
    """Return whether all paths are equally translucent, which a minified file states once."""
    opacity = scene.opacity
    return len(opacity) > 1 and bool((opacity == opacity[0]).all()) and float(opacity[0]) < 1.0


def refine_config(config: FitConfig, given: dict[str, Any], goal: Goal, drawing: LoadedSvg) -> FitConfig:
    """Return ``config`` with the number of iterations and paths that are not ``given`` and that no goal decides.

    Raises:
        InputError: fits with these settings cannot begin with a drawing, or need iterations and have none.
    """
    if config.path_model != "segments":
        remedy = "give segments, or another preset"
        raise InputError("path_model", "must be segments to refine a drawing", repr(config.path_model), remedy)
    require_scaffolding(config.policy, "to refine a drawing")
    if goal:
        return config
    if given.get("iterations") == 0:
        _require_no_change(config, given, drawing)
    defaults: dict[str, Any] = {"iterations": ITERATIONS, "curves": max(1, len(drawing.scene)), "gradients": 0.0}
    return replace(config, **{name: value for name, value in defaults.items() if name not in given})


def _require_no_change(config: FitConfig, given: dict[str, Any], drawing: LoadedSvg) -> None:
    """Refuse ``given`` settings that change the paths or paints of the drawing, which only iterations do."""
    asked = {name: getattr(config, name) for name in ("colors", "palette", "gradients", "lod", "min_area")}
    if given.get("curves", len(drawing.scene)) != len(drawing.scene):
        asked = {"curves": config.curves, **asked}
    for name, value in asked.items():
        if value:
            raise InputError(name, "must not be given with 0 iterations", remedy="leave it out, or give iterations")


def place_on_photo(drawing: LoadedSvg, photo: NDArray[np.float32], name: str = "svg") -> Scene:
    """Return the scene of the drawing in pixels of the photo; messages call the drawing ``name``.

    Raises:
        InputError: their proportions differ by more than a pixel of rounding.
    """
    height, width = photo.shape[:2]
    if abs(drawing.width * height / drawing.height - width) > max(1.0, width / height):
        size = f"{drawing.width:g} x {drawing.height:g}"
        rule = f"must have the proportions of the photo, {width} x {height}"
        raise InputError(name, rule, size, "give the photo that it was made from")
    return drawing.scene.scaled(width / drawing.width, height / drawing.height)


def refine_photo(
    photo: NDArray[np.float32],
    start: Scene,
    config: FitConfig,
    goal: Goal,
    *,
    title: str | None = None,
    on_progress: OnProgress | None = None,
    file_options: FileOptions = DEFAULT_FILE_OPTIONS,
    form: FileForm | None = None,
    iterations: int | None = None,
    free: bool = False,
    given: bytes | None = None,
) -> Result:
    """Fit from ``start``, in pixels of the photo: as `polish` does if the paths stay the same, else with small steps.

    A goal's search sets the steps by itself.

    Args:
        form: what the file keeps of the drawing.
        iterations: instead of those of ``config``.
        free: as in `refine`.
        given: the file of the drawing, whose PSNR becomes ``start_psnr``. If it is as good as the result, and nothing
            asks for a change, its text is written unchanged.
    """
    if iterations != 0 and not is_transparent(photo):
        start = over_white(start)
    result = _fitted(photo, start, config, goal, title, on_progress, file_options, form, iterations, free)
    if given is None:
        return result
    result = replace(result, start_psnr=psnr(draw_like(given, photo), photo))
    is_fit = keeps_structure(config, start, goal) and iterations != 0
    return _not_worse(result, read_text(given)) if is_fit else result


def _not_worse(result: Result, given: str) -> Result:
    """Return ``result`` with the text of the ``given`` file if this is as good, and no option asks for a change.

    A file can state more than a scene does, such as a gradient of many stops or a stroke, and with more decimals.
    """
    options = result.file_options
    changes_file = options.trim or options.size is not None or (not options.metadata and "<metadata" in given)
    if changes_file or result.config.opacity == "opaque":
        return result
    assert result.start_psnr is not None
    return replace(result, unchanged=given) if result.start_psnr >= result.file_psnr else result


def _fitted(
    photo: NDArray[np.float32],
    start: Scene,
    config: FitConfig,
    goal: Goal,
    title: str | None,
    on_progress: OnProgress | None,
    file_options: FileOptions,
    form: FileForm | None,
    iterations: int | None,
    free: bool,
) -> Result:
    if keeps_structure(config, start, goal) or iterations == 0:
        count = config.iterations if iterations is None else iterations
        if count:
            start = without_kinds(start) if free else with_lines(start)
        return polish_photo(photo, start, config, count, title, on_progress, file_options, form, free)
    if not goal:
        config = replace(config, lr_scale=CORRECTION_RATE * config.lr_scale)
    return fit_photo(
        photo, config, title=title, goal=goal, start=start, on_progress=on_progress, file_options=file_options
    )


def keeps_structure(config: FitConfig, start: Scene, goal: Goal) -> bool:
    """Return whether the settings only move what ``start`` has: no other paths, no palette, no levels.

    Gradients are paints that flat paths may get.
    """
    adds_nothing = not goal and config.curves == len(start) and config.recycle_gap == 0
    is_plain = config.palette is None and config.colors == 0 and not config.lod and config.z_order == "creation"
    return adds_nothing and is_plain and config.renderer == "exact" and config.min_area == 0


def _svg_data(svg: str | os.PathLike[str] | bytes) -> bytes:
    """Return the bytes of an SVG given as a path, its text or its bytes."""
    if isinstance(svg, bytes):
        return svg
    if isinstance(svg, str) and svg.lstrip().startswith("<"):
        return svg.encode()
    kind = "an SVG file, its text or its bytes"
    if not isinstance(svg, str | os.PathLike):
        raise InputError("svg", f"must be {kind}", type(svg).__name__, "convert it")
    return read_file(svg, MAX_SVG_BYTES, "svg", kind)
