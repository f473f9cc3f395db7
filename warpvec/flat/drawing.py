"""The stages from a picture of flat art to a drawing of few clean paths."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from warpvec.arrays import Floats
from warpvec.condition.jpeg import Jpeg
from warpvec.condition.unrounding import Rounding
from warpvec.config.fit_config import FitConfig
from warpvec.flat.chains.chains import with_chains
from warpvec.flat.chains.fewer_parts import with_fewer_parts
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.evidence.evidence import ROUNDING, Evidence
from warpvec.flat.explanation import require_shorter, require_shorter_parts
from warpvec.flat.overlay.overlaid_words import Overlay, find_overlay
from warpvec.flat.regions.area_structure import require_plain_areas
from warpvec.flat.regions.fewer_colors import with_colors, with_flat_paints, with_palette
from warpvec.flat.regions.fewer_regions import with_fewer_regions
from warpvec.flat.regions.regions import (
    Regions,
    find_regions,
    require_few_edges,
    unexplained,
)
from warpvec.flat.regions.small_text import small_word_count
from warpvec.flat.regions.unrounded import before_jpeg
from warpvec.flat.scene_building import scene_of
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.fewer_paths import with_fewer_paths
from warpvec.flat.simplification.fewer_stops import with_fewer_stops
from warpvec.flat.simplification.forms import find_forms
from warpvec.flat.simplification.path_removal import remove_paths
from warpvec.flat.simplification.regularity import regularize
from warpvec.flat.simplification.whole_levels import with_whole_levels
from warpvec.flat.strokes.pen_dots import with_pen_dots
from warpvec.flat.strokes.recognition import find_strokes
from warpvec.flat.strokes.stroke import Stroke, with_strokes
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.image.colors import parse_color
from warpvec.polish.polish import PATHS_EXACT_MAX, polish
from warpvec.watch.watch import Watch


class FlatOutlines(NamedTuple):
    """Outlines of the regions of a picture, with more nodes than they need.

    Attributes:
        traced: a path for each region, numbered by its generation, so that a path that stays finds its colour again.
        picture: the picture [h, w, 3 or 4] whose regions these are; of a JPEG, the picture before it was saved.
        fitted: the paths that the settings allow, fitted to the picture.
        roughly: number of parts of the picture that they show only roughly, or not at all, by their name: "area",
            "gradient" and "small word".
        noise: noise of the picture, in [0, 1].
    """

    traced: Scene
    picture: Tensor
    fitted: Scene
    roughly: dict[str, int]
    noise: float = 0.0


@dataclass(frozen=True)
class FlatDrawing:
    """The work on one picture of flat art.

    Attributes:
        image: the picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        config: settings of the run.
        watch: progress, stop, clock and history of the run.
        may_refuse: whether a picture that is plainly no flat art is refused; see `NotFlatArtError`.
        is_doubtful: whether one is refused that a photo says more briefly.
        known: outlines that are known already; None to find them.
        tracing: outlines that were traced in another way; None to trace those of the regions.
        blur: standard deviation in pixels of the blur of the picture, which the drawing is without.
        rounding: how the picture was rounded when it was saved as JPEG, which the drawing is without; None for no JPEG.
    """

    image: Tensor
    config: FitConfig
    watch: Watch = field(default_factory=Watch)
    may_refuse: bool = False
    is_doubtful: bool = False
    known: FlatOutlines | None = None
    tracing: Scene | None = None
    blur: float = 0.0
    rounding: Rounding | None = None

    @property
    def is_small(self) -> bool:
        """Whether the picture is so small that it is likely to be shown larger."""
        return max(self.image.shape[:2]) <= DRAWING.small_side

    @property
    def _is_fine(self) -> bool:
        """Whether the picture is as small as an icon, so that its outlines need a finer grid and tension."""
        return max(self.image.shape[:2]) <= DRAWING.fine_side

    @cached_property
    def critic(self) -> Critic:
        """The judge of all changes."""
        tension = DRAWING.tension if self._is_fine else 0.0
        return Critic(self.picture, self.config, self.blur, tension, self._variance)

    @cached_property
    def _variance(self) -> Floats | None:
        """Squared deviation of the pixels of a JPEG from their drawing [h, w], as of `Critic`; None for others."""
        return None if self.jpeg is None else (self.evidence.variance - ROUNDING) / 255.0**2

    @cached_property
    def evidence(self) -> Evidence:
        """What the picture says, as it is."""
        return Evidence.of(self.image.numpy(), self.jpeg)

    @property
    def picture(self) -> Tensor:
        """The picture [h, w, 3 or 4] to be drawn, as it was before it was saved as JPEG.

        Raises:
            NotFlatArtError: the picture is plainly no flat art, and may be refused.
        """
        if self.known is not None:
            return self.known.picture
        return self.image if self.tracing is not None else self._found[0]

    @cached_property
    def outlines(self) -> FlatOutlines:
        """The outlines of the regions.

        Raises:
            NotFlatArtError: the picture is plainly no flat art, and may be refused.
        """
        if self.known is not None:
            return self.known
        traced, roughly = self._traced_regions() if self.tracing is None else (self.tracing, {})
        traced = replace(traced, generation=torch.arange(len(traced)))
        fewer = with_fewer_paths(traced, self.critic, self.config.curves)
        roughly["area"] = roughly.get("area", 0) + len(traced) - len(fewer)
        noise = self._found[1].noise if self.tracing is None else 0.0
        return FlatOutlines(traced, self.picture, self._polished(fewer, DRAWING.first_iterations), roughly, noise)

    def draw(self, detail: float) -> tuple[Scene, dict[str, int]]:
        """Return the drawing with the nodes and paths that show at ``detail`` pixels, and what it leaves out.

        That is counted by its name: "path", "loop" and "node". Outlines of small pictures may move by less than
        ``detail``, unless a form explains them; see `DRAWING.small_detail`.

        Raises:
            NotFlatArtError: the picture is plainly no flat art, and may be refused.
        """
        fine = detail * (DRAWING.small_detail if self.is_small else 1.0)
        scene, watch, left_out = self.outlines.fitted, self.watch, dict[str, int]()
        if not self._is_late(scene):
            watch.tell("removing what is not seen")
            fewer, loop_count = remove_paths(scene, self.critic, watch, fine)
            scene, left_out = fewer, {"path": len(scene) - len(fewer), "loop": loop_count}
        if len(scene) and not self._is_late(scene):
            count = len(scene.segments)
            watch.tell("simplifying outlines")
            scene = with_fewer_parts(scene, self.critic, watch, fine)
            left_out["node"] = count - len(scene.segments)
            scene = with_fewer_stops(scene, self.critic, watch)
            scene = self._polished(scene, DRAWING.last_iterations)
            scene = with_whole_levels(scene, self.critic, watch)
            # Last, as a fit would undo exact ellipses.
            scene = regularize(scene, self.critic, watch, detail)
            watch.tell("looking for lines and circles")
            # A file of parts without overlaps has outlines only.
            is_wanted = self.config.strokes != "off" and not self.config.cutout
            count, strokes = len(self.outlines.traced), dict[int, Stroke]()
            if is_wanted:
                scene, strokes = find_strokes(scene, self.critic, watch, fine, count)
            is_stroke = torch.isin(scene.generation, torch.tensor(list(strokes), dtype=torch.int64))
            scene = with_strokes(find_forms(scene, self.critic, watch, detail, is_stroke.numpy()), strokes)
            scene = replace(scene, generation=scene.generation % count)
            watch.tell("joining curves")
            scene = with_chains(scene, self.critic, watch, detail)
        return with_pen_dots(self._snapped(scene)), left_out

    @cached_property
    def rough(self) -> Regions:
        """The regions of the picture as it is.

        Raises:
            NotFlatArtError: the picture is plainly no flat art, and may be refused.
        """
        image, watch = self.image.numpy(), self.watch.ahead(DRAWING.share_after_tracing)
        if self.is_doubtful:
            require_shorter_parts(image, self.jpeg, watch)
        return find_regions(image, self.config.min_area, watch, self.may_refuse, is_jpeg=self.rounding is not None)

    @cached_property
    def _found(self) -> tuple[Tensor, Regions]:
        """The picture before it was saved as JPEG, and its regions."""
        image, watch, found = self.image.numpy(), self.watch.ahead(DRAWING.share_after_tracing), self.rough
        if self.is_doubtful:
            require_shorter(found, self.evidence)
        if self.may_refuse:
            require_few_edges(found)
            if self.rounding is None:
                require_plain_areas(found, image)
        if self.rounding is None or self.image.shape[2] == 4:
            return self.image, found
        before, found = before_jpeg(image, found, self.rounding, self.config.min_area, watch)
        return torch.from_numpy(before), found

    @property
    def jpeg(self) -> Jpeg | None:
        """What the picture was saved as; None for no JPEG, or if it was enlarged before."""
        return self.rounding.jpeg if self.rounding is not None and self.rounding.factor == 1.0 else None

    def _traced_regions(self) -> tuple[Scene, dict[str, int]]:
        found, overlay = self._found[1], self._overlay()
        if overlay is not None:
            below = find_regions(overlay.ground, self.config.min_area, self.watch.ahead(DRAWING.share_after_tracing))
            found, overlay = (below, overlay) if self._is_better(overlay, below) else (found, None)
        fewer = with_fewer_regions(found, REGIONS.regions_max)
        regions = self._repainted(fewer)
        gradient_count = int((fewer.paints.kind != FLAT).sum()) - int((regions.paints.kind != FLAT).sum())
        roughly = {
            "area": len(found) - len(fewer),
            "gradient": gradient_count,
            "small word": small_word_count(found),
        }
        tolerance = DRAWING.small_tolerance if self.is_small else CURVES.tolerance
        is_fine = self._is_fine and self.blur == 0.0
        scene = self._on_canvas(scene_of(regions, tolerance, self.watch, is_fine))
        if overlay is not None:
            roughly["small word"] += small_word_count(overlay.words)
            scene = scene.joined(scene_of(overlay.words, tolerance, self.watch))
        return scene, roughly

    def _is_better(self, overlay: Overlay, below: Regions) -> bool:
        """Return whether words and the regions ``below`` them explain the picture better than its regions, in time."""
        image, found = self._found[0].numpy(), self._found[1]
        words = overlay.words.mixed()
        both = words + (1.0 - words[..., 3:]) * below.mixed()
        is_nearer = unexplained(both, image) < unexplained(found.mixed(), image)
        return is_nearer and not self.watch.ahead(DRAWING.share_after_tracing).is_over()

    def _overlay(self) -> Overlay | None:
        """Return the words over several grounds; None if there are none, or no time, or the colours are chosen."""
        picture, found = self._found
        has_colors = bool(self.config.colors) or self.config.palette is not None
        watch = self.watch.ahead(DRAWING.share_after_words)
        is_wanted = not has_colors and self.blur == 0.0 and not watch.is_over()
        return find_overlay(picture.numpy(), found, watch) if is_wanted else None

    def _on_canvas(self, scene: Scene) -> Scene:
        """Return ``scene`` with a canvas if the picture is opaque: that of its lowest path if no region is one."""
        if not len(scene):  # tensors of no rows that come from NumPy have strides that kernels refuse
            scene = replace(scene, color=torch.zeros(0, 3), opacity=torch.zeros(0))
        if self.image.shape[2] == 4 or not scene.transparent:
            return scene
        background = scene.color[0] if len(scene) else torch.ones(3)
        return replace(scene, background=background.clone(), transparent=False)

    def _is_late(self, scene: Scene) -> bool:
        """Return whether the time is over, or too short for a step with the very many coordinates of ``scene``."""
        share = DRAWING.share_after_long_steps if _has_many_values(scene) else 0.0
        return self.watch.ahead(max(share, self._share_after(scene))).is_over()

    def _share_after(self, scene: Scene) -> float:
        """Return the share of a time budget that must be left after the fits of ``scene``."""
        return DRAWING.share_for_cutting if self.config.cutout and _has_many_values(scene) else 0.0

    def _polished(self, scene: Scene, iterations: int) -> Scene:
        if not len(scene) or self._is_late(scene):
            return scene
        is_small = len(scene) <= PATHS_EXACT_MAX and scene.segments.numel() <= SIMPLIFICATION.values_exact_max
        if _has_many_values(scene):
            iterations //= 2
        steps = iterations if is_small else DRAWING.gradient_steps * iterations
        count = min(steps, self.config.iterations)
        planned = max(DRAWING.first_iterations + DRAWING.last_iterations, self.watch.iterations + count)
        return polish(
            self.critic.target, scene, self.config, self.watch.part(planned=planned, left=self._share_after(scene)),
            iterations=count, values_exact_max=SIMPLIFICATION.values_exact_max, unseen=SIMPLIFICATION.unseen,
            tension=self.critic.tension(scene),
        ).scene  # fmt: skip

    def _repainted(self, regions: Regions) -> Regions:
        if self.config.opacity == "opaque":
            opacity = np.where(regions.paints.opacity >= 0.5, 1.0, 0.0).astype(np.float32)
            regions = replace(regions, paints=replace(regions.paints, opacity=opacity))
        if self.config.palette is not None:
            palette = np.array([parse_color(name) for name in self.config.palette.split(",")], np.float64)
            return with_palette(regions, palette)
        if self.config.colors:
            return with_colors(regions, self.config.colors)
        return regions if self.config.gradients != 0.0 else with_flat_paints(regions)

    def _snapped(self, scene: Scene) -> Scene:
        """Return ``scene`` with the colours of the regions, where the fitted ones hardly differ or paths share one."""
        traced = self.outlines.traced
        color = traced.color[scene.generation]
        is_bound = bool(self.config.colors or self.config.palette)
        snap = math.inf if is_bound else max(DRAWING.snap, DRAWING.snap_noise * self.outlines.noise)
        is_shared = (color[:, None] == color[None]).all(2).sum(1) > 1
        limit = torch.where(is_shared, max(snap, DRAWING.snap_shared), snap)
        is_near = (scene.color - color).abs().amax(1) <= limit
        for gradients, rows in ((scene.gradients, slice(None)), (traced.gradients, scene.generation)):
            if gradients is not None:
                is_near &= (gradients.kind == FLAT)[rows]
        background = snapped_canvas(scene.background, traced.background, max(snap, DRAWING.snap_canvas))
        return replace(scene, color=torch.where(is_near[:, None], color, scene.color), background=background)


def snapped_canvas(fitted: Tensor, traced: Tensor, limit: float) -> Tensor:
    """Return the colour [3] that a canvas was ``traced`` in, or white, if the ``fitted`` one is that within ``limit``.

    The page of a small icon has few pixels of its own, so that a fit takes it for what is left of the edges.
    """
    for known in (traced, torch.ones_like(fitted)):
        if bool((fitted - known).abs().amax() <= limit):
            return known
    return fitted


def watch_for_cutting(watch: Watch, scene: Scene) -> Watch:
    """Return the watch for cutting ``scene``: little time left means less care for one of very many coordinates."""
    return watch.ahead(DRAWING.share_for_cutting) if _has_many_values(scene) else watch


def _has_many_values(scene: Scene) -> bool:
    return scene.segments.numel() > DRAWING.many_values
