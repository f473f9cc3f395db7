"""The Python interface: turn a picture into a `Result`, or refine an SVG."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Unpack

from warpvec.checks import check_flag
from warpvec.drawing.file_options import FileOptions
from warpvec.drawing.given import read_drawing
from warpvec.errors import InputError
from warpvec.goals.goal import settings_and_goal
from warpvec.image.read import ImageSource, read_picture
from warpvec.inputs import read_file
from warpvec.keywords.signature import with_keywords
from warpvec.keywords.table import FILE_OPTIONS
from warpvec.keywords.typed import Keywords
from warpvec.modes.choice import draw_picture
from warpvec.modes.refine import Refine, blur_to_undo, refine_settings
from warpvec.modes.request import Request
from warpvec.rendering.launch import resolve_device
from warpvec.result import Result
from warpvec.svg.document import MAX_SVG_BYTES
from warpvec.watch.progress import OnProgress
from warpvec.watch.watch import Watch


@with_keywords
def vectorize(
    image: ImageSource,
    curves: int | str | None = None,
    *,
    preset: str = "default",
    background: str | None = None,
    page: int | None = None,
    metadata: bool = True,
    on_progress: OnProgress | None = None,
    **options: Unpack[Keywords],
) -> Result:
    """Turn ``image`` into closed Bezier paths.

    Args:
        image: a path, the bytes of an image file, a PIL image, or an array or torch tensor as
            `warpvec.image.read.read_image` takes it.
        curves: number of paths, by default 512; "auto" for as many as the image rewards. With a goal, which decides the
            number, it is the most that may be used.
        preset: name of one of `warpvec.PRESETS`.
        background: colour behind a transparent image; None keeps it transparent.
        page: of a TIFF or PDF file, from 1; None for the first.
        metadata: store the settings in the file.
        on_progress: called after every iteration; it should be quick.
        options: the keywords of `warpvec.keywords.typed.Keywords`. Settings replace those of the preset. Goals are
            ``max_bytes``, the largest size of the SVG text, after gzip if ``gzip`` is true; and ``target_psnr`` (dB) or
            ``target_ssim``, which the file must reach, drawn by resvg, with as few paths as possible. Choices about the
            file are ``size``, its width with a unit such as "90mm", ``trim``, ``plain_paths`` and others.

    Raises:
        InputError: the image cannot be read, or a setting is wrong.
    """
    asked, file_options = _asked(curves, metadata, options)
    config, goal = settings_and_goal(preset, asked)
    resolve_device(config.device)  # report an unknown device before reading the image
    title = title_of(image)
    pixels, unread, _ = read_picture(image, background, name="image", page=page)
    watch = Watch(on_progress, config.time_budget)
    request = Request.of(pixels, config, goal, title=title, unread=unread, options=file_options, watch=watch)
    return Result(draw_picture(request), watch.facts())


@with_keywords
def refine(
    image: ImageSource,
    svg: str | os.PathLike[str] | bytes,
    curves: int | str | None = None,
    *,
    preset: str = "default",
    background: str | None = None,
    page: int | None = None,
    metadata: bool = True,
    free: bool = False,
    on_progress: OnProgress | None = None,
    **options: Unpack[Keywords],
) -> Result:
    """Fit the paths of ``svg`` to ``image``.

    Unless paths are added or removed, the drawing keeps its size and structure, and gets no worse: see
    `warpvec.polish.polish.polish`. If the given file, as resvg draws it, is at least as good as all that the fit found,
    its text is the result, unchanged.

    Args:
        image: the picture, as `vectorize` takes it.
        svg: a path, or the text or the bytes of a file of filled paths. Other content is left out.
        curves: number of paths, by default as many as there are. New paths are added where the picture is worst; paths
            with the lowest removal cost are removed. "auto" and goals as in `vectorize`.
        free: let smooth nodes become corners, lines curves, opaque paths translucent, and paths cross themselves.
        preset, background, page, metadata, on_progress: as in `vectorize`.
        options: as in `vectorize`. ``recycle_gap`` is 0 by default, ``precision`` that of the file, and ``iterations``
            at most 500 without a goal; 0 writes the drawing as it was read. ``opacity="opaque"`` first makes every path
            opaque, which may make the drawing worse. ``blur`` is "0" by default: with a deviation in pixels or "auto",
            the drawing is blurred by it before it is compared with the picture, and the file is sharp.

    Raises:
        InputError: the picture or the SVG cannot be read, they do not match, or a setting is wrong.
    """
    data = _svg_data(svg)
    drawing = read_drawing(data)
    asked, file_options = _asked(curves, metadata, options)
    config, goal, iterations = refine_settings(drawing, preset, asked)
    resolve_device(config.device)
    pixels, unread, _ = read_picture(image, background, name="image", page=page)
    watch, title = Watch(on_progress, config.time_budget), title_of(image)
    request = Request.of(pixels, config, goal, title=title, unread=unread, options=file_options, watch=watch)
    mode = Refine(drawing, data, iterations, free, blur=blur_to_undo(asked))
    return Result(mode.draw(request), watch.facts())


def title_of(image: ImageSource) -> str | None:
    """Return the title of the SVG of ``image``: its file name without suffix, None if it is no path."""
    return Path(image).stem if isinstance(image, str | os.PathLike) else None


def _asked(curves: int | str | None, metadata: bool, options: Keywords) -> tuple[dict[str, Any], FileOptions]:
    """Return the settings and goals that are asked for, and the choices about the file."""
    check_flag("metadata", metadata)
    given: dict[str, Any] = {**options} if curves is None else {**options, "curves": curves}
    of_file = {name: given.pop(name) for name in FILE_OPTIONS if name in given}
    return given, FileOptions(no_metadata=not metadata, **of_file)


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
