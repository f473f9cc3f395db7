"""Fit an SVG that exists already to its photo, and give it more detail."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.config.rules import require_scaffolding
from warpvec.errors import InputError
from warpvec.fit.progress import OnProgress
from warpvec.geometry.scene import Scene
from warpvec.image.read import ImageSource, read_image
from warpvec.inputs import read_file
from warpvec.rendering.launch import resolve_device
from warpvec.svg.document import MAX_SVG_BYTES
from warpvec.svg.read import LoadedSvg, read_svg
from warpvec.vectorization.api import fit_photo, title_of
from warpvec.vectorization.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.vectorization.goal import CORRECTION_RATE, Goal, is_auto, with_curves
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
    on_progress: OnProgress | None = None,
    **settings: Any,
) -> Result:
    """Fit the paths of ``svg`` to ``image``.

    Args:
        image: the photo, as `warpvec.vectorize` takes it.
        svg: a path, or the text or the bytes of a file: warpvec's own, or any of filled paths. Strokes are left out,
            gradients become one colour, and holes drawn by the even-odd rule may be filled. Its layers stay.
        curves: number of paths, by default as many as there are. New ones are added on top, where the picture is
            worst; those with the lowest removal cost are removed. "auto" and goals as in `warpvec.vectorize`.
        preset, background, max_bytes, gzip, target_psnr, metadata, trim, on_progress: as in `warpvec.vectorize`.
        settings: fields of `warpvec.FitConfig` that replace those of the preset. ``recycle_gap`` is 0 by default,
            ``precision`` that of the file, and ``iterations`` 500 without a goal.

    Raises:
        InputError: the photo or the SVG cannot be read, they do not match, or a setting is wrong.
    """
    drawing = read_drawing(_svg_data(svg))
    goal = Goal(max_bytes=max_bytes, gzip=gzip, target_psnr=target_psnr, auto=is_auto(curves))
    given = settings if curves is None else {**settings, "curves": curves}
    config = make_config(preset, **with_curves(with_drawing_settings(settings, drawing), curves, goal))
    config = refine_config(config, given, goal, drawing)
    file_options = FileOptions(metadata=metadata, trim=trim)
    resolve_device(config.device)
    photo = read_image(image, background, name="image")
    return refine_photo(
        photo,
        place_on_photo(drawing, photo),
        config,
        goal,
        title=title_of(image),
        on_progress=on_progress,
        file_options=file_options,
    )


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
        InputError: the number of segments is not that of the drawing.
    """
    segments = drawing.scene.piece_count
    if given.get("segments", segments) != segments:
        raise InputError("segments", f"must be {segments}, as in the SVG", str(given["segments"]), "leave it out")
    decided = {"recycle_gap": 0, "segments": segments}
    if drawing.precision is not None:
        decided["precision"] = drawing.precision
    return {**decided, **given}


def refine_config(config: FitConfig, given: dict[str, Any], goal: Goal, drawing: LoadedSvg) -> FitConfig:
    """Return ``config`` with the number of iterations and paths that are not ``given`` and that no goal decides.

    Raises:
        InputError: fits with these settings cannot begin with a drawing.
    """
    if config.path_model != "segments":
        remedy = "give segments, or another preset"
        raise InputError("path_model", "must be segments to refine a drawing", repr(config.path_model), remedy)
    require_scaffolding(config.policy, "to refine a drawing")
    if goal:
        return config
    defaults: dict[str, Any] = {"iterations": ITERATIONS, "curves": max(1, len(drawing.scene))}
    return replace(config, **{name: value for name, value in defaults.items() if name not in given})


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
) -> Result:
    """Fit from ``start``, in pixels of the photo, with small steps. A goal's search sets the steps by itself."""
    if not goal:
        config = replace(config, lr_scale=CORRECTION_RATE * config.lr_scale)
    return fit_photo(
        photo, config, title=title, goal=goal, start=start, on_progress=on_progress, file_options=file_options
    )


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
