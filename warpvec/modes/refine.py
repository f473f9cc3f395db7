"""Refine an existing drawing: fit it to its picture, keep its structure, and add detail if asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from warpvec.config.cross_rules import require_scaffolding
from warpvec.config.fit_config import SETTINGS, FitConfig
from warpvec.config.presets import MINIFIED
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.drawing.given import encoding_like, place_on_picture, precision_of
from warpvec.errors import InputError
from warpvec.geometry.joints import with_lines, without_kinds
from warpvec.geometry.scene import Scene, over_white
from warpvec.geometry.two_stops import with_two_stops
from warpvec.goals.goal import Goal, is_auto, settings_and_goal
from warpvec.goals.registry import QUANTITIES
from warpvec.goals.search import check_possible
from warpvec.modes.path_count import CORRECTION_RATE
from warpvec.modes.photo import Photo
from warpvec.modes.request import Request
from warpvec.modes.restored import measured, with_blur
from warpvec.svg.document import read_text
from warpvec.svg.read import LoadedSvg
from warpvec.svg.stroke_outlines import without_strokes

ITERATIONS = 500
"""Default number of iterations, that of a correction with the default preset."""


@dataclass(frozen=True, eq=False)
class Refine:
    """The mode that refines a drawing.

    Attributes:
        drawing: the drawing to begin with.
        data: the bytes of its file.
        iterations: 0 to write the drawing as it was read; None for the iterations of the settings.
        free: let smooth nodes become corners, lines curves, opaque paths translucent, and paths cross themselves.
        name: the drawing's name in messages.
        blur: blur of the picture that the drawing is to be without: a standard deviation in pixels, as a number, or
            "auto" for the measured one.
    """

    drawing: LoadedSvg
    data: bytes
    iterations: int | None = None
    free: bool = False
    name: str = "svg"
    blur: str = "0"

    def draw(self, request: Request) -> Drawing:
        """Return the refined drawing.

        If the paths stay, it keeps the structure and the form of the given file. Otherwise the drawing is fitted on
        like a photo, with small steps. If the given file is as good as the result, and nothing asks for a change but
        for more paths, the result is the given file.

        Raises:
            InputError: drawing and picture do not match, or as `Photo.draw`.
        """
        with request.watch:
            return self._drawn(request)

    def _drawn(self, request: Request) -> Drawing:
        start = place_on_picture(self.drawing, request.picture, self.name)
        check_possible(request.goal, request.encoding)
        keeps = keeps_structure(request.settings, start, request.goal)
        condition = measured(request) if self.blur == "auto" else None
        request = with_blur(request, self.blur, condition)
        if self.iterations == 0:
            found = self._as_read(request, start)
        elif keeps:
            found = self._polished(request, start)
        elif self.blur != "0":
            remedy = "leave it out, or the option that changes them"
            raise InputError("blur", "must not be given where paths are added, removed or painted anew", remedy=remedy)
        else:
            found = self._fitted_on(request, start)
        encoding = request.encoding
        psnr = encoding.psnr_as_fitted if request.picture.blur else encoding.text_psnr
        given = psnr(read_text(self.data))
        is_asked = not only_adds(request.settings, start, request.goal) or self._must_change(request)
        if is_asked or self.iterations == 0 or given < found.psnr_as_fitted:
            return replace(found, start_psnr=given, condition=condition)
        # Other kinds of files are made of the scene.
        return replace(self._as_read(request, start), start_psnr=given, condition=condition, given=read_text(self.data))

    def _as_read(self, request: Request, start: Scene) -> Drawing:
        from warpvec.polish.whole_drawing import drawing_as_read  # loads SciPy, which a photo does not need

        return drawing_as_read(start, self._encoding(request))

    def _encoding(self, request: Request) -> Encoding:
        return encoding_like(self.drawing, self.data, request.encoding)

    def _polished(self, request: Request, start: Scene) -> Drawing:
        if not request.picture.is_transparent:
            start = over_white(start)
        from warpvec.polish.whole_drawing import polish_drawing

        start = without_kinds(start) if self.free else with_lines(start)
        encoding = replace(self._encoding(request), title=request.picture.title, metadata=None)
        count = request.settings.iterations if self.iterations is None else self.iterations
        return polish_drawing(start, encoding, request.watch, count, free=self.free)

    def _fitted_on(self, request: Request, start: Scene) -> Drawing:
        """Return the drawing that a fit of a photo makes from ``start``. A goal's search sets the steps by itself.

        Forms become outlines: the fit gives nodes to paths and takes them away. It moves gradients of two opaque stops.
        """
        start = start.outlined()
        start = with_two_stops(without_strokes(start, self.name))
        if not request.picture.is_transparent:
            start = over_white(start)
        if not request.goal:
            rate = CORRECTION_RATE * request.settings.lr_scale
            request = request.with_settings(replace(request.settings, lr_scale=rate))
        return Photo(start=start).draw(request)

    def _must_change(self, request: Request) -> bool:
        """Return whether an option asks for another file than the given one.

        A file can state more than a scene does, such as a gradient of many stops or a stroke, and with more decimals.
        """
        options = request.encoding.options
        drops_metadata = options.no_metadata and "<metadata" in read_text(self.data)
        drops_dashes = options.no_dashes and "stroke-dasharray" in read_text(self.data)
        is_other = drops_metadata or drops_dashes or request.settings.opacity == "opaque"
        return options.trim or options.plain_paths or options.size is not None or is_other


def keeps_structure(config: FitConfig, start: Scene, goal: Goal) -> bool:
    """Return whether the settings only move what ``start`` has: no other paths, no palette, no levels.

    Gradients are paints that flat paths may get.
    """
    return config.curves == len(start) and only_adds(config, start, goal)


def only_adds(config: FitConfig, start: Scene, goal: Goal) -> bool:
    """Return whether the settings move what ``start`` has, and add paths at most."""
    has_all = not goal and config.curves >= len(start) and config.recycle_gap == 0
    is_plain = config.palette is None and config.colors == 0 and not config.lod and config.z_order == "creation"
    return has_all and is_plain and config.renderer == "exact" and config.min_area == 0


def refine_settings(
    drawing: LoadedSvg, preset: str, options: Mapping[str, object]
) -> tuple[FitConfig, Goal, int | None]:
    """Return the settings and the goal to refine ``drawing``, and 0 if it is written as it was read, else None.

    Args:
        drawing: the drawing to begin with.
        preset: name of a preset.
        options: the given settings and goals, as `settings_and_goal` takes them.

    Raises:
        InputError: the options do not suit the drawing, or as `settings_and_goal`.
    """
    has_goal = any(options.get(name) is not None for name in QUANTITIES) or is_auto(options.get("curves"))
    is_fitted = has_goal or options.get("iterations") != 0
    kept = {name: value for name, value in options.items() if name != "blur" and (is_fitted or name != "iterations")}
    config, goal = settings_and_goal(preset, with_drawing_settings(kept, drawing))
    return _completed(config, options, goal, drawing), goal, None if is_fitted else 0


def blur_to_undo(options: Mapping[str, object]) -> str:
    """Return the blur of the picture that the given ``options`` ask to undo: as `Refine`, "0" if they do not.

    Raises:
        InputError: it is out of range.
    """
    blur: str = SETTINGS["blur"].kind.check("blur", options.get("blur", "0"))
    return blur


def with_drawing_settings(given: Mapping[str, object], drawing: LoadedSvg) -> dict[str, Any]:
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
        decided["precision"] = precision_of(drawing)
    return {**decided, **given}


def _has_common_opacity(scene: Scene) -> bool:
    """Return whether all paths are equally translucent, which a minified file states once."""
    opacity = scene.opacity
    return len(opacity) > 1 and bool((opacity == opacity[0]).all()) and float(opacity[0]) < 1.0


def _completed(config: FitConfig, given: Mapping[str, object], goal: Goal, drawing: LoadedSvg) -> FitConfig:
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


def _require_no_change(config: FitConfig, given: Mapping[str, object], drawing: LoadedSvg) -> None:
    """Refuse ``given`` settings that change the paths or paints of the drawing, which only iterations do."""
    asked = {name: getattr(config, name) for name in ("colors", "palette", "gradients", "lod", "min_area")}
    if given.get("curves", len(drawing.scene)) != len(drawing.scene):
        asked = {"curves": config.curves, **asked}
    for name, value in asked.items():
        if value:
            raise InputError(name, "must not be given with 0 iterations", remedy="leave it out, or give iterations")
