"""Draw flat art: outline the regions of a logo, an icon or a drawing by few clean paths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import torch

from warpvec.condition.condition import Condition
from warpvec.condition.jpeg import Jpeg
from warpvec.condition.unrounding import EnlargedRounding, JpegRounding, Rounding
from warpvec.config.fit_config import AUTO, OFF, FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.errors import InputError
from warpvec.fit.loop import single_torch_thread
from warpvec.flat.chains.grid import fits, grid_side
from warpvec.flat.color_layers.layering import layered
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.cutting.cutout import cut_out
from warpvec.flat.cutting.simple_outlines import with_simple_outlines
from warpvec.flat.drawing import FlatDrawing, watch_for_cutting
from warpvec.flat.soft_drawing import SoftDrawing
from warpvec.geometry.scene import Scene
from warpvec.goals.search import meet
from warpvec.modes.detail import Detail
from warpvec.modes.request import Request
from warpvec.polish.drawn_circles import with_drawn_circles
from warpvec.watch.watch import UNWATCHED, Watch


class Refusal(NamedTuple):
    """When a picture is refused; see `warpvec.flat.drawing.FlatDrawing`."""

    may_refuse: bool
    is_doubtful: bool


NEVER = Refusal(may_refuse=False, is_doubtful=False)


@dataclass
class KnownOutlines:
    """The outlines of the last picture, to go on from when only the detail, cutout or goal is another."""

    _work: FlatDrawing | None = None

    def begin(self, request: Request, settings: FitConfig, refusal: Refusal, rounding: Rounding | None) -> FlatDrawing:
        """Return the work on a picture with ``settings``: with the known outlines if they are right for it."""
        image, watch, known = torch.from_numpy(request.picture.reduced), request.watch, self._work
        work = FlatDrawing(image, settings, watch, *refusal, blur=request.picture.blur, rounding=rounding)
        same_damage = known is not None and (known.blur, _jpeg_of(known)) == (work.blur, _jpeg_of(work))
        if known is None or not same_damage or not torch.equal(known.image, image):
            return work
        same = {name: getattr(settings, name) for name in ("detail", "cutout", "strokes", "minify", "paper")}
        like_known = replace(known.config, **same)
        return replace(work, known=known.outlines) if like_known == settings else work

    def keep(self, work: FlatDrawing, request: Request) -> None:
        """Keep the outlines of whole ``work``; interrupted work may have poor ones."""
        if not request.watch.is_over():
            # Without the progress and the renderer of this run.
            self._work = replace(work, watch=UNWATCHED, known=work.outlines)


@dataclass(frozen=True)
class Flat:
    """The mode of flat art.

    Attributes:
        outlines: of the last picture, for a caller that draws it again with another detail; they become those of this
            picture.
        refusal: when to refuse a picture.
        condition: what has happened to the picture; None if nobody looked.
    """

    outlines: KnownOutlines = field(default_factory=KnownOutlines)
    refusal: Refusal = NEVER
    condition: Condition | None = None

    def draw(self, request: Request) -> Drawing:
        """Return the drawing of flat art. A goal decides the detail and, if need be, the number of paths.

        Raises:
            NotFlatArtError: the picture is plainly no flat art, and may be refused.
        """
        with single_torch_thread(), torch.no_grad():
            rounding = rounding_of(request, self.condition)
            work = self.outlines.begin(request, reduced_settings(request), self.refusal, rounding)
            soft = SoftDrawing(work)

            def draw(detail: float) -> Drawing:
                scene, left_out = soft.draw(detail)
                if scene.softness is not None:
                    roughly = soft.clean.outlines.roughly
                    return replace(finished(_as_it_is(request), scene, detail, left_out), roughly=roughly)
                self.outlines.keep(work, request)
                return replace(finished(request, scene, detail, left_out), roughly=work.outlines.roughly)

            return drawn(request, draw)


def _as_it_is(request: Request) -> Request:
    """Return ``request`` for a picture that is not blurred: a drawing with soft paths explains what seemed to be."""
    picture = replace(request.encoding.picture, blur=0.0)
    return replace(request, encoding=replace(request.encoding, picture=picture))


def drawn(request: Request, draw: Callable[[float], Drawing]) -> Drawing:
    """Return what ``draw`` makes with the detail of the settings, or with the detail that the goal asks for."""
    return meet(request.goal, Detail(request, draw)) if request.goal else draw(request.settings.detail)


def rounding_of(request: Request, condition: Condition | None) -> Rounding | None:
    """Return how the copy of the picture was rounded by JPEG, by itself or enlarged; None if it was not.

    In a copy that was reduced to the size of a fit, or without its noise, the rounding cannot be told any more. In that
    of a very large picture, that takes too long.
    """
    if condition is None or condition.jpeg is None or request.picture.is_transparent:
        return None
    picture, enlargement = request.picture, condition.enlargement
    if picture.reduced is picture.pixels:
        return JpegRounding(np.float32(255.0) * picture.pixels, condition.jpeg)
    is_small = picture.width * picture.height <= DRAWING.rounded_pixels_max
    if enlargement is None or any(condition.noise) or not is_small:
        return None
    if picture.reduced_size != (enlargement.height, enlargement.width):
        return None
    return EnlargedRounding(JpegRounding(np.float32(255.0) * picture.pixels, condition.jpeg), enlargement)


def _jpeg_of(work: FlatDrawing) -> Jpeg | None:
    return None if work.rounding is None else work.rounding.jpeg


def reduced_settings(request: Request) -> FitConfig:
    """Return the settings with areas in pixels of the reduced picture. Flat art is drawn on the CPU."""
    picture, settings = request.picture, request.settings
    _check_grid(settings.grid, picture.reduced_size)
    area = settings.min_area * picture.reduced[..., 0].size / picture.pixels[..., 0].size
    return replace(settings, min_area=area, device="cpu")


def _check_grid(grid: str, size: tuple[int, int]) -> None:
    """Refuse a number of units with which a side of a canvas has no whole number of them.

    Raises:
        InputError: it is so.
    """
    if grid not in (AUTO, OFF) and not fits(size, int(grid)):
        rule = f"must give both sides of {size[1]} x {size[0]} pixels whole units, at least a pixel each"
        raise InputError("grid", rule, grid, "give another number, or off")


def finished(request: Request, scene: Scene, detail: float, left_out: dict[str, int]) -> Drawing:
    """Return the drawing of ``scene``, in pixels of the reduced picture, in layers and, if asked, without overlaps."""
    encoding, left_out = request.encoding.of_drawing(), dict(left_out)
    settings = replace(request.settings, detail=detail)
    if settings.cutout:
        if settings.grid not in (AUTO, OFF):  # before the parts are cut, which meet at ticks of the file
            encoding = encoding.on_grid(int(settings.grid))
        scene, more = without_overlaps(scene, encoding, request.watch)
        left_out |= more
    # Who asks for colours, or cuts them out of a material each, wants them apart.
    is_by_color = settings.cutout or settings.colors > 0 or settings.palette is not None
    if request.thin_lines is not None:
        scene = request.thin_lines.with_scene(scene)
    scene = on_paper(scene, settings.paper)
    scene, names = layered(scene, *encoding.picture.reduced_size, joins_shades=not is_by_color)
    encoding = replace(encoding, settings=settings, layer_names=names, simplify=with_simple_outlines)
    # Minified files and parts that are cut out are on no grid unless it is given.
    is_in_pixels = settings.cutout or (encoding.is_minified and settings.grid == AUTO)
    side = 0 if is_in_pixels else grid_side(scene, encoding.picture.reduced_size, settings.grid)
    encoding = encoding.on_grid(side) if side else encoding
    drawing = Drawing.of(scene, encoding, "cpu", left_out=left_out)
    return drawing if side else with_drawn_circles(drawing, request.watch)


def on_paper(scene: Scene, paper: str) -> Scene:
    """Return ``scene`` on white paper if ``paper`` is "keep", on none if it is "remove", and else as it is.

    Paper is what has no colour of its own and is light; other grounds stay.
    """
    if paper == "remove":
        return replace(scene, background=torch.zeros(3), transparent=True)
    ground = torch.ones(3) if scene.transparent else scene.background
    is_light = bool(ground.amin() >= DRAWING.paper_light_min)
    is_gray = bool(ground.amax() - ground.amin() <= DRAWING.paper_tint_max)
    if paper == "keep" and is_light and is_gray:
        return replace(scene, background=torch.ones(3), transparent=False)
    return scene


def without_overlaps(scene: Scene, encoding: Encoding, watch: Watch) -> tuple[Scene, dict[str, int]]:
    """Return ``scene`` without overlaps, with points where the file has ticks, and the number of parts left out."""
    size = encoding.picture.reduced_size
    ticks = [side / whole / 10**encoding.precision for side, whole in zip(size, encoding.size, strict=True)]
    cut = cut_out(scene, size[1], size[0], (ticks[1], ticks[0]), watch_for_cutting(watch, scene))
    parts = {"hidden path": cut.hidden_count, "sliver": cut.sliver_count, "translucent fill": cut.blended_count}
    parts["blur"] = cut.sharpened_count
    return cut.scene, parts
